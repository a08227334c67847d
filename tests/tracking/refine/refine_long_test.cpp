// Tests: tracking/estimation/calibration_check, tracking/refine/refine.
// Refining on real pictures with measured poses, and over several seeds.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/quantile.h"
#include "core/image/files/picture_file.h"
#include "tests/support/floors.h"
#include "tests/support/pose_readers.h"
#include "tests/support/test_paths.h"
#include "tests/tracking/refine/refine_views.h"

namespace ulf::refine_long_test {
namespace {

using test::Disturbed;
using test::ErrorsOf;
using test::MakeViews;
using test::PoseErrors;
using test::RefineRoom;

TEST(CalibrationCheck, ARightFocalLengthIsNotDoubted) {
  for (const unsigned seed : {1u, 2u, 3u, 4u, 5u}) {
    const auto views = MakeViews(14, 0.005, 0.05, seed);
    const RefineResult result = RefineRoom(*views);
    ASSERT_EQ(result.checks.size(), 1u);
    EXPECT_FALSE(result.checks[0].Wrong()) << "seed " << seed << ": " << result.checks[0].Text();
    EXPECT_TRUE(result.checks[0].determined);
  }
}

// Real pictures with measured poses, disturbed by a percent of the distance and a degree.
struct TrueData {
  RefineInput input;
  std::vector<Rigid3> truth;
  double distance = 0;
};

std::unique_ptr<TrueData> DisturbedData(const std::vector<test::TrueView>& views, unsigned seed) {
  auto data = std::make_unique<TrueData>();
  LightField axes;
  for (const test::TrueView& view : views) {
    axes.cameras.push_back(view.camera);
    View& posed = axes.views.emplace_back();
    posed.camera = static_cast<int>(axes.cameras.size()) - 1;
    posed.cam_from_world = view.cam_from_world;
  }
  const auto subject = SubjectFromAxes(axes);
  data->distance =
      subject ? (subject->center_in_world - views[0].cam_from_world.OriginInSource()).norm()
              : (views[0].cam_from_world.OriginInSource() - views[1].cam_from_world.OriginInSource()).norm();
  test::Draw draw(seed);
  for (const test::TrueView& view : views) {
    auto& lenses = data->input.lenses;
    if (std::find(lenses.begin(), lenses.end(), view.camera) == lenses.end()) lenses.push_back(view.camera);
    const auto lens = static_cast<int>(std::find(lenses.begin(), lenses.end(), view.camera) - lenses.begin());
    data->truth.push_back(view.cam_from_world);
    data->input.views.push_back({view.image.filename().string(), lens,
                                 Disturbed(view.cam_from_world, 0.01 * data->distance, 1, draw)});
  }
  data->input.read = [views](int i) {
    return Image{ReadImageFile(views[static_cast<std::size_t>(i)].image.string()), Transfer::kSrgb,
                 Mosaic::kNone};
  };
  return data;
}

// As ErrorsOf, but turned so that all orientations agree best, too: a row of cameras does not hold its
// rotation about itself by positions.
PoseErrors ErrorsWithOrientation(const TrueData& data, const RefineResult& result) {
  const PoseErrors by_centers =
      ErrorsOf(data.truth, [&](std::size_t i) { return result.views[i].cam_from_world; });
  std::vector<Eigen::Vector3d> from, to;
  for (std::size_t i = 0; i < data.truth.size(); ++i)
    for (int axis = 0; axis < 3; ++axis) {
      from.push_back(result.views[i].cam_from_world.DirectionInSource(Eigen::Vector3d::Unit(axis)));
      to.push_back(data.truth[i].DirectionInSource(Eigen::Vector3d::Unit(axis)));
    }
  const Eigen::Quaterniond turn(AlignPoints(from, to)->rotation);
  double squared = 0;
  for (std::size_t i = 0; i < data.truth.size(); ++i)
    squared += std::pow(test::DegreesBetween(result.views[i].cam_from_world.rotation * turn.conjugate(),
                                             data.truth[i].rotation),
                        2);
  return {by_centers.center, std::sqrt(squared / static_cast<double>(data.truth.size()))};
}

// Medians of five seeds.
void ExpectBack(const std::vector<test::TrueView>& views, const char* name, double share, double angle_deg) {
  std::vector<double> centers, rotations_deg;
  for (const unsigned seed : {1u, 2u, 3u, 4u, 5u}) {
    const auto data = DisturbedData(views, seed);
    const RefineResult result = Refine(data->input);
    EXPECT_EQ(result.registered, static_cast<int>(views.size())) << name;
    EXPECT_EQ(result.groups, 1) << name;
    const PoseErrors after = ErrorsWithOrientation(*data, result);
    fmt::print("{}, seed {}: centres {:.4f} % of the distance, rotation {:.4f} degrees, {:.3f} px\n", name,
               seed, 100 * after.center / data->distance, after.rotation_deg, result.median_after_px);
    centers.push_back(after.center / data->distance);
    rotations_deg.push_back(after.rotation_deg);
  }
  const double center = Median(std::move(centers)), rotation_deg = Median(std::move(rotations_deg));
  fmt::print("{}, median: centres {:.4f} %, rotation {:.4f} degrees\n", name, 100 * center, rotation_deg);
  EXPECT_LT(center, share) << name;
  EXPECT_LT(rotation_deg, angle_deg) << name;
}

// 0.1 % and 0.05 degrees are wanted. COLMAP 3.8 on the same pictures with the lens held: 0.272 and 0.213.
TEST(RefineData, TempleRingComesBackBetterThanCOLMAPs) {
  ULF_NEED_TEST_DATA(folder, "temple_ring");
  ExpectBack(test::ReadMiddlebury(folder, "templeR_par.txt"), "temple_ring", 0.00272, 0.213);
}

TEST(RefineData, StrechaComesBack) {
  ULF_NEED_TEST_DATA(folder, "strecha");
  for (const char* name : {"fountain-P11", "Herz-Jesus-P8"})
    ExpectBack(test::ReadStrecha(folder / name), name, 0.001, 0.05);
}

}  // namespace
}  // namespace ulf::refine_long_test
