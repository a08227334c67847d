// Tests: coverage/operator/operator_display, coverage/operator/run_with_display.
//
// The display in a real window, under a display server without a screen (ctest starts this under xvfb-run):
// the window's own plumbing, and whole captures whose window is closed.
#include <gmock/gmock.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <thread>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/light_field/folder/light_field_io.h"
#include "coverage/operator/operator_display.h"
#include "tests/support/child_process.h"
#include "tests/support/floors.h"
#include "tests/support/staged_capture.h"
#include "tests/support/test_paths.h"
#include "tests/support/test_run.h"
#include "tests/support/x11_person.h"

namespace ulf::test::window_test {
namespace {

using ::testing::HasSubstr;

TEST(Window, ShowsWhatThePictureWithoutAWindowShows) {
  StagedCapture capture;
  capture.RecordRows(-10, 10, -5, 5, 5);
  const auto state = capture.At(capture.CameraAt(3, 2));
  const auto draw = [&](Surface& surface) {
    CaptureFeed feed;
    CaptureRequests requests;
    OperatorDisplay display(surface, feed, requests);
    feed.Publish(state);
    display.Step();
    surface.Bind();
    return surface.Read();
  };
  cv::Mat in_window, without;
  {
    const auto window = OpenWindow("ulf test", {800, 600});
    ASSERT_EQ(window->Size(), cv::Size(800, 600));
    // Read before it is presented: afterwards a window's buffer is anybody's.
    class Unpresented : public Surface {
     public:
      explicit Unpresented(Surface& of) : of_(of) {}
      cv::Size Size() const override { return of_.Size(); }
      double ContentScale() const override { return of_.ContentScale(); }
      std::vector<InputEvent> TakeEvents(double) override { return {}; }
      void Bind() override { of_.Bind(); }
      void Present() override {}
      void ToggleFullScreen() override {}

     private:
      Surface& of_;
    } unpresented(*window);
    in_window = draw(unpresented);
  }
  OffscreenSurface surface({800, 600});
  without = draw(surface);
  EXPECT_LT(cv::norm(in_window, without, cv::NORM_L1) / static_cast<double>(without.total() * 3), 0.5);
}

TEST(Window, KeysWheelMouseAndCloseButtonAreEvents) {
  const auto window = OpenWindow("ulf test", {400, 300});
  X11Person person("ulf test");
  person.Press("Left");
  person.Press("q");
  person.MoveMouse(120, 80);
  person.Click(1);
  person.Click(4);  // the wheel, away
  person.CloseWindow();
  bool key = false, typed = false, moved = false, clicked = false, wheel = false, close = false;
  for (int i = 0; i < 100 && !(key && typed && moved && clicked && wheel && close); ++i)
    for (const InputEvent& event : window->TakeEvents(0.05)) {
      if (const auto* k = std::get_if<KeyPressed>(&event)) key = key || k->key == Key::kLeft;
      if (const auto* t = std::get_if<Typed>(&event)) typed = typed || t->character == U'q';
      if (const auto* m = std::get_if<MouseMoved>(&event)) moved = moved || m->at == Eigen::Vector2d(120, 80);
      if (const auto* b = std::get_if<MouseButton>(&event)) clicked = clicked || (b->button == 0 && b->down);
      if (const auto* w = std::get_if<WheelTurned>(&event)) wheel = wheel || w->steps > 0;
      close = close || std::holds_alternative<CloseAsked>(event);
    }
  EXPECT_TRUE(key);
  EXPECT_TRUE(typed);
  EXPECT_TRUE(moved);
  EXPECT_TRUE(clicked);
  EXPECT_TRUE(wheel);
  EXPECT_TRUE(close);
}

TEST(Window, GoesFullScreenAndBack) {
  const auto window = OpenWindow("ulf test", {400, 300});
  window->ToggleFullScreen();
  for (int i = 0; i < 20 && window->Size() == cv::Size(400, 300); ++i) window->TakeEvents(0.05);
  EXPECT_GT(window->Size().area(), 400 * 300);
  window->ToggleFullScreen();
  for (int i = 0; i < 20 && window->Size() != cv::Size(400, 300); ++i) window->TakeEvents(0.05);
  EXPECT_EQ(window->Size(), cv::Size(400, 300));
}

// Requests that begin the recording as soon as there is a subject.
std::string BeginsIn(const ScratchFolder& scratch) {
  const std::string lines = scratch / "lines";
  std::ofstream(lines) << "record\n";
  return lines;
}

std::size_t Photographs(const std::filesystem::path& dir) {
  std::error_code none;
  std::size_t count = 0;
  for ([[maybe_unused]] const auto& file : std::filesystem::directory_iterator(dir / "images", none)) ++count;
  return count;
}

bool WaitForPhotographs(const std::filesystem::path& dir) {
  for (int i = 0; i < 1500 * kPatience && Photographs(dir) == 0; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  return Photographs(dir) > 0;
}

// Whichever way the window ends, the capture ends as its button ends it.
void ExpectClosed(const std::function<void(X11Person&)>& close) {
  const ScratchFolder scratch;
  const auto dir = scratch.path() / "lf";
  ChildProcess capture({std::getenv("ULF_BINARY"), "capture", "sim:studio?width=320&height=240&fps=15", "-o",
                        dir.string(), "--json", "--requests", BeginsIn(scratch)});
  X11Person person("ulf capture");
  ASSERT_TRUE(WaitForPhotographs(dir));
  close(person);
  const std::string output = capture.ReadUntil("stopped_because", 60);
  EXPECT_EQ(capture.Wait(60), 0);
  EXPECT_THAT(output, HasSubstr("\"stopped_because\":\"closed\""));
  const LightField light_field = ReadLightField(dir);
  EXPECT_GT(light_field.views.size(), 0u);
  EXPECT_TRUE(std::filesystem::exists(dir / "transforms.json"));
}

TEST(Window, ClosedInMidCaptureClosesTheLightField) {
  ExpectClosed([](X11Person& person) { person.CloseWindow(); });
}

TEST(Window, DestructionFromOutsideClosesTheLightField) {
  ExpectClosed([](X11Person& person) { person.DestroyWindow(); });
}

TEST(Window, KillFromOutsideClosesTheLightField) {
  ExpectClosed([](X11Person& person) { person.KillClient(); });
}

TEST(Window, DestructionFromOutsideAsksToClose) {
  const auto window = OpenWindow("ulf test", {400, 300});
  EXPECT_EQ(window->Size(), cv::Size(400, 300));
  X11Person("ulf test").DestroyWindow();
  bool close = false;
  for (int i = 0; i < 100 && !close; ++i) {
    EXPECT_EQ(window->Size(), cv::Size(400, 300));
    for (const InputEvent& event : window->TakeEvents(0.05))
      close = close || std::holds_alternative<CloseAsked>(event);
  }
  EXPECT_TRUE(close);
  window->Bind();
  window->Present();
  window->ToggleFullScreen();
}

// On a display server of its own, which is killed in mid-capture.
TEST(Window, CaptureSurvivesADyingDisplayServer) {
  const ScratchFolder scratch;
  const auto dir = scratch.path() / "lf";
  const std::string errors = scratch / "errors";
  ChildProcess server({"/usr/bin/Xvfb", "-displayfd", "1", "-screen", "0", "800x600x24"});
  const std::string display = ":" + std::to_string(std::stoi(server.ReadUntil("\n", 30)));
  ChildProcess capture(
      {"/bin/bash", "-c",
       fmt::format("exec env DISPLAY={} {} capture 'sim:studio?width=320&height=240&fps=30' "
                   "--frames 75 --json --requests {} -o {} 2> {}",
                   display, std::getenv("ULF_BINARY"), BeginsIn(scratch), dir.string(), errors)});
  { const X11Person person("ulf capture", display); }
  ASSERT_TRUE(WaitForPhotographs(dir));
  const std::size_t before = Photographs(dir);
  server.Kill();
  const std::string output = capture.ReadUntil("stopped_because", 60);
  EXPECT_EQ(capture.Wait(60), 0);
  EXPECT_THAT(output, HasSubstr("\"stopped_because\":\"frames\""));
  EXPECT_THAT(output, HasSubstr("\"frames\":75"));
  const std::string said = ReadWholeFile(errors);
  EXPECT_THAT(said, HasSubstr("the operator display is gone (the display server has ended); the capture goes "
                              "on without it"));
  EXPECT_THAT(said, ::testing::Not(HasSubstr("fatal")));
  const LightField light_field = ReadLightField(dir);
  EXPECT_GT(light_field.views.size(), before) << "nothing was recorded after it";
  EXPECT_EQ(Photographs(dir), light_field.views.size());
  EXPECT_TRUE(std::filesystem::exists(dir / "transforms.json")) << "closed";
}

TEST(Window, MayBeDestroyedAfterItsDisplayServer) {
  ChildProcess server({"/usr/bin/Xvfb", "-displayfd", "1", "-screen", "0", "800x600x24"});
  const std::string display = ":" + std::to_string(std::stoi(server.ReadUntil("\n", 30)));
  const char* usual = std::getenv("DISPLAY");
  const std::string before = usual ? usual : "";
  setenv("DISPLAY", display.c_str(), 1);
  auto window = OpenWindow("ulf test", {400, 300});
  setenv("DISPLAY", before.c_str(), 1);
  EXPECT_EQ(window->Size(), cv::Size(400, 300));
  server.Kill();
  EXPECT_THROW(
      {
        for (int i = 0; i < 100; ++i) {
          window->TakeEvents(0.01);
          window->Bind();
          window->Present();
        }
      },
      SurfaceGone);
  EXPECT_THROW(window->Size(), SurfaceGone) << "for good";
  window.reset();
}

TEST(Window, WithoutADisplayServerTheCaptureGoesOn) {
  const ScratchFolder scratch;
  const std::string command = std::string("env -u DISPLAY -u WAYLAND_DISPLAY ") + std::getenv("ULF_BINARY") +
                              " capture 'sim:studio?width=320&height=240' --frames 60 -o " +
                              (scratch / "lf").string() + " 2>&1";
  ChildProcess capture({"/bin/bash", "-c", command});
  EXPECT_THAT(capture.ReadUntil("capturing without the operator display", 30),
              HasSubstr("capturing without the operator display"));
  EXPECT_EQ(capture.Wait(60), 0);
  EXPECT_GT(ReadLightField(scratch / "lf").views.size(), 0u);
}

}  // namespace
}  // namespace ulf::test::window_test
