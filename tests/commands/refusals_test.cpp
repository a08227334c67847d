// Tests: commands/options/option_values, commands/options/command_line, commands/options/tracking_options,
// core/base/output_path.
//
// What is wrong is found out before the work, and said in words, across the commands that take devices.
#include <gmock/gmock.h>
#include <unistd.h>

#include <fstream>

#include "core/light_field/folder/light_field_writer.h"
#include "tests/support/test_paths.h"

namespace ulf::test::refusals_test {
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

TEST(Refusals, UnmakeableFrameFolderLeavesNoLightField) {
  const ScratchFolder scratch;
  const std::string capture =
      "capture --no-geometry " + kStudio + " --headless --frames 3 -o " + (scratch / "lf").string();
  const CommandResult refused = RunUlf(capture + " --keep-frames /proc/frames");
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.errors, HasSubstr("/proc/frames"));
  EXPECT_FALSE(fs::exists(scratch / "lf"));
}

TEST(Refusals, AFolderInUseIsFoundBeforeTheDevice) {
  const ScratchFolder scratch;
  CaptureHeader header;
  header.camera = CameraModel::Pinhole(96, 72, 100);
  LightFieldWriter::Create(scratch / "lf", header);
  std::ofstream(scratch / "lf/images/1.png") << "x";
  std::ofstream(scratch / "file") << "x";
  for (const auto& [folder, says] : {std::pair<std::string, std::string>{"lf", "holds a light field already"},
                                     {"", "the folder is not empty"},
                                     {"file", "is a file"}}) {
    const CommandResult refused =
        RunUlf("capture replay:nowhere --headless -o " + (scratch / folder).string());
    EXPECT_EQ(refused.exit_code, 1);
    EXPECT_THAT(refused.errors, AllOf(HasSubstr(says), Not(HasSubstr("nowhere"))));
  }
}

TEST(Refusals, UnwritableReportIsFoundBeforeTheWork) {
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

// A light field whose photographs cannot be read: who says another reason has not read one.
TEST(Refusals, JournalsReasonsComeFirst) {
  const ScratchFolder scratch;
  const fs::path dir = scratch / "lf";
  CaptureHeader header;
  header.camera = CameraModel::Pinhole(96, 72, 100);
  {
    LightFieldWriter writer = LightFieldWriter::Create(dir, header);
    writer.SetSubject({{0, 0, 1}, 0.15});
    for (int i = 0; i < 9; ++i) {  // in a column: nothing to the side
      Frame frame;
      frame.image.pixels = cv::Mat(72, 96, CV_8UC3, cv::Scalar(90, 120, 60));
      View view;
      view.cam_from_world = LookAt({0, 0.05 * i, 0}, {0, 0, 1}, {0, -1, 0});
      writer.AddView(frame, view);
    }
    writer.Close(1);
  }
  const std::string lf = dir.string(), out = (scratch / "out").string();
  const auto refused = [](const std::string& arguments, const std::string& says) {
    const CommandResult result = RunUlf(arguments);
    EXPECT_NE(result.exit_code, 0) << arguments;
    EXPECT_THAT(result.errors,
                AllOf(HasSubstr(says), Not(HasSubstr("--explain says more")), Not(HasSubstr("images/"))))
        << arguments;
  };
  // Fields are not compared before; comparing them is said.
  refused("export quilt " + lf + " -o " + out, "no view to the side");
  for (const auto& photograph : fs::directory_iterator(dir / "images"))
    fs::resize_file(photograph.path(), 70);
  refused("export gltf " + lf + " -o " + out, "there is no mesh of this light field yet");
  refused("export web " + lf + " -o " + out + " --proxy plane:0.9", "a page takes plane, planes, mesh");
  refused("export web " + lf + " -o " + out + " --budget 20kB", "can hold none");
  refused("render " + lf + " -o /dev/null/pictures", "/dev/null is no folder");
  refused("render " + lf + " -o /dev/null/picture.png", "/dev/null is no folder");
  refused("render " + lf + " -o /dev/null/video.mp4", "/dev/null does not exist");
  refused("take-back " + lf + " 99", "there is no view 99");
  refused("merge " + lf, "no view has other exposures");
}

}  // namespace
}  // namespace ulf::test::refusals_test
