// Tests: render/masks/turntable_masks, render/masks/still_background, render/masks/background_cut,
// render/masks/silhouette_hull.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "core/base/error.h"
#include "core/base/quantile.h"
#include "core/image/image.h"
#include "core/light_field/folder/view_images.h"
#include "render/masks/background_cut.h"
#include "render/masks/silhouette_hull.h"
#include "render/masks/still_background.h"
#include "render/masks/turntable_masks.h"
#include "tests/render/masks/turntable_scene.h"
#include "tests/support/floors.h"
#include "tests/support/pose_readers.h"
#include "tests/support/test_paths.h"

namespace ulf::turntable_masks_test {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr const char* kSmall = "width=320&height=240&cap=60x12&row_deg=12";

std::vector<double> Overlaps(const test::TurntableField& field, const std::map<int, cv::Mat>& masks) {
  std::vector<double> overlaps;
  for (const auto& [id, mask] : masks) overlaps.push_back(test::OverlapOf(mask, field.truth.at(id)));
  return overlaps;
}

TEST(TurntableMasks, FitTheTruthOfTheSimulator) {
  test::ScratchFolder scratch;
  const auto field = test::MakeTurntableField(scratch / "field", kSmall, 20, 2);
  const TurntableMasks masks = MakeTurntableMasks(field.light_field);
  ASSERT_EQ(masks.masks.size(), 40u);
  EXPECT_EQ(masks.stands.size(), 2u);
  const std::vector<double> overlaps = Overlaps(field, masks.masks);
  EXPECT_GT(Quantile(overlaps, 0.5), 0.95);
  EXPECT_GT(Quantile(overlaps, 0), 0.9);
}

// A tripod that trembles by a hundredth of a hand's tremble, and by so much that it is said.
TEST(TurntableMasks, AWobblingCameraIsEvenedOutAndSaid) {
  test::ScratchFolder scratch;
  const auto field =
      test::MakeTurntableField(scratch / "field", std::string(kSmall) + "&unsteady=0.05", 20, 1);
  const TurntableMasks masks = MakeTurntableMasks(field.light_field);
  ASSERT_EQ(masks.stands.size(), 1u);
  EXPECT_GT(masks.stands[0].shift_px, 0.2);
  EXPECT_GT(Quantile(Overlaps(field, masks.masks), 0.5), 0.93);
}

TEST(TurntableMasks, RefusesWhatDoesNotTurn) {
  test::ScratchFolder scratch;
  auto field =
      test::MakeTurntableField(scratch / "field", std::string(kSmall) + "&turn_deg_s=24", 10, 1).light_field;
  for (View& view : field.views) view.cam_from_world = field.views.front().cam_from_world;
  EXPECT_THAT(
      [&] { MakeTurntableMasks(field); },
      ThrowsMessage<Error>(AllOf(HasSubstr("turn about one axis"), HasSubstr("let the camera stand"))));
}

// A plaster temple before black cloth, whose cameras see one axis in one place: to the pictures it turned.
// The cloth is dark and the plaster is not, but where it is in shadow.
TEST(TurntableMasks, FitThePlasterOfARealRing) {
  ULF_NEED_TEST_DATA(dir, "temple_ring");
  const LightField light_field = test::MiddleburyLightField(dir, "templeR_par.txt");
  const TurntableMasks masks = MakeTurntableMasks(light_field);
  EXPECT_EQ(masks.stands.size(), 2u) << "the gantry stood the other way up for a part";
  EXPECT_EQ(masks.views_between, 0);
  std::vector<double> overlaps;
  for (const View& view : light_field.views) {
    cv::Mat grey = GrayForTracking(ReadRecordedImage(light_field, view)), bright;
    cv::GaussianBlur(grey, grey, {}, 1);
    cv::morphologyEx(grey > 48, bright, cv::MORPH_CLOSE, cv::Mat::ones(5, 5, CV_8U));
    overlaps.push_back(test::OverlapOf(masks.masks.at(view.id), bright));
  }
  std::printf("temple_ring: IoU with what is bright %.3f (median), %.3f (least)\n", Quantile(overlaps, 0.5),
              Quantile(overlaps, 0));
  EXPECT_GT(Quantile(overlaps, 0.5), 0.9);
  EXPECT_GT(Quantile(overlaps, 0), 0.75);
}

// Noise on a still wall, before which a square comes and goes; a corner of the picture always shows
// something else.
TEST(StillBackground, IsWhatRecursAndNotWhatChanges) {
  std::mt19937 random(7);
  std::normal_distribution<float> noise(0, 2);
  std::uniform_int_distribution<int> any(0, 255);
  cv::Mat wall(40, 60, CV_8UC3);
  for (int y = 0; y < wall.rows; ++y)
    for (int x = 0; x < wall.cols; ++x) wall.at<cv::Vec3b>(y, x) = cv::Vec3b::all(any(random));
  std::vector<cv::Mat> pictures;
  for (int i = 0; i < 24; ++i) {
    cv::Mat picture = wall.clone();
    for (int y = 0; y < wall.rows; ++y)
      for (int x = 0; x < wall.cols; ++x) {
        auto& pixel = picture.at<cv::Vec3b>(y, x);
        const bool covered = x >= 2 * i && x < 2 * i + 12;
        const bool restless = x >= 50 && y < 10;
        for (int c = 0; c < 3; ++c)
          pixel[c] = covered || restless ? static_cast<std::uint8_t>(any(random))
                                         : cv::saturate_cast<std::uint8_t>(pixel[c] + noise(random));
      }
    pictures.push_back(picture);
  }
  const StillBackground background = EstimateBackground(pictures, {});
  EXPECT_NEAR(cv::mean(background.noise)[0], 2, 1) << "too much, as a third of the pixels change";
  for (int y = 12; y < 40; ++y)
    for (int x = 12; x < 48; ++x) {
      EXPECT_GT(background.known.at<float>(y, x), 0.9f) << x << " " << y;
      EXPECT_LT(cv::norm(background.color.at<cv::Vec3f>(y, x) - cv::Vec3f(wall.at<cv::Vec3b>(y, x))), 8)
          << x << " " << y;
    }
  cv::Mat restless = background.known(cv::Rect(50, 0, 10, 10));
  EXPECT_LT(cv::mean(restless)[0], 0.1);
  EXPECT_EQ(cv::countNonZero(background.still(cv::Rect(50, 0, 10, 10))), 0);
  // The square of the last picture is cut from it.
  const cv::Mat cut = CutFromBackground(pictures[10], background, cv::Mat::zeros(wall.size(), CV_8U), {});
  EXPECT_GT(cv::countNonZero(cut(cv::Rect(21, 12, 10, 26))), 250);
  EXPECT_EQ(cv::countNonZero(cut(cv::Rect(0, 12, 18, 26))), 0);
}

TEST(StillBackground, TellsByHowMuchAPictureIsShifted) {
  cv::Mat wall(120, 160, CV_8UC3);
  cv::RNG random(5);
  random.fill(wall, cv::RNG::UNIFORM, 0, 255);
  cv::GaussianBlur(wall, wall, {}, 3);
  cv::normalize(wall, wall, 0, 255, cv::NORM_MINMAX);
  const StillBackground background = EstimateBackground(std::vector<cv::Mat>(6, wall), {});
  cv::Mat moved;
  cv::warpAffine(wall, moved, cv::Matx23d(1, 0, 1.5, 0, 1, -0.75), wall.size(), cv::INTER_CUBIC,
                 cv::BORDER_REPLICATE);
  const cv::Point2d shift = ShiftAgainst(background, moved);
  EXPECT_NEAR(shift.x, 1.5, 0.1);
  EXPECT_NEAR(shift.y, -0.75, 0.1);
}

// Of a ball, though one silhouette in twelve is empty.
TEST(SilhouetteHull, HoldsTheBallAndForgivesASilhouette) {
  const CameraModel camera = CameraModel::Pinhole(160, 120, 150);
  std::vector<Silhouette> silhouettes;
  const auto seen_from = [&](const Rigid3& pose) {
    cv::Mat mask = cv::Mat::zeros(camera.height, camera.width, CV_8U);
    for (int y = 0; y < mask.rows; ++y)
      for (int x = 0; x < mask.cols; ++x)
        if (camera.RayFromImg({x + 0.5, y + 0.5})->cross(pose * Eigen::Vector3d::Zero()).norm() < 0.3)
          mask.at<std::uint8_t>(y, x) = 255;
    return mask;
  };
  for (int i = 0; i < 24; ++i) {
    const double angle = 2 * M_PI * i / 24, height = i % 2 == 0 ? 0.4 : 1.2;
    const Rigid3 pose = LookAt({1.5 * std::cos(angle), 1.5 * std::sin(angle), height},
                               Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ());
    silhouettes.push_back(
        {camera, pose, i == 5 ? cv::Mat(cv::Mat::zeros(120, 160, CV_8U)) : seen_from(pose)});
  }
  const SilhouetteHull hull(silhouettes, Eigen::Vector3d::Zero(), 0.5, 64);
  ASSERT_FALSE(hull.empty());
  const Rigid3 pose = silhouettes[5].cam_from_world;
  const cv::Mat seen = hull.ProjectedInto(camera, pose), truth = seen_from(pose);
  EXPECT_EQ(cv::countNonZero(truth & ~seen), 0) << "the ball is in its hull";
  EXPECT_LT(cv::countNonZero(seen), 1.25 * cv::countNonZero(truth));
}

}  // namespace
}  // namespace ulf::turntable_masks_test
