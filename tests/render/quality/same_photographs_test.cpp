// Tests: render/quality/same_photographs.
#include "render/quality/same_photographs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::same_photographs_test {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::Pair;

constexpr int kWidth = 120, kHeight = 90;

// Smooth light with an edge, other for every number; a camera's noise on it.
cv::Mat Scene(int number, double noise = 0) {
  cv::Mat picture(kHeight, kWidth, CV_8UC3);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      picture.at<cv::Vec3b>(y, x) = {static_cast<std::uint8_t>(128 + 80 * std::sin(0.1 * x + 2 * number)),
                                     static_cast<std::uint8_t>(128 + 80 * std::sin(0.1 * y - number)),
                                     static_cast<std::uint8_t>(x > 10 * number ? 200 : 60)};
  cv::Mat grain(picture.size(), CV_16SC3);
  cv::RNG(static_cast<std::uint64_t>(number) + 7).fill(grain, cv::RNG::NORMAL, 0, noise);
  cv::add(picture, grain, picture, cv::noArray(), CV_8U);
  return picture;
}

class SamePhotographs : public testing::Test {
 protected:
  // A light field of these pictures, by the names of their files.
  LightField Written(const std::string& folder,
                     const std::vector<std::pair<std::string, cv::Mat>>& pictures) {
    LightField light_field;
    light_field.root = scratch_ / folder;
    for (const auto& [name, picture] : pictures) {
      View view;
      view.id = static_cast<int>(light_field.views.size()) + 1;
      view.image_path = "images/" + name;
      view.camera = static_cast<int>(light_field.cameras.size());
      light_field.cameras.push_back(CameraModel::Pinhole(picture.cols, picture.rows, 100));
      light_field.views.push_back(view);
      fs::create_directories((light_field.root / view.image_path).parent_path());
      cv::imwrite((light_field.root / view.image_path).string(), picture, {cv::IMWRITE_JPEG_QUALITY, 60});
    }
    return light_field;
  }
  static std::vector<std::pair<int, int>> Pairs(const SharedPhotographs& shared) {
    std::vector<std::pair<int, int>> pairs;
    for (const SharedPhotograph& each : shared.found) pairs.emplace_back(each.in_first, each.in_second);
    return pairs;
  }
  test::ScratchFolder scratch_;
};

// Two captures of one recording keep other frames of it, under numbers of their own.
TEST_F(SamePhotographs, AreFoundByContentUnderOtherNames) {
  const LightField first = Written("a", {{"1.png", Scene(1)}, {"2.png", Scene(2)}, {"3.png", Scene(3)}});
  const LightField second =
      Written("b", {{"1.png", Scene(3)}, {"2.png", Scene(4)}, {"sub/x.png", Scene(1)}, {"3.png", Scene(2)}});
  const SharedPhotographs shared = PhotographsInBoth(first, second);
  EXPECT_THAT(Pairs(shared), ElementsAre(Pair(0, 2), Pair(1, 3), Pair(2, 0)));
  EXPECT_EQ(shared.other_pictures, 0u);
}

TEST_F(SamePhotographs, MayBeEncodedOtherwise) {
  const LightField first = Written("a", {{"1.png", Scene(1, 8)}, {"2.png", Scene(2, 8)}}),
                   second = Written("b", {{"2.jpg", Scene(2, 8)}, {"1.jpg", Scene(1, 8)}});
  EXPECT_THAT(Pairs(PhotographsInBoth(first, second)), ElementsAre(Pair(0, 1), Pair(1, 0)));
}

// Every capture has a first photograph; an undistorted or smaller copy is not the one that was recorded.
TEST_F(SamePhotographs, OfOneNameMayBeOthers) {
  cv::Mat moved, smaller;
  const cv::Mat shift = (cv::Mat_<double>(2, 3) << 1, 0, 2, 0, 1, 1);
  cv::warpAffine(Scene(2), moved, shift, {kWidth, kHeight}, cv::INTER_CUBIC, cv::BORDER_REPLICATE);
  cv::resize(Scene(3), smaller, {kWidth / 2, kHeight / 2}, 0, 0, cv::INTER_AREA);
  const LightField first = Written("a", {{"1.png", Scene(1)}, {"2.png", Scene(2)}, {"3.png", Scene(3)}}),
                   second = Written("b", {{"1.png", Scene(5)}, {"2.png", moved}, {"3.png", smaller}});
  const SharedPhotographs shared = PhotographsInBoth(first, second);
  EXPECT_TRUE(shared.found.empty());
  EXPECT_EQ(shared.other_pictures, 3u);
}

// The same picture twice is no view twice.
TEST_F(SamePhotographs, ArePairedOnce) {
  const LightField twice = Written("a", {{"1.png", Scene(1)}, {"2.png", Scene(1)}}),
                   once = Written("b", {{"7.png", Scene(1)}});
  EXPECT_EQ(Pairs(PhotographsInBoth(twice, once)).size(), 1u);
  EXPECT_EQ(Pairs(PhotographsInBoth(once, twice)).size(), 1u);
  EXPECT_EQ(Pairs(PhotographsInBoth(twice, twice)).size(), 2u);
}

}  // namespace
}  // namespace ulf::same_photographs_test
