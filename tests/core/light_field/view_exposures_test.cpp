// Tests: core/light_field/light_field.
#include "core/light_field/light_field.h"

#include <gmock/gmock.h>

#include <fstream>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/image/files/exr_file.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "core/light_field/folder/view_images.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::test::view_exposures_test {
namespace {

namespace fs = std::filesystem;

const CameraModel kSmall = CameraModel::Pinhole(8, 6, 10);

// Sixteen bits of linear light.
Frame LightOf(double level, double exposure_s) {
  Frame frame;
  frame.image = {.pixels = cv::Mat(6, 8, CV_16UC3, cv::Scalar::all(65535 * level)),
                 .transfer = Transfer::kLinear};
  frame.exposure_s = exposure_s;
  frame.device_time_s = 3 + exposure_s;
  frame.black_level = 0.01;
  return frame;
}

Rigid3 Moved(double by) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(by, Eigen::Vector3d::UnitY())), {by, 0, 0}};
}

// Two views, the first with two more exposures.
LightFieldWriter TwoViews(const fs::path& dir) {
  CaptureHeader header;
  header.camera = kSmall;
  LightFieldWriter writer = LightFieldWriter::Create(dir, header);
  for (int i = 0; i < 2; ++i) {
    View view;
    view.cam_from_world = Moved(0.1 * i);
    writer.AddView(LightOf(0.5, 0.004), view);
  }
  writer.AddExposure(1, LightOf(0.125, 0.001), Moved(0.01), false);
  writer.AddExposure(1, LightOf(0.9, 0.016), Moved(0.02), true);
  return writer;
}

void ExpectBothExposures(const LightField& light_field) {
  ASSERT_EQ(light_field.views.size(), 2u);
  EXPECT_TRUE(light_field.views[1].exposures.empty());
  const View& view = light_field.views[0];
  ASSERT_EQ(view.exposures.size(), 2u);
  EXPECT_EQ(view.exposures[0].master_path, "exposures/000001-1.master.tif");
  EXPECT_EQ(view.exposures[0].exposure_s, 0.001);
  EXPECT_EQ(view.exposures[0].black_level, 0.01);
  EXPECT_FALSE(view.exposures[0].pose_is_between);
  EXPECT_TRUE(view.exposures[1].pose_is_between);
  EXPECT_EQ(view.exposures[1].exposure_from_view.translation, Moved(0.02).translation);
  const Image image = ReadViewMaster(light_field, PhotographOf(view, view.exposures[0]));
  EXPECT_EQ(image.transfer, Transfer::kLinear);
  EXPECT_NEAR(image.pixels.at<cv::Vec3w>(2, 2)[1], 8192, 1);
}

TEST(ViewExposures, AreInTheJournalAndInTransformsJson) {
  const ScratchFolder scratch;
  TwoViews(scratch / "lf").Close(1);
  ExpectBothExposures(ReadLightField(scratch / "lf"));
  // By transforms.json alone, as ulf repair does.
  fs::remove(scratch / "lf" / "journal.jsonl");
  ExpectBothExposures(ReadLightField(scratch / "lf" / "transforms.json"));
}

TEST(ViewExposures, KillLeavesThemAndResumingGoesOn) {
  const ScratchFolder scratch;
  { TwoViews(scratch / "lf"); }  // not closed
  LightFieldWriter writer = LightFieldWriter::Resume(scratch / "lf");
  ExpectBothExposures(writer.Contents());
  writer.AddExposure(2, LightOf(0.3, 0.001), Moved(0), false);
  writer.Close(1);
  EXPECT_EQ(ReadLightField(scratch / "lf").views[1].exposures.size(), 1u);
  EXPECT_TRUE(ReadLightField(scratch / "lf").doubts.empty());
}

TEST(ViewExposures, GoToUnposedWithTheirView) {
  const ScratchFolder scratch;
  {
    LightFieldWriter writer = TwoViews(scratch / "lf");
    writer.RemoveViews({1});
    // That was still on its way.
    writer.AddExposure(1, LightOf(0.2, 0.064), Moved(0.03), false);
    writer.Close(1);
  }
  const LightField light_field = ReadLightField(scratch / "lf");
  ASSERT_EQ(light_field.views.size(), 1u);
  EXPECT_TRUE(fs::is_empty(scratch / "lf" / "exposures"));
  for (const char* name : {"000001-1.master.tif", "000001-2.master.tif", "000001.master.tif", "000001.png"})
    EXPECT_TRUE(fs::exists(scratch / "lf" / "unposed" / name)) << name;
  ASSERT_EQ(light_field.unposed.size(), 1u);
  EXPECT_THAT(light_field.unposed[0].problem, ::testing::HasSubstr("taken back"));
}

// The merged light takes the master's place where pictures are made of it, and not in the recorded files.
TEST(ViewExposures, MergedLightIsWhatIsRendered) {
  const ScratchFolder scratch;
  LightFieldWriter writer = TwoViews(scratch / "lf");
  cv::Mat light(6, 8, CV_32FC3, cv::Scalar::all(2.5));
  cv::Mat clipped = cv::Mat::zeros(6, 8, CV_32FC1);
  clipped.at<float>(1, 2) = 1;
  const std::string exr = ExrBytes(
      {{"R", light, 2}, {"G", light, 1}, {"B", light, 0}, {kClippedChannel, clipped}}, ExrCompression::kZip);
  writer.SetMerged(1, exr, 3, 0.07);
  writer.Close(1);
  LightField read = ReadLightField(scratch / "lf");
  ASSERT_TRUE(read.views[0].merged);
  EXPECT_EQ(read.views[0].merged->path, "merged/000001.exr");
  EXPECT_EQ(read.views[0].merged->exposures, 3);
  EXPECT_EQ(read.views[0].merged->ghost_share, 0.07);
  EXPECT_TRUE(HasMoreThanEightBits(read, read.views[0]));
  cv::Mat lower_bounds;
  const Image rendered = ReadViewLight(read, read.views[0], &lower_bounds);
  EXPECT_EQ(rendered.transfer, Transfer::kLinear);
  EXPECT_FLOAT_EQ(rendered.pixels.at<cv::Vec3f>(0, 0)[0], 2.51f)
      << "above black, which is subtracted like a master's";
  ASSERT_FALSE(lower_bounds.empty());
  EXPECT_EQ(lower_bounds.at<std::uint8_t>(1, 2), 255);
  EXPECT_EQ(cv::countNonZero(lower_bounds), 1);
  EXPECT_EQ(ReadViewMaster(read, read.views[0]).pixels.depth(), CV_16U) << "as it was recorded";
  // Damaged, its own exposure stands in.
  std::ofstream(scratch / "lf" / "merged" / "000001.exr") << "no EXR";
  EXPECT_EQ(ReadViewLight(read, read.views[0]).pixels.depth(), CV_16U);
}

TEST(ViewExposures, RefuseAPathOutOfTheFolder) {
  const ScratchFolder scratch;
  TwoViews(scratch / "lf").Close(1);
  std::string journal = ReadWholeFile(scratch / "lf" / "journal.jsonl");
  const std::size_t at = journal.find("exposures/000001-1");
  ASSERT_NE(at, std::string::npos);
  journal.replace(at, 9, "../etc/xx");
  std::ofstream(scratch / "lf" / "journal.jsonl") << journal;
  const LightField light_field = ReadLightField(scratch / "lf");
  EXPECT_EQ(light_field.views[0].exposures.size(), 1u) << "the line is left out, the others count";
  EXPECT_FALSE(light_field.doubts.empty());
}

}  // namespace
}  // namespace ulf::test::view_exposures_test
