// Tests: commands/calibration/calibrate_command, commands/calibration/calibration_report,
// acquisition/calibration/calibration_capture, acquisition/calibration/calibration_guide.
//
// `ulf calibrate` from outside, and live collection from devices with their faults.
#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "acquisition/calibration/calibration_capture.h"
#include "acquisition/calibration/calibration_io.h"
#include "acquisition/simulator/sensor.h"
#include "acquisition/simulator/simulated_board.h"
#include "acquisition/simulator/simulated_chart.h"
#include "commands/calibration/calibration_report.h"
#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/geometry/sensor_window.h"
#include "core/image/files/exr_file.h"
#include "tests/support/dng_file.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::calibrate_command_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

// Plays frames from a simulated board; with photographs when asked, half as large again.
class ScriptedDevice : public Device {
 public:
  explicit ScriptedDevice(bool stills = false, std::uint64_t lost_after = 1u << 30)
      : stills_(stills),
        lost_after_(lost_after),
        live_({.board = Board(), .camera = SimulatedLens("barrel", 640, 480)}),
        still_({.board = Board(), .camera = SimulatedLens("barrel", 960, 720)}) {}
  DeviceInfo Info() const override {
    return {.uri = "test:board", .maker = "", .model = "", .serial = "S1", .bus = "", .problem = "pulled"};
  }
  bool IsLive() const override { return false; }
  void Start() override {}
  void Stop() override {}
  std::optional<Frame> Next(std::chrono::milliseconds) override {
    if (State() != DeviceState::kStreaming) return std::nullopt;
    Frame frame;
    if (pending_) {
      pending_ = false;
      frame.kind = FrameKind::kStill;
      frame.image = {still_.Render(still_.HeldAt(next_ / 3, 0), next_), Transfer::kLinear};
    } else {
      // Held for three frames each; every seventh is incomplete.
      frame.image = {live_.Render(live_.HeldAt(next_ / 3, 0), next_), Transfer::kLinear};
      if (next_ % 7 == 5) frame.status = FrameStatus::kIncomplete;
      ++next_;
    }
    frame.id = next_;
    return frame;
  }
  DeviceState State() const override {
    constexpr std::uint64_t kFrames = 240;
    if (next_ >= lost_after_) return DeviceState::kLost;
    return next_ >= kFrames ? DeviceState::kEnded : DeviceState::kStreaming;
  }
  DeviceStatistics Statistics() const override { return {}; }
  bool TakesStills() const override { return stills_; }
  StillRequest RequestStill() override {
    pending_ = true;
    ++requested_;
    return StillRequest::kAsked;
  }
  int requested() const { return requested_; }

 private:
  bool stills_;
  std::uint64_t lost_after_;
  BoardScene live_, still_;
  std::uint64_t next_ = 0;
  bool pending_ = false;
  int requested_ = 0;
};

TEST(CollectViews, TakesViewsByItselfUntilThereIsEnough) {
  ScriptedDevice device;
  const CollectedViews collected = CollectViews(device, Board(), {});
  EXPECT_EQ(collected.end, acquisition::ViewsEnd::kEnough);
  EXPECT_GE(collected.views.size(), 14u);
  EXPECT_EQ(collected.pictures.size(), collected.views.size());
  const CalibrationResult result =
      CalibrateFromViews(Board(), collected.views, collected.width, collected.height);
  ASSERT_TRUE(result.ok()) << result.refusal;
  EXPECT_LT(LargestDifferencePx(SimulatedLens("barrel", 640, 480), result.camera), 1.0);
  EXPECT_GT(result.coverage.CellShare(), 0.7);
}

TEST(CollectViews, StillsAreReleasedAndHaveTheirOwnSize) {
  ScriptedDevice device(true);
  CalibrationCaptureOptions options;
  options.mode = "still";
  const CollectedViews collected = CollectViews(device, Board(), options);
  EXPECT_EQ(collected.width, 960);
  EXPECT_GE(collected.views.size(), 10u);
  EXPECT_GE(device.requested(), static_cast<int>(collected.views.size()));
  const CalibrationResult result =
      CalibrateFromViews(Board(), collected.views, collected.width, collected.height);
  ASSERT_TRUE(result.ok()) << result.refusal;
  EXPECT_NEAR(result.camera.fx, 0.875 * 960, 4);
  ScriptedDevice without(false);
  EXPECT_THROW(CollectViews(without, Board(), options), Refusal);
}

