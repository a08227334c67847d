// The true poses of real pictures, as their readers understand them, against the pictures themselves.
#include "tests/support/pose_readers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numeric>

#include "core/base/quantile.h"
#include "core/image/files/picture_file.h"
#include "core/image/image.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"
#include "tracking/estimation/relative_pose.h"
#include "tracking/features/features.h"
#include "tracking/features/matching.h"

namespace ulf {
namespace {

FeatureSet FeaturesOf(const test::TrueView& view) {
  FeatureExtractor extractor(view.camera);
  Image image{ReadImageFile(view.image.string()), Transfer::kSrgb, Mosaic::kNone};
  const Pyramid pyramid = BuildPyramid(GrayForTracking(image));
  extractor.Extract(pyramid, 3000);  // the corner threshold settles
  return extractor.Extract(pyramid, 3000);
}

// Distances of matches, found without poses, from the epipolar lines of the true poses, px.
void AddEpipolarErrors(const test::TrueView& first, const test::TrueView& second,
                       std::vector<double>& errors) {
  const FeatureSet a = FeaturesOf(first), b = FeaturesOf(second);
  const auto matches = MatchAll(a, AllOf(a), b, AllOf(b), {.max_distance = 50, .max_ratio = 0.8});
  const Eigen::Matrix3d essential = EssentialFromPose(second.cam_from_world * first.cam_from_world.Inverse());
  for (const FeatureMatch& match : matches)
    errors.push_back(first.camera.MeanFocalPx() *
                     std::abs(EpipolarError(essential, {a[match.first].ray, b[match.second].ray})));
}

TEST(PoseReadersData, TempleRingMatchesMeetEpipolarLines) {
  ULF_NEED_TEST_DATA(folder, "temple_ring");
  const auto views = test::ReadMiddlebury(folder, "templeR_par.txt");
  ASSERT_EQ(views.size(), 47u);
  std::vector<double> errors;  // the plaster gives few matches a pair
  for (std::size_t i = 8; i < 28; i += 4) AddEpipolarErrors(views[i], views[i + 1], errors);
  EXPECT_GT(errors.size(), 100u);
  EXPECT_LT(Median(errors), 1);
  // Neighbours of which the gantry took one upside down.
  errors.clear();
  AddEpipolarErrors(views[12], views[41], errors);
  EXPECT_GT(errors.size(), 30u);
  EXPECT_LT(Median(errors), 1);
}

TEST(PoseReadersData, StrechaMatchesMeetEpipolarLines) {
  ULF_NEED_TEST_DATA(folder, "strecha");
  for (const auto& [name, count] : {std::pair{"fountain-P11", 11u}, {"Herz-Jesus-P8", 8u}}) {
    const auto views = test::ReadStrecha(folder / name);
    ASSERT_EQ(views.size(), count);
    std::vector<double> errors;
    AddEpipolarErrors(views[4], views[5], errors);
    EXPECT_GT(errors.size(), 100u) << name;
    EXPECT_LT(Median(errors), 1) << name;
  }
}

TEST(PoseReaders, ConventionsAreAsDescribed) {
  const test::ScratchFolder scratch;
  std::ofstream(scratch / "par.txt") << "1\na.png 500 0 320 0 510 240 0 0 1  0 1 0 -1 0 0 0 0 1  1 2 3\n";
  const auto middlebury = test::ReadMiddlebury(scratch.path(), "par.txt");
  ASSERT_EQ(middlebury.size(), 1u);
  EXPECT_EQ(middlebury[0].camera.cx, 320.5);
  EXPECT_LT((middlebury[0].cam_from_world * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(1, 1, 3)).norm(),
            1e-9);

  std::filesystem::create_directories(scratch / "gt_cameras_half");
  std::ofstream(scratch / "gt_cameras_half/0000.jpg.camera")
      << "500 0 320\n0 510 240\n0 0 1\n0 0 0\n0 1 0\n-1 0 0\n0 0 1\n1 2 3\n640 480\n";
  const auto strecha = test::ReadStrecha(scratch.path());
  ASSERT_EQ(strecha.size(), 1u);
  EXPECT_EQ(strecha[0].camera.cx, 320);
  EXPECT_LT((strecha[0].cam_from_world.OriginInSource() - Eigen::Vector3d(1, 2, 3)).norm(), 1e-9);
  EXPECT_LT((strecha[0].cam_from_world.DirectionInSource({1, 0, 0}) - Eigen::Vector3d(0, -1, 0)).norm(),
            1e-9);
}

}  // namespace
}  // namespace ulf
