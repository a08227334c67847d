// Tests: core/video/video_writer.
#include "core/video/video_writer.h"

#include <gmock/gmock.h>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/video/video_reader.h"
#include "tests/support/test_paths.h"

namespace ulf::video_writer_test {
namespace {

namespace fs = std::filesystem;

TEST(VideoWriter, ColoursComeBackAsTheyWere) {
  const test::ScratchFolder scratch;
  const fs::path file = scratch / "video.mp4";
  const std::array<cv::Vec3b, 6> patches{cv::Vec3b(50, 50, 200), {50, 200, 50},   {200, 50, 50},
                                         {50, 200, 200},         {128, 128, 128}, {120, 160, 235}};
  cv::Mat picture(64, 192, CV_8UC3);
  for (int y = 0; y < picture.rows; ++y)
    for (int x = 0; x < picture.cols; ++x)
      picture.at<cv::Vec3b>(y, x) = patches[static_cast<std::size_t>(x / 32)];
  {
    VideoWriter writer(file, picture.size(), 24);
    for (int i = 0; i < 12; ++i) writer.Add(picture);
    writer.Close();
  }
  const std::string bytes = ReadWholeFile(file);
  EXPECT_LT(bytes.find("moov"), bytes.find("mdat")) << "players begin before all is there";
  EXPECT_NE(bytes.find("colrnclx"), std::string::npos) << "the container says it, too";
  VideoReader reader(file);
  EXPECT_THAT(reader.Facts().notes, testing::IsEmpty()) << "the stream names its colours";
  EXPECT_EQ(reader.Facts().frame_rate, 24);
  int count = 0;
  while (const auto read = reader.Next()) {
    for (std::size_t patch = 0; patch < patches.size(); ++patch)
      for (int channel = 0; channel < 3; ++channel)
        EXPECT_NEAR(read->image.pixels.at<cv::Vec3b>(32, static_cast<int>(32 * patch + 16))[channel],
                    patches[patch][channel], 2)
            << patch;
    EXPECT_NEAR(read->time_s, count / 24.0, 1e-3);
    ++count;
  }
  EXPECT_EQ(count, 12);
  EXPECT_EQ(reader.Problem(), "");
}

TEST(VideoWriter, NamesAWrongSizeAndAMissingFolder) {
  const test::ScratchFolder scratch;
  VideoWriter writer(scratch / "video.mp4", {32, 32}, 30);
  EXPECT_THROW(writer.Add(cv::Mat(16, 32, CV_8UC3)), Error);
  EXPECT_THROW(VideoWriter(scratch / "none/video.mp4", {32, 32}, 30), Error);
}

}  // namespace
}  // namespace ulf::video_writer_test
