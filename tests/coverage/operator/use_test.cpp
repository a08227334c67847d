// Tests: coverage/operator/run_with_display.
//
// A capture as it is used: tracked in one thread, mapped in another, written in others, displayed in this
// one, while everything that the display offers is asked for again and again. Three minutes of the
// camera's time every day, in which every key is pressed three times;
// `./run test --long` runs twenty minutes of it under each of the sanitizers, and twenty with ten times the
// frames without any: nothing may race, nothing may leak, and memory must not grow once there is nothing more
// to record.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <utility>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define ULF_SANITIZED
extern "C" std::size_t __sanitizer_get_current_allocated_bytes();  // GCC ships no header for it
#endif

#include "acquisition/device/device.h"
#include "core/light_field/light_field_io.h"
#include "coverage/operator/run_with_display.h"
#include "coverage/session/capture_session.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"
#include "tracking/sources/pose_source.h"

namespace ulf::test {
namespace {

double Asked(const char* variable, double usual) {
  const char* asked = std::getenv(variable);
  return asked ? std::atof(asked) : usual;
}

double ResidentMb() {
  std::ifstream file("/proc/self/statm");
  double pages = 0, resident = 0;
  file >> pages >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

// In use, without what the allocator keeps for later.
double UsedMb() {
#ifdef ULF_SANITIZED
  return static_cast<double>(__sanitizer_get_current_allocated_bytes()) / 1e6;
#else
  const auto info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd) / 1e6;
#endif
}

// A person who presses one key after the other, one a second of the camera's, however slow the machine is.
class BusyPerson : public OffscreenSurface {
 public:
  BusyPerson(const CaptureFeed& feed, int& shown)
      : OffscreenSurface({640, 480}), feed_(feed), shown_(shown) {}
  void Present() override {
    OffscreenSurface::Present();
    ++shown_;
  }
  std::vector<InputEvent> TakeEvents(double patience_s) override {
    const auto now = feed_.Newest();
    const double second = now ? std::floor(now->device_time_s + 0.25) : second_;
    if (std::exchange(second_, second) != second) Push(Next());
    return OffscreenSurface::TakeEvents(patience_s);
  }

