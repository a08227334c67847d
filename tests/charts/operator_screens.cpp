// The operator display's screens for the documentation: every mode from a staged capture of the simulated
// studio, drawn without a window. `operator_screens FOLDER` writes FOLDER/operator_*.jpg.
#include <fmt/core.h>

#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "coverage/bound/guidance.h"
#include "coverage/operator/operator_display.h"
#include "coverage/session/preflight.h"
#include "tests/support/floors.h"
#include "tests/support/staged_capture.h"
#include "tracking/tracker/track.h"

namespace ulf::test {
namespace {

const cv::Size kScreen(1280, 720);
constexpr int kCoverageWidthPx = 640;
constexpr double kUntilShare = 0.95;
constexpr double kSecondsAView = 0.35;

// A display that has seen everything that was recorded.
struct Screen {
  explicit Screen(const StagedCapture& capture, const std::string& keys = "")
      : surface(kScreen), display(surface, feed, requests) {
    for (const auto& state : capture.recorded()) {
      feed.Publish(state);
      display.Step();
    }
    Type(keys);
  }
  void Type(const std::string& keys) {
    for (const char key : keys) surface.Push(Typed{static_cast<char32_t>(key)});
  }
  cv::Mat Show(std::shared_ptr<const CaptureState> state) {
    feed.Publish(std::move(state));
    display.Step();
    return surface.Read();
  }
  OffscreenSurface surface;
  CaptureFeed feed;
  CaptureRequests requests;
  OperatorDisplay display;
};

class Screens {
 public:
  explicit Screens(std::filesystem::path folder) : folder_(std::move(folder)) {
    options_.width = 1280, options_.height = 720;
    options_.rendered = true;
  }

  void Start() {
    const StagedCapture capture(options_);
    auto state = capture.At(capture.CameraAt(-1, 0));
    Track track;
    track.start = state->start = StartProgress{StartObstacle::kLowParallax, 0.9, 1.6, 212, 60};
    WithoutPose(track, *state);
    state->subject.reset();
    state->coverage.reset();
    Write("start", Screen(capture).Show(state));

    track.start = StartProgress{StartObstacle::kRotationOnly, 0.2, 1.6, 212, 60};
    const Rigid3 first = capture.CameraAt(-1, 0), now = capture.CameraAt(-1, 0, 1, {0.2, 0.05});
    const auto turns = capture.At(now);
    turns->turned = CameraTurn{now.rotation * first.rotation.conjugate(), false};
    turns->subject.reset();
    turns->coverage.reset();
    turns->start = track.start;
    WithoutPose(track, *turns);
    Write("only_turns", Screen(capture).Show(turns));
  }

  void Capture() {
    StagedCapture capture(options_);
    ScanHalf(capture);
    const auto guided = [&](double azimuth, double elevation, double distance) {
      auto state = capture.At(capture.CameraAt(azimuth, elevation, distance));
      Guide(capture, *state);
      return state;
    };
    const auto scanning = guided(9.5, 3.2, 1.03);
    Write("capture", Screen(capture).Show(scanning));
    Write("capture_colour_blind", Screen(capture, "p").Show(scanning));
    Write("keys", Screen(capture, "?").Show(scanning));
    // What was recorded lies farther away than now.
    Write("capture_too_near", Screen(capture).Show(guided(3, 3, 0.8)));
    const auto too_large = guided(9.5, 3.2, 1.03);
    too_large->proposed_subject =
        ulf::Subject{capture.subject().center_in_world, 0.55 * capture.subject().radius};
    Write("proposal", Screen(capture).Show(too_large));

    const auto aside = capture.At(capture.CameraAt(5, 4, 1, {1.5, 0.3}));
    aside->decision.reason = Reason::kOutsideRectangle;
    Write("out_of_view", [&] {
      Screen after_the_flash(capture);
      for (int i = 0; i < 20; ++i) after_the_flash.Show(aside);
      return after_the_flash.Show(aside);
    }());

    Write("lost", Screen(capture).Show(Lost(capture, {0.8, 0}, {})));
    Write("lost_turned", Screen(capture).Show(Lost(capture, {0.35, -0.12}, capture.CameraAt(9.5, 3.2))));
    Write("lost_turned_away", Screen(capture).Show(Lost(capture, {1.5, 0.2}, capture.CameraAt(9.5, 3.2))));
    auto apart = capture.At(capture.CameraAt(30, 0, 1, {0.8, 0}));
    Track track;
    track.state = TrackState::kApart;
    track.matched_points = 87;
    WithoutPose(track, *apart);
    Write("apart", Screen(capture).Show(apart));
  }

  void Covered() {
    StagedCapture capture(options_);
    capture.Record(capture.CameraAt(0, 0));
    capture.RecordRows(-30, 30, -20, 20, 2.5);
    auto state = capture.At(capture.CameraAt(28, 19));
    state->ended = StoppedBecause::kCovered;
    Screen screen(capture);
    screen.display.ShowFinalState();
    Write("covered", screen.Show(state));
  }

