// Tests: coverage/operator/run_with_display.
//
// A capture as it is used: tracked in one thread, mapped in another, written in others, displayed in this
// one, while everything that the display offers is asked for again and again. A minute and a half of the
// camera's time every day, in which every key is pressed twice;
// `./run test --long` runs twenty minutes of it under each of the sanitizers, and twenty with ten times
// the frames without any: nothing may race, nothing may leak, and memory must not grow beyond what new
// views explain.
//
//   ULF_USE_MINUTES of the camera's time (1.6) ULF_USE_FPS frames a second of it (1) ULF_USE_WIDTH of the
//   picture, 4:3 (320) ULF_USE_PACED=1 frames come no faster than a live camera sends them, and the minutes
//   are the clock's; else they
//                      come as fast as they are taken
//   ULF_USE_ROW_DEG    between the rows of the hand (5): the finer, the longer there are new viewpoints
//   ULF_USE_THRESHOLD  px (12)
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "acquisition/device/replay_device.h"
#include "acquisition/opening/open_device.h"
#include "core/base/available_memory.h"
#include "core/base/host_time.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "coverage/operator/run_with_display.h"
#include "coverage/session/capture_session.h"
#include "tests/support/floors.h"
#include "tests/support/growth/capture_growth.h"
#include "tests/support/test_paths.h"
#include "tracking/sources/poses_spec.h"

namespace ulf::test::use_test {
namespace {

double Asked(const char* variable, double usual) {
  const char* asked = std::getenv(variable);
  return asked ? std::atof(asked) : usual;
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

TEST(Use, ExercisesEverythingTheDisplayOffers) {
  ShareHeaps();
  const ScratchFolder scratch;
  const double fps = Asked("ULF_USE_FPS", 1);  // slow, for the sanitizers' sake: a degree from frame to frame
  const int width = static_cast<int>(Asked("ULF_USE_WIDTH", 320));
  const std::string uri = fmt::format("sim:studio?width={}&height={}&fps={}&seed=11&row_deg={}&speed_deg_s=1",
                                      width, width * 3 / 4, fps, Asked("ULF_USE_ROW_DEG", 5));
  auto device = OpenDevice(uri);
  const bool paced = Asked("ULF_USE_PACED", 0) > 0;
  if (paced) device = acquisition::MakePacedDevice(std::move(device), 1);
  device->Start();
  const auto first = device->Next(std::chrono::seconds(5));
  ASSERT_TRUE(first);
  const CameraModel camera = *device->Camera();
  const auto poses = MakeTrackerSource(camera, {});
  CaptureOptions options;
  options.cap = Cap::ParseDegrees("60x40");
  options.until_share = 2;  // never: what is left is looked at until the time is over
  options.threshold_px = Asked("ULF_USE_THRESHOLD", 12);
  options.geometry = true;
  options.coverage_width_px = width;
  options.max_seconds = 60 * Asked("ULF_USE_MINUTES", 1.6);
  CaptureFeed feed;
  CaptureRequests requests;
  CaptureHooks hooks;
  hooks.requests = &requests;
  GrowthLog growth(scratch / "lf");
  const double row_s = std::min(60.0, options.max_seconds / 12), starts_s = first->device_time_s;
  double row_ends_s = row_s;
  const auto began = std::chrono::steady_clock::now();
  hooks.stop_requested = [&] { return paced && SecondsSince(began) > options.max_seconds; };
  fmt::print("{}\n", GrowthHead());
  hooks.keep_frame = [&](const Frame&) { growth.FrameComes(); };
  hooks.after_frame = [&](const SharedCaptureState& state) {
    growth.FrameIsDone(*state);
    feed.Publish(state);
    if ((paced ? SecondsSince(began) : state->device_time_s - starts_s) < row_ends_s) return;
    row_ends_s += row_s;
    fmt::print("{}\n", GrowthLine(growth.EndRow()));
    std::fflush(stdout);
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
  EXPECT_EQ(summary.stopped_because, paced ? StoppedBecause::kSignal : StoppedBecause::kSeconds);
  EXPECT_GT(shown, 0.1 * static_cast<double>(summary.frames)) << "the display went away";
  if (!paced) {
    EXPECT_GT(static_cast<double>(summary.frames), 0.95 * fps * options.max_seconds);
  }
  const LightField light_field = ReadLightField(scratch / "lf");
  RecordProperty("views", std::to_string(light_field.views.size()));
  EXPECT_GT(light_field.views.size(), 5u);
  for (const View& view : light_field.views)
    EXPECT_TRUE(std::filesystem::exists(light_field.root / view.image_path)) << view.id;
  std::size_t taken_back = 0;
  for ([[maybe_unused]] const auto& kept : std::filesystem::directory_iterator(scratch / "lf" / "unposed"))
    ++taken_back;
  EXPECT_GT(taken_back, 0u) << "views that were taken back are kept";
  fmt::print("{} frames, {} dropped, {} views, {} taken back\n", summary.frames, summary.device.dropped,
             light_field.views.size(), taken_back);
  // A map and a review come and go; and in the first 150 frames the review, its threads and the software
  // renderer's compiler take some 120 MB. A view keeps its pictures for display and geometry.
  const bool is_long = summary.frames >= 600;
  const double pixels = width / 640.0 * width / 640;
  EXPECT_EQ(WhatGrows(growth.rows(), {.mb_a_view = 0.5 * pixels,
                                      .resident_mb_a_view = 4 * pixels,
                                      .mb = is_long ? 80.0 : 160.0,
                                      .time_share = is_long ? 1.0 : 3.0,
                                      .disk_share = is_long ? 0.5 : 3.0}),
            "");
}

}  // namespace
}  // namespace ulf::test::use_test