 private:
  InputEvent Next() {
    static const std::vector<InputEvent> kRound{
        Typed{U'i'}, Typed{U'?'}, Typed{U'?'}, Typed{U'p'}, Typed{U'l'}, Typed{U'l'}, Typed{U'e'},
        Typed{U'e'}, Typed{U' '}, Typed{U' '},
        // Two views back.
        KeyPressed{Key::kBackspace}, KeyPressed{Key::kBackspace},
        // The subject: focused through its aperture, moved, and left as it was.
        Typed{U's'}, Typed{U'a'}, KeyPressed{Key::kUp}, WheelTurned{1}, KeyPressed{Key::kRight},
        KeyPressed{Key::kLeft, true}, Typed{U'a'}, KeyPressed{Key::kEscape},
        // And placed anew.
        Typed{U's'}, Typed{U'c'}, KeyPressed{Key::kPageUp}, KeyPressed{Key::kPageDown},
        KeyPressed{Key::kEnter},
        // What is recorded: from the live camera, round the subject, against the live picture.
        Typed{U'r'}, KeyPressed{Key::kDelete}, Typed{U'w'}, Typed{U'.'}, Typed{U'b'}, Typed{U'b'},
        Typed{U'c'}, KeyPressed{Key::kLeft}, MouseMoved{{300, 200}}, MouseButton{0, true},
        MouseMoved{{340, 220}}, MouseButton{0, false}, KeyPressed{Key::kPageUp}, KeyPressed{Key::kPageDown},
        Typed{U','}, Typed{U'r'}, Typed{U'z'}, Typed{U'z'}, KeyPressed{Key::kF1}, KeyPressed{Key::kF1},
        KeyPressed{Key::kF11}, Typed{U'f'}};
    return kRound[pressed_++ % kRound.size()];
  }
  const CaptureFeed& feed_;
  int& shown_;
  double second_ = -1;
  std::size_t pressed_ = 0;
};

TEST(Use, OfEverythingThatTheDisplayOffersDuringACapture) {
  const ScratchFolder scratch;
  const double fps = Asked("ULF_USE_FPS", 1);  // slow, for the sanitizers' sake: a degree from frame to frame
  const std::string uri =
      fmt::format("sim:studio?width=320&height=240&fps={}&seed=11&row_deg=5&speed_deg_s=1", fps);
  const auto device = OpenDevice(uri);
  device->Start();
  const auto first = device->Next(std::chrono::seconds(5));
  ASSERT_TRUE(first);
  const CameraModel camera = *device->Camera();
  const auto poses = MakeTrackerSource(camera, {});
  CaptureOptions options;
  options.cap = Cap::ParseDegrees("60x40");
  options.until_share = 2;  // never: what is left is looked at until the time is over
  options.threshold_px = 12;
  options.geometry = true;
  options.coverage_width_px = 320;
  options.max_seconds = 60 * Asked("ULF_USE_MINUTES", 3);
  CaptureFeed feed;
  CaptureRequests requests;
  CaptureHooks hooks;
  hooks.requests = &requests;
  // The least of the second and of the last quarter: an open review needs its memory while it is open.
  constexpr double kMuch = 1e9;
  double early_mb = kMuch, late_mb = kMuch, early_used_mb = kMuch, late_used_mb = kMuch;
  const double starts_s = first->device_time_s;
  hooks.after_frame = [&](const SharedCaptureState& state) {
    feed.Publish(state);
    const double share = (state->device_time_s - starts_s) / options.max_seconds;
    if (share > 0.25 && share < 0.5)
      early_mb = std::min(early_mb, ResidentMb()), early_used_mb = std::min(early_used_mb, UsedMb());
    if (share > 0.75)
      late_mb = std::min(late_mb, ResidentMb()), late_used_mb = std::min(late_used_mb, UsedMb());
  };
  CaptureHeader header;
  header.camera = camera;
  int shown = 0;
  CaptureSummary summary;
  RunWithDisplay([&] { return std::make_unique<BusyPerson>(feed, shown); }, {}, feed, requests,
                 [&] {
                   summary =
                       RunCapture(*device, camera, *poses, LightFieldWriter::Create(scratch / "lf", header),
                                  options, hooks, {*first});
                 });
  EXPECT_EQ(summary.stopped_because, StoppedBecause::kSeconds);
  EXPECT_GT(shown, 0.1 * static_cast<double>(summary.frames)) << "the display went away";
  EXPECT_GT(summary.frames, 0.95 * fps * options.max_seconds);
  const LightField light_field = ReadLightField(scratch / "lf");
  RecordProperty("views", std::to_string(light_field.views.size()));
  EXPECT_GT(light_field.views.size(), 5u);
  for (const View& view : light_field.views)
    EXPECT_TRUE(std::filesystem::exists(light_field.root / view.image_path)) << view.id;
  std::size_t taken_back = 0;
  for ([[maybe_unused]] const auto& kept : std::filesystem::directory_iterator(scratch / "lf" / "unposed"))
    ++taken_back;
  EXPECT_GT(taken_back, 0u) << "views that were taken back are kept";
  RecordProperty("early_mb", std::to_string(early_mb));
  RecordProperty("late_mb", std::to_string(late_mb));
  RecordProperty("early_used_mb", std::to_string(early_used_mb));
  RecordProperty("late_used_mb", std::to_string(late_used_mb));
  // Views are still recorded in the second half, at a few hundred kB each, and a map comes and goes. Caches of the review,
  // its threads and the software renderer's compiler take some 120 MB in the first 150 frames: a short run is still
  // filling them.
  const bool is_long = summary.frames >= 600;
#ifndef ULF_SANITIZED  // a sanitizer's allocator gives freed pages back late or never
  EXPECT_LT(late_mb, 1.1 * early_mb + (is_long ? 80 : 160));
#endif
  EXPECT_GT(early_used_mb, 1);
  EXPECT_LT(late_used_mb, 1.1 * early_used_mb + (is_long ? 35 : 80));
}

}  // namespace
}  // namespace ulf::test
