// Tests: tracking/features/features, tracking/features/matching, tracking/features/patch_alignment.
#include "tracking/features/features.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "tests/support/floors.h"
#include "tests/tracking/scenes/geometry_scene.h"
#include "tests/tracking/scenes/textured_room.h"
#include "tracking/features/matching.h"
#include "tracking/features/patch_alignment.h"

namespace ulf::features_test {
namespace {

using test::TexturedRoom;

cv::Mat RoomImage(const Rigid3& pose, std::uint64_t id, double noise = 2) {
  static const TexturedRoom quiet({.noise = 0}), noisy({.noise = 2});
  return (noise > 0 ? noisy : quiet).Take(pose, id).image.pixels;
}

FeatureSet Extract(const cv::Mat& image, int count = 1000, const FeatureOptions& options = {}) {
  FeatureExtractor extractor(TexturedRoom::Camera(), options);
  return extractor.Extract(BuildPyramid(image), count);
}

TEST(Features, ColourOfAPointIsItsPixels) {
  cv::Mat colours(2, 3, CV_8UC3, cv::Scalar(0, 0, 0)), grey(2, 3, CV_8UC1, cv::Scalar(90));
  colours.at<cv::Vec3b>(1, 2) = {10, 20, 30};  // B, G, R
  grey.at<std::uint8_t>(1, 2) = 40;
  using Rgb = std::array<std::uint8_t, 3>;
  EXPECT_EQ(tracking::RgbAt(colours, {2.9, 1.1}), (Rgb{30, 20, 10}));
  EXPECT_EQ(tracking::RgbAt(colours, {1.9, 1.1}), (Rgb{0, 0, 0}));
  EXPECT_EQ(tracking::RgbAt(colours, {7, 7}), (Rgb{30, 20, 10})) << "the nearest pixel that there is";
  EXPECT_EQ(tracking::RgbAt(grey, {2.5, 1.5}), (Rgb{40, 40, 40}));
}

TEST(Features, AreSpreadOverTheImage) {
  const FeatureSet features = Extract(RoomImage(TexturedRoom::HandAt(0), 0));
  EXPECT_GT(features.size(), 700);
  EXPECT_LE(features.size(), 1010);
  std::array<int, 16> in_cell{};
  for (const Feature& feature : features.all())
    ++in_cell[static_cast<std::size_t>(static_cast<int>(feature.img.y() / 120) * 4 +
                                       static_cast<int>(feature.img.x() / 160))];
  // Evenly would be 62 a cell.
  EXPECT_GE(*std::min_element(in_cell.begin(), in_cell.end()), 25);
}

TEST(Features, RaysBelongToTheirPixels) {
  const CameraModel camera = TexturedRoom::Camera();
  const FeatureSet features = Extract(RoomImage(TexturedRoom::HandAt(0), 0));
  for (const Feature& feature : features.all()) {
    EXPECT_NEAR(feature.ray.norm(), 1, 1e-12);
    EXPECT_LT((*camera.ImgFromCam(feature.ray) - feature.img).norm(), 1e-9);
  }
}

TEST(Features, AFlatGreyImageHasNone) {
  EXPECT_EQ(Extract(cv::Mat(480, 640, CV_8U, cv::Scalar(90))).size(), 0);
}

TEST(Features, ATinyImageHasNone) {
  FeatureExtractor extractor(CameraModel::Pinhole(30, 20, 30));
  EXPECT_EQ(extractor.Extract(BuildPyramid(cv::Mat(20, 30, CV_8U, cv::Scalar(90))), 100).size(), 0);
}

// Shifting a picture by whole pixels must shift every level's features by just that: no level is biased.
TEST(Features, CoarseLevelsAreNotBiased) {
  const cv::Mat image = RoomImage(TexturedRoom::HandAt(0), 0, 0);
  cv::Mat mirrored;
  cv::flip(image, mirrored, 1);
  const FeatureOptions all{.levels = kPyramidLevels};
  const FeatureSet features = Extract(image, 1000, all), flipped = Extract(mirrored, 1000, all);
  // A corner at x is at 640 - x in the mirrored picture. A half-pixel mistake on a level shows as a shift of
  // its size.
  std::array<std::vector<double>, kPyramidLevels> offsets;
  for (const Feature& feature : features.all()) {
    const Eigen::Vector2d expected(640 - feature.img.x(), feature.img.y());
    double nearest = 1.5 * LevelScale(feature.level), offset = 0;
    bool any = false;
    flipped.ForEachNear(expected, nearest, feature.level, feature.level, [&](int i) {
      const double apart = (flipped[i].img - expected).norm();
      if (apart < nearest) {
        nearest = apart;
        offset = flipped[i].img.x() - expected.x();
        any = true;
      }
    });
    if (any) offsets[static_cast<std::size_t>(feature.level)].push_back(offset);
  }
  for (int level = 0; level < 6; ++level) {
    const auto& found = offsets[static_cast<std::size_t>(level)];
    ASSERT_GT(found.size(), 10u) << "level " << level;
    double mean = 0;
    for (const double offset : found) mean += offset / static_cast<double>(found.size());
    EXPECT_LT(std::abs(mean), 0.12 * LevelScale(level)) << "level " << level;
  }
}

TEST(Features, WindowSearchFindsWhatBruteForceFinds) {
  const FeatureSet features = Extract(RoomImage(TexturedRoom::HandAt(0), 0));
  test::Draw draw(3);
  for (int round = 0; round < 100; ++round) {
    const Eigen::Vector2d at(draw.Uniform(-30, 670), draw.Uniform(-30, 510));
    const double radius = draw.Uniform(1, 60);
    std::vector<int> found, expected;
    features.ForEachNear(at, radius, 1, 4, [&](int i) { found.push_back(i); });
    for (int i = 0; i < features.size(); ++i)
      if (features[i].level >= 1 && features[i].level <= 4 && (features[i].img - at).norm() <= radius)
        expected.push_back(i);
    std::sort(found.begin(), found.end());
    EXPECT_EQ(found, expected);
  }
}

TEST(Matching, NeighbouringViewsAgreeWithTheTruth) {
  // Small turns about the centre: every pixel's motion is known without depth.
  const CameraModel camera = TexturedRoom::Camera();
  const Rigid3 first_pose = TexturedRoom::TurningAt(0), second_pose = TexturedRoom::TurningAt(3);
  const FeatureSet first = Extract(RoomImage(first_pose, 0)), second = Extract(RoomImage(second_pose, 1));
  std::vector<Eigen::Vector2d> expected;
  for (const Feature& feature : first.all()) expected.push_back(feature.img);
  const Eigen::Quaterniond second_from_first = second_pose.rotation * first_pose.rotation.conjugate();
  const auto matches = MatchInWindow(first, second, expected, 60);
  ASSERT_GT(matches.size(), 250u);
  int right = 0;
  for (const FeatureMatch& match : matches) {
    const auto img = camera.ImgFromCam(second_from_first * first[match.first].ray);
    right += img && (*img - second[match.second].img).norm() < 3 * LevelScale(first[match.first].level);
  }
  EXPECT_GT(right, 0.95 * static_cast<double>(matches.size()));
}

TEST(Matching, AFeatureIsGivenOnce) {
  const FeatureSet features = Extract(RoomImage(TexturedRoom::HandAt(0), 0));
  std::vector<Expected> expected;
  for (int i = 0; i < 20; ++i)  // the same thing wanted twenty times
    expected.push_back({features[7].img, 5, 0, kPyramidLevels - 1, &features[7].descriptor});
  const auto found = MatchExpected(expected, features, {.max_ratio = 1.0});
  EXPECT_EQ(std::count_if(found.begin(), found.end(), [](int f) { return f >= 0; }), 1);
}

// The wall's points seen again from elsewhere: the aligned position against the exact one.
TEST(PatchAlignmentTest, FindsThePlaceUnderWarpAndLight) {
  const CameraModel camera = TexturedRoom::Camera();
  const TexturedRoom wall({.furniture = test::Furniture::kWall, .noise = 2});
  const Rigid3 reference = LookAt({0, 0, 0}, {0, 0, 3}, -Eigen::Vector3d::UnitY());
  const Pyramid reference_pyramid = BuildPyramid(wall.Take(reference, 0).image.pixels);
  FeatureExtractor extractor(camera);
  const FeatureSet features = extractor.Extract(reference_pyramid, 600);
  for (const double gain : {1.0, 0.8})
    for (const Eigen::Vector3d& center : {Eigen::Vector3d(0.15, 0.05, 0), Eigen::Vector3d(-0.1, 0.1, 0.6)}) {
      const Rigid3 pose = LookAt(center, {0.1, 0, 3}, Eigen::Vector3d(0.1, -1, 0).normalized());
      cv::Mat image;
      wall.Take(pose, 1).image.pixels.convertTo(image, CV_8U, gain, 5);
      const Pyramid pyramid = BuildPyramid(image);
      int tried = 0, found = 0;
      double squared = 0;
      for (const Feature& feature : features.all()) {
        const Eigen::Vector3d point = feature.ray * (3 / feature.ray.z());
        const auto truth = camera.ImgFromCam(pose * point);
        const auto patch = CutPatch(reference_pyramid, feature.img, feature.level);
        const auto axes = AxesOf(camera, reference, point, feature.level);
        if (!truth || !camera.Contains(*truth) || !patch || !axes) continue;
        ++tried;
        const auto aligned = AlignPatch(camera, *patch, *axes, point, pose, pyramid,
                                        *truth + Eigen::Vector2d(0.9, -0.8) * LevelScale(feature.level));
        if (!aligned) continue;
        ++found;
        const double error = (aligned->img - *truth).norm() / LevelScale(aligned->level);
        squared += error * error;
      }
      EXPECT_GT(found, 0.85 * tried) << "gain " << gain << ", x " << center.x();
      EXPECT_LT(std::sqrt(squared / found), 0.2) << "gain " << gain << ", x " << center.x();
    }
}

TEST(PatchAlignmentTest, RefusesAnotherPlaceAndTheBorder) {
  const CameraModel camera = TexturedRoom::Camera();
  const cv::Mat image = RoomImage(TexturedRoom::HandAt(0), 0);
  const Pyramid pyramid = BuildPyramid(image);
  FeatureExtractor extractor(camera);
  const FeatureSet features = extractor.Extract(pyramid, 400);
  int wrong = 0, tried = 0;
  for (int i = 0; i + 50 < features.size(); ++i) {
    const auto patch = CutPatch(pyramid, features[i].img, features[i].level);
    const auto axes = AxesOf(camera, Rigid3{}, features[i].ray, features[i].level);
    if (!patch || !axes || (features[i].img - features[i + 50].img).norm() < 60) continue;
    ++tried;
    wrong += AlignPatch(camera, *patch, *axes, features[i].ray, Rigid3{}, pyramid, features[i + 50].img)
                 .has_value();
  }
  ASSERT_GT(tried, 100);
  EXPECT_LT(wrong, 0.03 * tried);
  EXPECT_FALSE(CutPatch(pyramid, {5, 5}, 0));
  EXPECT_FALSE(CutPatch(pyramid, {320, 475}, 2));
}

}  // namespace
}  // namespace ulf::features_test