TEST(CollectFrames, AsksForPhotographsOneByOne) {
  ScriptedDevice device(true);
  CalibrationCaptureOptions options;
  options.mode = "still";
  const std::vector<Frame> photographs = CollectFrames(device, 4, options);
  ASSERT_EQ(photographs.size(), 4u);
  EXPECT_EQ(device.requested(), 4);
  for (const Frame& photograph : photographs) EXPECT_EQ(photograph.image.width(), 960);
  ScriptedDevice live(true);
  live.RequestStill();  // one from the body in between
  for (const Frame& frame : CollectFrames(live, 4, {})) EXPECT_EQ(frame.image.width(), 640);
  ScriptedDevice without(false);
  EXPECT_THROW(CollectFrames(without, 4, options), Refusal);
}

TEST(CollectViews, StopsWhenAskedAndSaysWhatWasLost) {
  ScriptedDevice device;
  CalibrationCaptureOptions options;
  int shown = 0;
  options.show = [&](const CaptureProgress& now) {
    ++shown;
    EXPECT_GE(now.share, 0);
    EXPECT_LE(now.share, 1);
    EXPECT_THAT(now.text, HasSubstr("view"));
  };
  options.stop = [&] { return shown >= 12; };
  const CollectedViews collected = CollectViews(device, Board(), options);
  EXPECT_EQ(collected.end, acquisition::ViewsEnd::kStopped);
  EXPECT_GE(collected.views.size(), 2u);
  ScriptedDevice lost(false, 9);
  EXPECT_THROW(CollectViews(lost, Board(), {}), Error);
}

TEST(CalibrateCommand, FirstTryOnTheSimulatedBoard) {
  const test::ScratchFolder scratch;
  const std::string file = (scratch / "camera.json").string(), report = (scratch / "report").string(),
                    preview = (scratch / "live.png").string();
  const auto result = test::RunUlf("calibrate 'sim:board?lens=barrel&seed=3' -o " + file + " --report " +
                                   report + " --preview " + preview + " --json");
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  // The preview is that of the last view: hardly a part of the picture is tinted because it is missing.
  const cv::Mat guide = cv::imread(preview);
  ASSERT_EQ(guide.cols, 960);
  int missing = 0;
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 5; ++column) {
      const cv::Scalar mean = cv::mean(guide(cv::Rect(column * 192 + 60, row * 180 + 50, 60, 60)));
      missing += mean[2] - mean[0] > 20;
    }
  EXPECT_LE(missing, 2);
  const auto json = JsonFromText(result.output);
  EXPECT_LT(json["differs_from_truth_px"].get<double>(), 1.0) << result.output;
  EXPECT_LT(json["rms_px"].get<double>(), 0.3);
  const CalibrationFile written = ReadCalibrationFile(file);
  EXPECT_EQ(written.identity.serial, "sim-bench-3");
  ASSERT_TRUE(written.modes.at("live").window);
  EXPECT_EQ(written.modes.at("live").window->sensor_width, 640);
  EXPECT_FALSE(cv::imread(report + "/residuals.png").empty());
  // The frames that were kept give the same calibration again, now from files.
  const auto again =
      test::RunUlf("calibrate " + report + "/frames --json -o " + (scratch / "again.json").string());
  ASSERT_EQ(again.exit_code, 0) << again.errors;
  EXPECT_NEAR(ReadCalibration(scratch / "again.json").fx, ReadCalibration(file).fx, 1e-3);

  // A part of the sensor, binned: the same calibration, moved, is that camera's truth.
  const auto flat = test::RunUlf("calibrate --flat 'sim:card?seed=3&vignetting=0.4' -o " + file);
  ASSERT_EQ(flat.exit_code, 0) << flat.errors;
  const CalibrationFile with_flat = ReadCalibrationFile(file);
  ASSERT_TRUE(with_flat.modes.at("live").flat_field);
  EXPECT_EQ(with_flat.modes.at("live").camera, written.modes.at("live").camera);
  EXPECT_EQ(test::RunUlf("calibrate --flat 'sim:card?seed=4' -o " + file).exit_code, 1) << "another serial";
}

// Where the command runs, and back.
class WorkIn {
 public:
  explicit WorkIn(const std::filesystem::path& folder) : before_(std::filesystem::current_path()) {
    std::filesystem::current_path(folder);
  }
  ~WorkIn() { std::filesystem::current_path(before_); }

 private:
  std::filesystem::path before_;
};

