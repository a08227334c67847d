// Tests: commands/number_checks, commands/command_line, commands/calibration/intrinsics_options,
// core/base/output_path.
//
// What is wrong is found out before the work, and said in words, across the commands that take devices.
#include <gmock/gmock.h>
#include <unistd.h>

#include "core/light_field/light_field_io.h"
#include "tests/support/test_paths.h"

namespace ulf::test::refusals {
namespace {
namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

const std::string kStudio = "'sim:studio?width=160&height=120'";

TEST(Refusals, NumbersThatAreNoneAreUsageErrorsInWords) {
  const ScratchFolder scratch;
  const std::string out = " -o " + (scratch / "out").string();
  for (const auto& [arguments, option] :
       {std::pair<std::string, std::string>{"capture --no-geometry " + kStudio + out + " --frames -3",
                                            "--frames"},
        {"capture --no-geometry " + kStudio + out + " --max-seconds -1", "--max-seconds"},
        {"capture --no-geometry " + kStudio + out + " --speed -1", "--speed"},
        {"capture --no-geometry " + kStudio + out + " --focal-px 0", "--focal-px"},
        {"record " + kStudio + out + " --frames -3", "--frames"},
        {"record " + kStudio + out + " --max-seconds 0", "--max-seconds"},
        {"simulate --duration-s -2", "--duration-s"}}) {
    const CommandResult result = RunUlf(arguments);
    EXPECT_EQ(result.exit_code, 2) << arguments;
    EXPECT_THAT(result.errors,
                AllOf(HasSubstr(option), HasSubstr("is not a number"), Not(HasSubstr("1797"))));
    EXPECT_FALSE(fs::exists(scratch / "out")) << arguments;
  }
}

TEST(Refusals, AFolderForFramesThatCannotBeMadeLeavesNoLightField) {
  const ScratchFolder scratch;
  const std::string capture =
      "capture --no-geometry " + kStudio + " --headless --frames 3 -o " + (scratch / "lf").string();
  const CommandResult refused = RunUlf(capture + " --keep-frames /proc/frames");
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.errors, HasSubstr("/proc/frames"));
  EXPECT_FALSE(fs::exists(scratch / "lf"));
}

TEST(Refusals, AReportThatCannotBeWrittenIsFoundOutBeforeTheBoardIsHeld) {
  const ScratchFolder scratch;
  const CommandResult refused =
      RunUlf("calibrate sim:board -o " + (scratch / "c.json").string() + " --report /proc/report");
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.errors, AllOf(HasSubstr("/proc/report"), Not(HasSubstr("views"))));
}

TEST(Refusals, AMarkerToLookRoundWithWantsADisplay) {
  const ScratchFolder scratch;
  const CommandResult refused =
      RunUlf("capture --no-geometry " + kStudio + " --headless --marker marker:80:DICT_4X4_50:0 -o " +
             (scratch / "lf").string());
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.errors, AllOf(HasSubstr("--marker marker:80:DICT_4X4_50:0"), HasSubstr("--headless"),
                                    HasSubstr("leave out one")));
  EXPECT_FALSE(fs::exists(scratch / "lf"));
}

// Wider or higher than round is no cap, whatever is meant by it.
TEST(Refusals, ACapLargerThanThereAreDirectionsIsUsage) {
  const ScratchFolder scratch;
  for (const char* cap : {"361x40", "60x181", "0x40", "60x-40", "60", "60x40x20", "nanx40"}) {
    const CommandResult refused = RunUlf("capture --no-geometry " + kStudio + " --headless --until-covered " +
                                         cap + " -o " + (scratch / "lf").string());
    EXPECT_EQ(refused.exit_code, 2) << cap;
    EXPECT_THAT(refused.errors, AllOf(HasSubstr(cap), HasSubstr("up to 360x180"))) << cap;
    EXPECT_FALSE(fs::exists(scratch / "lf")) << cap;
  }
}

TEST(Refusals, AFocalLengthThatIsNotUsedIsSaid) {
  const ScratchFolder scratch;
  const CommandResult result = RunUlf("capture --no-geometry " + kStudio +
                                      " --headless --frames 3 --focal-px 20 -o " + (scratch / "lf").string());
  EXPECT_THAT(result.errors, HasSubstr("--focal-px 20 is not used"));
}

TEST(Refusals, AModeThatACalibrationHasNotIsUsage) {
  const ScratchFolder scratch;
  EXPECT_EQ(RunUlf("calibration camera.json --mode foo").exit_code, 2);
}

}  // namespace
}  // namespace ulf::test::refusals