  void Subject() {
    StagedCapture capture(options_);
    Screen screen(capture);
    for (const double elevation : {-4.0, 0.0, 4.0})
      for (const double azimuth : {-8.0, -4.0, 0.0, 4.0, 8.0})
        screen.Show(capture.At(capture.CameraAt(azimuth, elevation)));
    const auto state = capture.At(capture.CameraAt(1, 1));
    state->waits_to_begin = true;
    state->recording = false;
    state->decision.reason = Reason::kPaused;
    Write("preflight", screen.Show(state));
    const auto held = std::make_shared<CaptureState>(*state);
    PictureFinding finding;
    finding.is_of_subject = true;
    finding.light = SubjectLight{.brightest_tenth = 0.04, .brightest_hundredth = 0.06};
    finding.fine_detail = 1.2;
    held->exposure_locked = false;
    held->preflight = Preflight({.calibrated = false,
                                 .calibration_source = {},
                                 .held = {.exposure = false, .white_balance = true, .focus = {}},
                                 .picture = finding,
                                 .prediction = {},
                                 .bytes_per_view = 2'000'000,
                                 .disk_left_bytes = state->disk_left_bytes,
                                 .pose_error_px = 0.2});
    Write("held", screen.Show(held));
    screen.Type("s");
    Write("subject", screen.Show(state));
  }

 private:
  static void WithoutPose(const Track& track, CaptureState& state) {
    state.tracking = track.state;
    state.tracking_words = InWords(track, state.turned, FrameSource::kCamera);
    state.cam_from_world.reset();
    state.points.clear();
    state.decision.reason = Reason::kTracking;
    PreflightInput input;
    input.has_pose = false;
    state.preflight.back() = Preflight(input).back();  // "tracking"
  }
  // Where the last views were, aimed beside the subject, after it was last known at `then`, if it
  // knows its turn.
  static std::shared_ptr<CaptureState> Lost(const StagedCapture& capture, const Eigen::Vector2d& aside,
                                            const std::optional<Rigid3>& then) {
    const Rigid3 now = capture.CameraAt(9.5, 3.2, 1, aside);
    auto lost = capture.At(now);
    if (then) lost->turned = CameraTurn{now.rotation * then->rotation.conjugate(), true};
    Track track;
    track.state = TrackState::kLost;
    WithoutPose(track, *lost);
    return lost;
  }
  // Rows to and fro, the last one as far as the camera has come.
  static void ScanHalf(StagedCapture& capture) {
    capture.Record(capture.CameraAt(0, 0));  // the cap lies about the first
    for (int row = 0; row < 9; ++row)
      for (int column = 0; column < (row == 8 ? 11 : 19); ++column) {
        const double along = -28.8 + 3.2 * column;
        capture.Record(capture.CameraAt(row % 2 == 0 ? along : -along, -19 + 2.8 * row,
                                        1 + 0.06 * std::sin(0.7 * column)));
      }
  }
  // What a capture would have said after these views.
  void Guide(const StagedCapture& capture, CaptureState& state) const {
    ulf::Guide guide;
    double time_s = 0;
    const auto after = [&](const CaptureState& each) {
      const auto view = CriterionView::From(each.camera, *each.cam_from_world, kCoverageWidthPx);
      return guide.Update(each.coverage.get(), view, time_s += kSecondsAView);
    };
    for (const auto& each : capture.recorded()) after(*each);
    state.guidance = after(state);

    PreflightReporter outlook([](const std::string&) {});
    const double distance = (*state.cam_from_world * capture.subject().center_in_world).norm();
    outlook.Expect(
        SetupAt(capture.camera(), kCoverageWidthPx, capture.subject(), distance, options_.threshold_px),
        options_.cap, kUntilShare, true, FrameSource::kCamera);
    state.prediction = outlook.prediction();
    state.preflight = outlook.preflight();
    state.views_expected = outlook.ViewsExpected(state.view_ids.size(), state.coverage.get());
  }
  void Write(const std::string& name, const cv::Mat& picture) const {
    const auto path = folder_ / ("operator_" + name + ".jpg");
    if (!cv::imwrite(path.string(), picture, {cv::IMWRITE_JPEG_QUALITY, 85}))
      throw std::runtime_error(path.string() + " cannot be written");
    fmt::print("{}\n", path.string());
  }

  std::filesystem::path folder_;
  StageOptions options_;
};

}  // namespace
}  // namespace ulf::test

int main(int argc, char** argv) {
  if (argc != 2) {
    fmt::print(stderr, "usage: operator_screens FOLDER\n");
    return 2;
  }
  ulf::test::Screens screens(argv[1]);
  screens.Start();
  screens.Capture();
  screens.Covered();
  screens.Subject();
}