// The work is never lost: without a name it is written under one that nothing has.
TEST(CalibrateCommand, WritesIntoThisFolderByDefault) {
  const test::ScratchFolder scratch, images;
  const BoardScene scene({.board = Board(), .camera = SimulatedLens("barrel", 640, 480)});
  for (std::uint64_t i = 0; i < 8; ++i)
    cv::imwrite((images / (std::to_string(i) + ".png")).string(), scene.Render(scene.HeldAt(i, 0), i));
  const WorkIn here(scratch.path());
  for (const bool asks_why : {false, true}) {
    const std::string name = asks_why ? "calibration-2.json" : "calibration.json";
    const auto result = test::RunUlf("calibrate " + images.path().string() + (asks_why ? " --explain" : ""));
    ASSERT_EQ(result.exit_code, 0) << result.errors;
    EXPECT_THAT(result.output,
                AllOf(HasSubstr(name + ": written"), HasSubstr("not bound"), HasSubstr("--serial")));
    EXPECT_NEAR(ReadCalibration(scratch / name).fx, 0.875 * 640, 15);
    if (asks_why) {
      EXPECT_THAT(result.output, AllOf(HasSubstr("left out"), HasSubstr("Chosen (*)"), HasSubstr("\n* ")));
    } else {
      EXPECT_THAT(result.output, Not(HasSubstr("Chosen (*)"))) << "not asked";
    }
  }
}

TEST(CalibrateCommand, FlatFieldHasAReportAndARegion) {
  const test::ScratchFolder scratch;
  const std::string file = (scratch / "camera.json").string(), report = (scratch / "report").string();
  const SensorWindow window{640, 480, 100, 60, 320, 240};
  UpdateCalibration(
      file, {.serial = "sim-bench-7", .maker = {}, .model = {}, .bus = {}}, "a test", "live",
      {.camera = ForWindow(SimulatedLens("barrel", 640, 480), {640, 480, 0, 0, 640, 480}, window),
       .window = window});
  const std::string before = ReadWholeFile(file);
  // The same size elsewhere on the sensor.
  const auto moved = test::RunUlf("calibrate --flat 'sim:card?roi=0,0,320,240' -o " + file);
  EXPECT_EQ(moved.exit_code, 1);
  EXPECT_THAT(moved.errors, AllOf(HasSubstr("320x240 at 100,60"), HasSubstr("320x240 at 0,0")));
  EXPECT_EQ(ReadWholeFile(file), before);

  const auto result =
      test::RunUlf("calibrate --flat 'sim:card?roi=100,60,320,240' --report " + report + " -o " + file);
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_TRUE(ReadCalibrationFile(file).modes.at("live").flat_field);
  const cv::Mat picture = cv::imread(report + "/flat_field.png");
  EXPECT_GT(picture.cols, 1000);
  EXPECT_THAT(ReadWholeFile(report + "/flat_field.txt"), HasSubstr("corners"));
  const auto json = JsonFromText(ReadWholeFile(report + "/flat_field.json"));
  EXPECT_EQ(json["frames"], 10);
  EXPECT_GT(json["corner_light_bgr"][0].get<double>(), 0.3);
}

// Real pictures from which the principal point does not come out: that is said first.
TEST(CalibrateCommand, GravestWarningComesFirst) {
  ULF_NEED_TEST_DATA(webcam, "chessboard_webcam");
  const test::ScratchFolder scratch;
  const auto result = test::RunUlf("calibrate " + webcam.string() + " --board chessboard:8x8:25 -o " +
                                   (scratch / "camera.json").string() + " --json");
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  const auto json = JsonFromText(result.output);
  ASSERT_FALSE(json["warnings"].empty());
  EXPECT_THAT(json["warnings"][0].get<std::string>(),
              AllOf(HasSubstr("principal point"), HasSubstr("do not use this calibration")));
}

TEST(CalibrateCommand, RefusalsSayWhy) {
  const test::ScratchFolder scratch;
  const BoardScene scene({.board = Board(), .camera = SimulatedLens("barrel", 640, 480)});
  for (int i = 0; i < 6; ++i)
    cv::imwrite((scratch / (std::to_string(i) + ".png")).string(),
                scene.Render(scene.HeldAt(1, 0), static_cast<std::uint64_t>(i)));
  const std::string file = (scratch / "camera.json").string();
  const auto result = test::RunUlf("calibrate " + scratch.path().string() + " -o " + file);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.errors, HasSubstr("same place"));
  EXPECT_FALSE(std::filesystem::exists(file));
  EXPECT_EQ(test::RunUlf("calibrate " + scratch.path().string() + " --board chess -o " + file).exit_code, 2);
  EXPECT_EQ(test::RunUlf("calibrate /no/such/folder -o " + file).exit_code, 1);
  EXPECT_EQ(test::RunUlf("calibrate --flat " + scratch.path().string() + " -o " + file).exit_code, 1)
      << "no intrinsics yet";
}

