// Tests: core/image/clipped, core/image/files/raw_file.
#include "core/image/clipped.h"

#include <gtest/gtest.h>

#include <fstream>

#include "core/image/files/raw_file.h"
#include "tests/support/dng_file.h"
#include "tests/support/test_paths.h"

namespace ulf::test::clipped_test {
namespace {

TEST(Clipped, IsWhatIsFullInAnyChannel) {
  cv::Mat pixels(6, 8, CV_8UC3, cv::Scalar(10, 20, 30));
  EXPECT_TRUE(ClippedPixels({.pixels = pixels}).empty());
  pixels.at<cv::Vec3b>(2, 3)[1] = 255;
  pixels.at<cv::Vec3b>(4, 5)[2] = 254;
  pixels.at<cv::Vec3b>(4, 6)[2] = 253;
  const cv::Mat clipped = ClippedPixels({.pixels = pixels});
  EXPECT_EQ(cv::countNonZero(clipped), 2);
  EXPECT_EQ(clipped.at<std::uint8_t>(2, 3), 255);
  EXPECT_EQ(clipped.at<std::uint8_t>(4, 5), 255);
  cv::Mat wide(6, 8, CV_16UC1, cv::Scalar(60000));
  wide.at<std::uint16_t>(1, 1) = 65535;
  EXPECT_EQ(cv::countNonZero(ClippedPixels({.pixels = wide, .transfer = Transfer::kLinear})), 1);
  // Float numbers have no full scale.
  EXPECT_TRUE(
      ClippedPixels({.pixels = cv::Mat(4, 4, CV_32FC3, cv::Scalar::all(7)), .transfer = Transfer::kLinear})
          .empty());
}

// Every pixel whose demosaiced colour differs from what a sensor without a limit would have shown is marked.
TEST(Clipped, InAMosaicIsWhatFullPixelsReach) {
  cv::RNG random(4);
  cv::Mat mosaic(40, 48, CV_16UC1);
  random.fill(mosaic, cv::RNG::UNIFORM, 20000, 40000);
  cv::Mat beyond = mosaic.clone(), full = mosaic.clone();
  for (const cv::Point at : {cv::Point(10, 11), {11, 11}, {30, 20}, {31, 29}}) {
    beyond.at<std::uint16_t>(at) = 60000;
    full.at<std::uint16_t>(at) = 65535;
  }
  for (const Mosaic pattern : {Mosaic::kRggb, Mosaic::kGrbg}) {
    const Image image{.pixels = full, .transfer = Transfer::kLinear, .mosaic = pattern};
    const cv::Mat clipped = ClippedPixels(image);
    cv::Mat difference;
    cv::absdiff(Demosaiced(image).pixels,
                Demosaiced({.pixels = beyond, .transfer = Transfer::kLinear, .mosaic = pattern}).pixels,
                difference);
    int touched = 0;
    for (int y = 0; y < clipped.rows; ++y)
      for (int x = 0; x < clipped.cols; ++x)
        if (difference.at<cv::Vec3w>(y, x) != cv::Vec3w(0, 0, 0)) {
          EXPECT_EQ(clipped.at<std::uint8_t>(y, x), 255) << x << " " << y;
          ++touched;
        }
    EXPECT_GT(touched, 8);
    EXPECT_LT(cv::countNonZero(clipped), 40);
  }
}

// A red lamp: only the sensor's red is full, and the colour matrix leaves no number of the light
// at full scale.
TEST(Clipped, InARawFileIsFoundBeforeTheColourMatrix) {
  const cv::Rect lamp(30, 24, 20, 16);  // of the visible area
  const auto bytes = [&](double red) {
    return DngBytes({}, [&, red](int x, int y) {
      return lamp.contains({x, y}) ? cv::Vec3d(red, 0.55 * red, 0.3 * red) : cv::Vec3d(0.2, 0.25, 0.2);
    });
  };
  ScratchFolder scratch;
  const cv::Rect crop = *DngCamera{}.crop;
  for (const auto& [red, clips] : {std::pair{0.5, false}, {2.5, true}}) {
    const std::string path = (scratch / "lamp.dng").string();
    std::ofstream(path, std::ios::binary) << bytes(red);
    cv::Mat clipped;
    const cv::Mat light = ReadRawFile(path, std::nullopt, std::nullopt, &clipped);
    ASSERT_EQ(light.size(), crop.size());
    if (!clips) {
      EXPECT_TRUE(clipped.empty());
      continue;
    }
    ASSERT_EQ(clipped.size(), light.size());
    const cv::Rect inside(lamp.x - crop.x + 2, lamp.y - crop.y + 2, lamp.width - 4, lamp.height - 4);
    EXPECT_EQ(cv::countNonZero(clipped(inside)), inside.area());
    EXPECT_LE(cv::countNonZero(clipped), (lamp.width + 4) * (lamp.height + 4));
  }
}

}  // namespace
}  // namespace ulf::test::clipped_test
