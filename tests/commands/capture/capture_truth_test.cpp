// Tests: commands/capture/capture_report.
//
// What `ulf capture --truth` says of the tracker: true poses give a small error, wrong ones the error they
// have.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <future>
#include <nlohmann/json.hpp>
#include <random>

#include "acquisition/opening/open_device.h"
#include "core/base/json_text.h"
#include "core/geometry/trajectory.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::capture_truth_test {
namespace {

constexpr const char* kUri = "sim:studio?width=320&height=240&speed_deg_s=20";
constexpr int kFrames = 90;

std::vector<TimedPose> TruePoses() {
  const auto device = OpenDevice(kUri);
  device->Start();
  std::vector<TimedPose> poses;
  for (int i = 0; i < kFrames; ++i) {
    const auto frame = device->Next(std::chrono::milliseconds(1000));
    poses.push_back({frame->device_time_s, frame->known_cam_from_world.value()});
  }
  return poses;
}

nlohmann::json Capture(const std::string& dir, const std::string& truth, int frames = kFrames) {
  const auto captured = test::RunUlf(
      fmt::format("capture --no-geometry '{}' -o {} --headless --deterministic --frames {} --truth {} --json",
                  kUri, dir, frames, truth));
  EXPECT_EQ(captured.exit_code, 0) << captured.errors;
  return JsonFromText(captured.output);
}

nlohmann::json Capture(const test::ScratchFolder& scratch, const std::string& name,
                       const std::vector<TimedPose>& truth) {
  const std::string dir = (scratch / name).string(), file = dir + ".txt";
  WriteTum(file, truth);
  return Capture(dir, file);
}

TEST(CaptureTruth, IsSmallForTruePosesAndSeesWrongOnes) {
  test::ScratchFolder scratch;
  const std::vector<TimedPose> truth = TruePoses();
  const nlohmann::json right = Capture(scratch, "right", truth);
  const double distance = right["truth_subject_distance"];
  EXPECT_NEAR(distance, 1, 0.15) << "the hand scans at a metre from what it looks at";
  EXPECT_LT(right["ate_live_rmse"].get<double>(), 0.005 * distance);
  EXPECT_LT(right["ate_views_rmse"].get<double>(), 0.005 * distance);
  EXPECT_GT(right["tracked"].get<int>(), kFrames / 2);

  constexpr double kSigma = 0.02;
  std::vector<TimedPose> shaken = truth;
  std::mt19937 random(1);
  std::normal_distribution<double> normal(0, kSigma);
  for (TimedPose& pose : shaken)
    pose.cam_from_world.translation += Eigen::Vector3d(normal(random), normal(random), normal(random));
  const nlohmann::json wrong = Capture(scratch, "wrong", shaken);
  EXPECT_NEAR(wrong["ate_live_rmse"].get<double>(), kSigma * std::sqrt(3.0), 0.2 * kSigma * std::sqrt(3.0));

  EXPECT_EQ(test::RunUlf(std::string("capture --no-geometry '") + kUri + "' -o " + (scratch / "lf").string() +
                         " --headless --truth " + (scratch / "gone.txt").string())
                .exit_code,
            2);
}

// A file that a simulator still writes when the capture begins, and a pipe, which gives its poses once.
TEST(CaptureTruth, MayGrowMeanwhileOrComeThroughAPipe) {
  constexpr int kFew = 30;
  test::ScratchFolder scratch;
  const std::string whole = (scratch / "whole.txt").string();
  WriteTum(whole, TruePoses());
  const auto capture = [&](const std::string& name) {
    return std::async(std::launch::async,
                      [&, name] { return Capture((scratch / name).string(), whole + name, kFew); });
  };
  std::ofstream(whole + "grows") << "# time tx ty tz qx qy qz qw\n";
  auto grown = capture("grows");
  while (!std::filesystem::exists(scratch / "grows") &&
         grown.wait_for(std::chrono::milliseconds(5)) != std::future_status::ready) {
  }
  std::filesystem::copy_file(whole, whole + "grows", std::filesystem::copy_options::overwrite_existing);
  EXPECT_TRUE(grown.get()["ate_live_rmse"].is_number());

  ASSERT_EQ(mkfifo((whole + "pipe").c_str(), 0600), 0);
  auto piped = capture("pipe");
  std::ofstream(whole + "pipe") << std::ifstream(whole).rdbuf();
  EXPECT_TRUE(piped.get()["ate_live_rmse"].is_number());
}

TEST(CaptureOutputs, AreCheckedBeforeTheWork) {
  test::ScratchFolder scratch;
  const auto refused =
      test::RunUlf(std::string("capture --no-geometry '") + kUri + "' -o " + (scratch / "lf").string() +
                   " --headless --frames 5 --overlay " + (scratch / "gone/live.png").string());
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.errors, testing::HasSubstr("does not exist"));
  EXPECT_FALSE(std::filesystem::exists(scratch / "lf")) << "nothing was begun";
}

}  // namespace
}  // namespace ulf::capture_truth_test