TEST(CalibrateCommand, FindsColoursFromChartAndGreyCard) {
  test::ScratchFolder scratch;
  const std::string file = (scratch / "camera.json").string();
  const std::string chart = "calibrate --colour 'sim:chart?seed=3&lamp_k=3200&crosstalk=0.2'";
  EXPECT_THAT(test::RunUlf(chart + " -o " + file).errors, HasSubstr("with a board first"));
  const CameraModel camera = SimulatedLens("barrel", 640, 480);
  WriteCalibration(file, camera, "sim-bench-3", "test");
  const auto run = test::RunUlf(chart + " --json -o " + file + " --report " + (scratch / "report").string());
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  const auto json = JsonFromText(run.output);
  EXPECT_GT(json["delta_e"]["as_recorded"]["mean"].get<double>(), 10);
  EXPECT_GT(json["delta_e"]["balanced"]["mean"].get<double>(), 2);
  EXPECT_LT(json["delta_e"]["held_out"]["mean"].get<double>(), 1.5);
  EXPECT_TRUE(std::filesystem::exists(scratch / "report/colours.json"));
  const ModeCalibration written = ReadCalibrationFile(file).modes.at("live");
  EXPECT_EQ(written.camera, camera);
  ASSERT_TRUE(written.color_profile);
  const Eigen::Vector3d balance = SensorColors{.lamp_k = 3200, .crosstalk = 0.2}.WhiteBalance();
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(written.color_profile->white_balance[static_cast<std::size_t>(c)] / balance[c], 1, 0.02);
  EXPECT_FALSE(written.color_profile->raw_white_balance);

  // Another lamp: the balance changes, the matrix is the camera's.
  const auto grey = test::RunUlf("calibrate --grey 'sim:grey?seed=3&lamp_k=2600&crosstalk=0.2' -o " + file);
  ASSERT_EQ(grey.exit_code, 0) << grey.errors;
  EXPECT_THAT(grey.output, HasSubstr("white balance"));
  const auto regreyed = ReadCalibrationFile(file).modes.at("live").color_profile;
  ASSERT_TRUE(regreyed);
  EXPECT_EQ(regreyed->matrix, written.color_profile->matrix);
  EXPECT_FALSE(regreyed->delta_e);
  EXPECT_GT(regreyed->white_balance[2], 1.1 * written.color_profile->white_balance[2]);
  EXPECT_THAT(test::RunUlf("calibration " + file).output, HasSubstr("white balance of a grey card"));

  // A new calibration of the lens keeps the colours.
  WriteCalibration(file, camera, "sim-bench-3", "again");
  EXPECT_TRUE(ReadCalibrationFile(file).modes.at("live").color_profile);
  EXPECT_EQ(test::RunUlf("calibrate --colour 'sim:chart?seed=4' -o " + file).exit_code, 1)
      << "another serial";
  const auto none = test::RunUlf("calibrate --colour 'sim:grey?seed=3' -o " + file);
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_THAT(none.errors, HasSubstr("no chart of 24 patches"));
  EXPECT_EQ(test::RunUlf(chart + " --grey -o " + file).exit_code, 2);
}

// From photographs: of raw files, what remains after their own matrix, and the balance by which they
// were developed.
TEST(CalibrateCommand, FindsColoursFromPhotographs) {
  test::ScratchFolder scratch;
  const std::string file = (scratch / "camera.json").string();
  WriteCalibration(file, SimulatedLens("barrel", 640, 480), "S", "test", "still");
  const Image image = RenderChart({.colors = {.lamp_k = 4000, .crosstalk = 0.1}}, 0);
  cv::Mat wide, bgr = LinearFloat(image);
  bgr.convertTo(wide, CV_32F);
  WriteFileAtomically(scratch / "chart.exr",
                      ExrBytes({{"R", wide, 2}, {"G", wide, 1}, {"B", wide, 0}}, ExrCompression::kZip));
  const auto run = test::RunUlf("calibrate --colour " + (scratch / "chart.exr").string() +
                                " --mode still --serial S -o " + file);
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.output, HasSubstr("on patches left out"));
  EXPECT_TRUE(ReadCalibrationFile(file).modes.at("still").color_profile);
  test::DngCamera camera;
  camera.sensor = {656, 488};
  camera.visible = {8, 4, 640, 480};
  camera.crop.reset();
  std::ofstream(scratch / "chart.dng", std::ios::binary) << test::DngBytes(camera, [&](int x, int y) {
    const cv::Vec3f& at = bgr.at<cv::Vec3f>(y, x);
    return cv::Vec3d(at[2], at[1], at[0]);
  });
  const auto raw = test::RunUlf("calibrate --colour " + (scratch / "chart.dng").string() +
                                " --mode still --serial S -o " + file);
  ASSERT_EQ(raw.exit_code, 0) << raw.errors;
  const auto profile = ReadCalibrationFile(file).modes.at("still").color_profile;
  ASSERT_TRUE(profile && profile->raw_white_balance);
  EXPECT_NEAR((*profile->raw_white_balance)[0], 1 / camera.neutral[0], 0.01);
}

}  // namespace
}  // namespace ulf::calibrate_command_test
