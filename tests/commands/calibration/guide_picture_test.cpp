// Tests: commands/calibration/guide_picture, commands/calibration/board_calibration,
// commands/calibration/calibrate_source, acquisition/calibration/calibration_picture,
// acquisition/calibration/calibration_guide, acquisition/calibration/calibration_capture.
//
// What the operator sees and is told while views are taken.
#include <gmock/gmock.h>

#include <opencv2/imgcodecs.hpp>

#include "acquisition/calibration/calibration_capture.h"
#include "acquisition/calibration/calibration_picture.h"
#include "acquisition/simulator/simulated_board.h"
#include "core/base/error.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::guide_picture_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

// How much more red than blue a place of the picture is: parts that are missing are tinted.
double Tint(const cv::Mat& picture, int column, int row) {
  const int height = 720;  // of 640 x 480 at 960 pixels
  const cv::Rect part(column * 192 + 60, row * height / 4 + 50, 60, 60);
  const cv::Scalar mean = cv::mean(picture(part));
  return mean[2] - mean[0];
}

TEST(GuidePicture, ShowsWhatIsMissingAndWhatWasFound) {
  const BoardScene scene({.board = Board(), .camera = SimulatedLens("pinhole", 640, 480)});
  CalibrationGuide guide(Board(), 640, 480);
  const cv::Mat nothing(480, 640, CV_8UC1, cv::Scalar(90));
  EXPECT_EQ(guide.JudgeFrame(nothing, "none"), ViewVerdict::kNotSeen);
  const cv::Mat before = DrawGuide(nothing, guide, ViewVerdict::kNotSeen);
  ASSERT_EQ(before.cols, 960);
  ASSERT_GT(before.rows, 720);
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 5; ++column) EXPECT_GT(Tint(before, column, row), 30);
  // Held in the middle of the image, it covers that and no corner.
  const Rigid3 pose{Eigen::Quaterniond::Identity(), {-105, -75, 500}};
  guide.JudgeFrame(scene.Render(pose, 1), "1");
  const cv::Mat picture = scene.Render(pose, 2);
  ASSERT_EQ(guide.JudgeFrame(picture, "2"), ViewVerdict::kTaken);
  const cv::Mat after = DrawGuide(picture, guide, ViewVerdict::kTaken);
  EXPECT_LT(Tint(after, 2, 1), 10);
  EXPECT_GT(Tint(after, 0, 0), 30);
  EXPECT_GT(Tint(after, 4, 3), 30);
  // A white dot on every corner of the board.
  for (const Eigen::Vector2d& img : guide.views()[0].img) {
    const auto pixel = after.at<cv::Vec3b>(static_cast<int>(img.y() * 1.5), static_cast<int>(img.x() * 1.5));
    EXPECT_GT(static_cast<int>(std::min({pixel[0], pixel[1], pixel[2]})), 180);
  }
}

// What a preview shows at the end: CalibrateCommand.FirstTryOnTheSimulatedBoard.
TEST(GuidePicture, OfAFileIsRefused) {
  const test::ScratchFolder scratch;
  const auto refused = [&](const std::string& arguments) { return test::RunUlf("calibrate " + arguments); };
  EXPECT_THAT(refused("sim:board --preview " + (scratch / "live.bmp").string()).errors,
              HasSubstr("is written as PNG"));
  cv::imwrite((scratch / "picture.png").string(), cv::Mat(48, 64, CV_8UC3, cv::Scalar::all(90)));
  EXPECT_THAT(
      refused((scratch / "picture.png").string() + " --preview " + (scratch / "other.png").string()).errors,
      HasSubstr("of a device"));
}

// A tethered camera without live view, whose photographs come when they are asked for.
class PhotographsOnly : public Device {
 public:
  PhotographsOnly() : scene_({.board = Board(), .camera = SimulatedLens("barrel", 640, 480)}) {}
  DeviceInfo Info() const override {
    return {.uri = "test:stills", .maker = "", .model = "", .serial = "S", .bus = "", .problem = {}};
  }
  bool IsLive() const override { return true; }
  bool HasLiveFrames() const override { return false; }
  void Start() override {}
  void Stop() override {}
  std::optional<Frame> Next(std::chrono::milliseconds) override {
    if (!asked_) return std::nullopt;
    asked_ = false;
    Frame frame;
    frame.kind = FrameKind::kStill;
    // The second one misses the board, the fourth is as the third.
    const std::uint64_t place = taken_ < 3 ? taken_ : taken_ - 1;
    frame.image = {taken_ == 1 ? cv::Mat(480, 640, CV_8UC1, cv::Scalar(80))
                               : scene_.Render(scene_.HeldAt(place, 0), taken_),
                   Transfer::kLinear};
    frame.id = ++taken_;
    return frame;
  }
  DeviceState State() const override { return DeviceState::kStreaming; }
  DeviceStatistics Statistics() const override { return {}; }
  bool TakesStills() const override { return true; }
  StillRequest RequestStill() override {
    asked_ = true;
    return StillRequest::kAsked;
  }

 private:
  BoardScene scene_;
  bool asked_ = false;
  std::uint64_t taken_ = 0;
};

TEST(CollectPhotographs, EachIsAskedForAndAnswered) {
  PhotographsOnly device;
  CalibrationCaptureOptions options;
  options.mode = "still";
  options.release = [] { return true; };
  std::vector<std::string> said;
  options.say = [&](const std::string& line) { said.push_back(line); };
  const CollectedViews collected = CollectViews(device, Board(), options);
  EXPECT_EQ(collected.end, acquisition::ViewsEnd::kEnough);
  ASSERT_GT(said.size(), 14u);
  EXPECT_THAT(said[0], AllOf(HasSubstr("photograph 1"), HasSubstr("Enter")));
  EXPECT_THAT(said[1], AllOf(HasSubstr("photograph 1: "), HasSubstr("corners, taken"), HasSubstr("next: ")));
  EXPECT_THAT(said[2], AllOf(HasSubstr("photograph 2: the board is not in it"), HasSubstr("next: ")));
  EXPECT_THAT(said[4], HasSubstr("nothing new"));
  EXPECT_THAT(said.back(), HasSubstr("enough"));
  const CalibrationResult result =
      CalibrateFromViews(Board(), collected.views, collected.width, collected.height);
  ASSERT_TRUE(result.ok()) << result.refusal;
  EXPECT_NEAR(result.camera.fx, 0.875 * 640, 5);
}

}  // namespace
}  // namespace ulf::guide_picture_test
