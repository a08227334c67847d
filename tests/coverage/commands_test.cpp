// The commands as a person or a script meets them.
#include <gmock/gmock.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/support/test_paths.h"

namespace ulf::test {
namespace {
namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

nlohmann::json JsonOf(const CommandResult& result) {
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_EQ(std::count(result.output.begin(), result.output.end(), '\n'), 1) << "one object, one line";
  return nlohmann::json::parse(result.output);
}

TEST(PlanCommand, PrintsWhatTheDerivationSays) {
  const auto json = JsonOf(RunUlf(
      "plan --focal-px 600 --width 640 --distance 2 --radius 0.6 --angle-deg 1 --distance-ratio 1 --json"));
  EXPECT_NEAR(json["disc_radius_deg"], 0.72, 0.006);
  EXPECT_NEAR(json["distance_window"][0], 0.933, 1e-3);
  EXPECT_NEAR(json["distance_window"][1], 1.104, 1e-3);
  EXPECT_NEAR(json["bound_px"], 8.904, 1e-3);
  EXPECT_GT(json["views_estimate"], 2560);
  EXPECT_LT(json["views_estimate"], 3200);
}

TEST(PlanCommand, NoLimitIsNull) {
  const auto json = JsonOf(RunUlf("plan --focal-px 600 --width 640 --distance 1 --radius 0.1 --json"));
  EXPECT_NEAR(json["distance_window"][0], 0.687, 1e-3);
  EXPECT_TRUE(json["distance_window"][1].is_null());
  EXPECT_FALSE(json.contains("bound_px"));
}

TEST(PlanCommand, CoverageWidthScalesTheFocalLength) {
  const auto native = JsonOf(RunUlf("plan --focal-px 600 --width 640 --distance 1 --radius 0.2 --json"));
  const auto large = JsonOf(RunUlf("plan --focal-px 3000 --width 3200 --distance 1 --radius 0.2 --json"));
  EXPECT_DOUBLE_EQ(native["disc_radius_deg"], large["disc_radius_deg"]);
}

TEST(PlanCommand, WrongUsageIsTwoAndSaysWhy) {
  const std::string good = "plan --focal-px 600 --width 640 --distance 1 ";
  for (const auto& [arguments, words] : {std::pair<std::string, std::string>{good, "--radius"},
                                         {good + "--radius 2", "outside the subject's sphere"},
                                         {good + "--radius -1", "positive"},
                                         {good + "--radius nan", "positive"},
                                         {good + "--radius 0.2 --threshold-px 2", "2 px"},
                                         {good + "--radius 0.2 --cap 60", "60x40"},
                                         {good + "--radius 0.2 --angle-deg 3", "--distance-ratio"}}) {
    const CommandResult result = RunUlf(arguments);
    EXPECT_EQ(result.exit_code, 2) << arguments;
    EXPECT_THAT(result.errors, HasSubstr(words)) << arguments;
    EXPECT_THAT(result.output, IsEmpty()) << arguments;
  }
}

TEST(InfoCommand, MissingThingsAreErrorsThatNameThem) {
  const ScratchFolder scratch;
  const CommandResult nothing = RunUlf("info " + (scratch / "none").string());
  EXPECT_EQ(nothing.exit_code, 1);
  EXPECT_THAT(nothing.errors, HasSubstr("none"));
  const CommandResult empty = RunUlf("info " + scratch.path().string());
  EXPECT_EQ(empty.exit_code, 1);
  EXPECT_THAT(empty.errors, HasSubstr("no light field"));
  EXPECT_EQ(RunUlf("info " + scratch.path().string() + " --cap 1x").exit_code, 2);
}

TEST(InfoCommand, RealCaptureInARow) {
  ULF_NEED_TEST_DATA(fox, "fox_half");
  const auto json = JsonOf(RunUlf("info " + fox.string() + " --cap 60x40 --json"));
  EXPECT_EQ(json["views"], 50);
  EXPECT_GT(json["angular_range_deg"][0], 30);
  EXPECT_GT(json["covered"], 0);
  EXPECT_LT(json["covered"], 1);
}

}  // namespace
}  // namespace ulf::test
