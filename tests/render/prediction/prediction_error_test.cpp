// Tests: render/prediction/frame_predictor, render/prediction/prediction_error,
// render/prediction/block_alignment.
//
// The error that is measured at a frame against the error that is there: pictures of two textured planes
// whose geometry is known, so that each kind of error can be made alone.
#include "render/prediction/prediction_error.h"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <random>

#include "core/geometry/angles.h"
#include "render/prediction/block_alignment.h"
#include "render/prediction/frame_predictor.h"
#include "tests/render/stereo/stereo_scenes.h"
#include "tests/support/floors.h"

namespace ulf::prediction_error_test {
namespace {

using Eigen::Vector3d;
using test::Drawn;
using test::Mottled;
using test::Patch;

const Subject kSubject{{0, 0, 3}, 0.4};
constexpr int kWidth = 240, kHeight = 180;
constexpr double kFocalPx = 220;

const Patch kWall{{-8, -6, 4.5}, {16, 0, 0}, {0, 12, 0}, Mottled(0.04, 1)};
const Patch kSlab{{-0.45, -0.45, 3}, {0.9, 0, 0.1}, {0, 0.9, 0}, Mottled(0.15, 2)};

Drawn DrawFrom(const Vector3d& center, const std::vector<Patch>& patches = {kWall, kSlab}) {
  return test::Draw(patches, center, kSubject.center_in_world, kWidth, kHeight, kFocalPx);
}

// Both planes, the slab moved by so much towards the wall.
std::shared_ptr<const TriangleMesh> Mesh(double slab_off = 0) {
  auto mesh = std::make_shared<TriangleMesh>();
  for (Patch patch : {kWall, kSlab}) {
    if (patch.corner.z() < 4) patch.corner.z() += slab_off;
    const auto first = static_cast<std::uint32_t>(mesh->vertices.size());
    for (const Vector3d& corner :
         {patch.corner, Vector3d(patch.corner + patch.side),
          Vector3d(patch.corner + patch.side + patch.other_side), Vector3d(patch.corner + patch.other_side)})
      mesh->vertices.push_back(corner.cast<float>());
    mesh->triangles.push_back({first, first + 1, first + 2});
    mesh->triangles.push_back({first, first + 2, first + 3});
  }
  return mesh;
}

// Three by three views, 0.3 apart, seen once.
const std::vector<Drawn>& Views() {
  static const std::vector<Drawn> views = [] {
    std::vector<Drawn> drawn;
    for (int row = -1; row <= 1; ++row)
      for (int column = -1; column <= 1; ++column) drawn.push_back(DrawFrom({0.3 * column, 0.3 * row, 0}));
    return drawn;
  }();
  return views;
}

const Vector3d kBetween(0.14, 0.11, 0);

StereoView WithNoise(StereoView view, double sigma, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> noise(0, static_cast<float>(sigma));
  view.grey = view.grey.clone();
  for (int y = 0; y < view.grey.rows; ++y)
    for (int x = 0; x < view.grey.cols; ++x) view.grey.at<float>(y, x) += noise(random);
  return view;
}

struct Case {
  double slab_off = 0;     // of the mesh
  double noise_sigma = 0;  // of all pictures
  double gain = 1;         // of the frame
};

FramePredictor PredictorOf(const Case& with) {
  FramePredictor predictor;
  predictor.SetGeometry(kSubject, Mesh(with.slab_off));
  for (std::size_t i = 0; i < Views().size(); ++i)
    predictor.AddView(static_cast<int>(i), with.noise_sigma > 0 ? WithNoise(Views()[i].view, with.noise_sigma,
                                                                            static_cast<unsigned>(i))
                                                                : Views()[i].view);
  return predictor;
}

PredictionError Measured(FramePredictor& predictor, const StereoView& frame,
                         const PoseUncertainty& pose = {}) {
  const auto predicted = predictor.Predict(frame);
  EXPECT_TRUE(predicted);
  return MeasureError(frame, *predicted, predictor.subject(), pose);
}

PredictionError MeasuredWith(const Case& with) {
  FramePredictor predictor = PredictorOf(with);
  StereoView frame = DrawFrom(kBetween).view;
  if (with.noise_sigma > 0) frame = WithNoise(frame, with.noise_sigma, 99);
  frame.grey = frame.grey * with.gain;
  return Measured(predictor, frame);
}

TEST(PredictionError, PerfectLightFieldMeasuresAsPerfect) {
  const PredictionError error = MeasuredWith({});
  EXPECT_GT(error.inside.seen, 8);
  EXPECT_EQ(error.inside.seen, error.inside.blocks);
  EXPECT_GT(error.outside.SeenShare(), 0.85);
  EXPECT_GT(error.inside.MeasuredShare(), 0.9);
  EXPECT_GT(error.outside.MeasuredShare(), 0.8);
  EXPECT_LT(error.inside.misregistration_px, 0.05);
  EXPECT_LT(error.outside.misregistration_px, 0.1);
  EXPECT_GT(error.inside.db, 42);
  EXPECT_EQ(error.on_mesh_share, 1);
  EXPECT_LT(error.pose_off_sigmas, 1);
  EXPECT_NEAR(error.gain_spread, 1, 0.02);
  EXPECT_NEAR(error.nearest_view_angle, std::atan(std::hypot(0.14, 0.11) / 3), 0.01);
}

TEST(PredictionError, NoiseIsNotTheLightFieldsError) {
  for (const double sigma : {2.0, 5.0, 10.0}) {
    const PredictionError error = MeasuredWith({.noise_sigma = sigma});
    EXPECT_GT(error.inside.db, 36) << "noise of " << sigma << " alone: " << 20 * std::log10(255 / sigma);
    EXPECT_LT(error.inside.misregistration_px, 0.12) << sigma;
  }
}

TEST(PredictionError, ExposureIsMatched) {
  const PredictionError error = MeasuredWith({.gain = 0.6});
  EXPECT_GT(error.inside.db, 42);
  EXPECT_LT(error.inside.misregistration_px, 0.05);
}

// The displacement of every block is that which the wrong depth makes between the views and the frame.
TEST(PredictionError, MisregistrationFollowsDepthError) {
  double last = 0, last_db = MeasuredWith({}).inside.db;
  for (const double off : {0.05, 0.15, 0.3}) {
    // Views on both sides of the frame see the slab displaced to both sides: one view alone
    // shows by how much.
    FramePredictor alone({.views = 1});
    alone.SetGeometry(kSubject, Mesh(off));
    alone.AddView(0, Views()[4].view);
    const StereoView frame = DrawFrom(kBetween).view;
    const PredictionError error = Measured(alone, frame, {.center_sigma = 1e-4});
    // Of the point at the sphere's centre: where the ray to it meets the moved slab, and where that
    // is in the view.
    const Vector3d center = kSubject.center_in_world + Vector3d(0, 0, 0.05);
    const Vector3d ray = center - frame.center_in_world;
    const Vector3d shown = frame.center_in_world + ray * ((center.z() + off) / center.z());
    const double wrong = (*Views()[4].view.Project(shown) - *Views()[4].view.Project(center)).norm();
    // A tenth of a pixel may be the pose's.
    EXPECT_NEAR(error.inside.misregistration_px, wrong, 0.15 * wrong + 0.1) << off;
    EXPECT_LT(error.outside.misregistration_px, error.inside.misregistration_px + 0.1) << off;
    EXPECT_GT(error.inside.db_aligned, error.inside.db + 3) << off;
    EXPECT_GT(wrong, last);
    last = wrong;
    const double blended_db = MeasuredWith({.slab_off = off}).inside.db;
    EXPECT_LT(blended_db, last_db - 2) << off;
    last_db = blended_db;
  }
  EXPECT_GT(last, 0.5);
}

TEST(PredictionError, ExcusesErrorsWithinPoseUncertainty) {
  FramePredictor predictor = PredictorOf({});
  const StereoView frame = DrawFrom(kBetween).view;
  const double pixel = 3 / kFocalPx;
  for (const double off_px : {0.5, 1.0, 3.0}) {
    StereoView moved = frame;
    // A turn: all of the picture moves alike.
    const Eigen::AngleAxisd turn(off_px / kFocalPx, Vector3d::UnitY());
    moved.cam_from_world.rotation = turn * moved.cam_from_world.rotation;
    moved.cam_from_world.translation = turn * moved.cam_from_world.translation;
    const PredictionError uncertain = Measured(predictor, moved, {.center_sigma = off_px * pixel});
    EXPECT_LT(uncertain.inside.misregistration_px, 0.2 * off_px) << off_px;
    EXPECT_NEAR(uncertain.pose_px, off_px, 0.3 * off_px) << off_px;
    EXPECT_LT(uncertain.pose_off_sigmas, 1.5) << off_px;
    const PredictionError sure = Measured(predictor, moved, {.center_sigma = 0.1 * pixel});
    EXPECT_GT(sure.pose_off_sigmas, 2 * uncertain.pose_off_sigmas) << off_px;
  }
}

TEST(PredictionError, UnseenPartsAreNotMeasured) {
  FramePredictor predictor;
  predictor.SetGeometry(kSubject, Mesh());
  EXPECT_FALSE(predictor.Predict(DrawFrom(kBetween).view)) << "no views";
  predictor.AddView(0, Views()[4].view);
  StereoView aside = DrawFrom({2.2, 0, 0}).view;
  const PredictionError error = Measured(predictor, aside);
  EXPECT_LT(error.outside.SeenShare(), 0.9);
  EXPECT_LT(error.outside.seen, error.outside.blocks);
  FramePredictor without;
  without.AddView(0, Views()[4].view);
  EXPECT_FALSE(without.Predict(aside)) << "no geometry";
  EXPECT_FALSE(without.has_geometry());
  predictor.RemoveView(0);
  EXPECT_EQ(predictor.views(), 0);
  EXPECT_TRUE(std::isinf(predictor.NearestViewAngle(aside.center_in_world)));
}

TEST(PredictionError, UntexturedPictureIsNotMeasured) {
  const std::vector<Patch> plain{{kWall.corner, kWall.side, kWall.other_side, test::Plain(120)}};
  FramePredictor predictor;
  predictor.SetGeometry(kSubject, Mesh());
  for (int i = 0; i < 3; ++i)
    predictor.AddView(i, WithNoise(DrawFrom({0.2 * i, 0, 0}, plain).view, 2, static_cast<unsigned>(i)));
  const PredictionError error = Measured(predictor, WithNoise(DrawFrom({0.1, 0, 0}, plain).view, 2, 9));
  EXPECT_EQ(error.inside.measured, 0);
  EXPECT_EQ(error.outside.measured, 0);
  EXPECT_EQ(error.inside.misregistration_px, 0);
  EXPECT_LT(error.inside.contrast, 3);
}

TEST(FramePredictor, HiddenPointsUseViewsThatSeeThem) {
  // From the left the slab hides what the frame on the right sees of the wall beside it.
  FramePredictor predictor;
  predictor.SetGeometry(kSubject, Mesh());
  predictor.AddView(0, DrawFrom({-0.6, 0, 0}).view);
  const StereoView frame = DrawFrom({0.3, 0, 0}).view;
  const auto predicted = predictor.Predict(frame);
  ASSERT_TRUE(predicted);
  long unseen_right = 0, wrong = 0;
  const cv::Mat smoothed = Smoothed(frame.grey);
  for (int y = 70; y < 110; ++y)
    for (int x = 30; x < kWidth - 30; ++x) {
      const bool valid = predicted->valid.at<std::uint8_t>(y, x) != 0;
      unseen_right += !valid && x > kWidth / 2;
      wrong += valid && std::abs(predicted->grey.at<float>(y, x) - smoothed.at<float>(y, x)) > 40;
    }
  EXPECT_GT(unseen_right, 100);
  EXPECT_LT(wrong, 250) << "texels at the slab's edge";
}

TEST(FramePredictor, FollowsViewsThatMove) {
  FramePredictor predictor = PredictorOf({});
  const StereoView frame = DrawFrom(kBetween).view;
  std::map<int, Rigid3> moved;
  for (std::size_t i = 0; i < Views().size(); ++i) {
    Rigid3 pose = Views()[i].view.cam_from_world;
    pose.translation.x() += i % 2 ? 0.03 : -0.03;
    moved[static_cast<int>(i)] = pose;
  }
  const double before = Measured(predictor, frame).inside.db;
  predictor.MoveViews(moved);
  EXPECT_LT(Measured(predictor, frame).inside.db, before - 6);
}

TEST(NoiseSigma, MatchesTheNoiseInSmoothRegions) {
  std::vector<Patch> half{{kWall.corner, {8, 0, 0}, kWall.other_side, test::Plain(100)}, kWall};
  half[0].corner.z() -= 0.01;
  for (const double sigma : {1.0, 4.0, 12.0})
    EXPECT_NEAR(NoiseSigma(WithNoise(DrawFrom({0, 0, 0}, half).view, sigma, 3).grey), sigma, 0.2 * sigma);
}

TEST(BlockAlignment, FindsAShiftOfSeveralPixels) {
  const cv::Mat frame = Smoothed(Views()[4].view.grey);
  for (const auto& shift : {Eigen::Vector2d(0.3, -0.4), Eigen::Vector2d(2.5, 1.2), Eigen::Vector2d(-4, 3)}) {
    cv::Mat predicted;
    const cv::Mat move = (cv::Mat_<double>(2, 3) << 1, 0, shift.x(), 0, 1, shift.y());
    cv::warpAffine(frame, predicted, move, frame.size(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    const cv::Mat valid(frame.size(), CV_8U, cv::Scalar(255));
    int right = 0, all = 0;
    const BlockAlignment alignment(frame, predicted, valid);
    for (const BlockShift& block : alignment.Blocks(1, 2)) {
      if (block.center_px.x() < 20 || block.center_px.x() > kWidth - 20 || block.center_px.y() < 20 ||
          block.center_px.y() > kHeight - 20)
        continue;
      ++all;
      right += (block.shift_px - shift).norm() < 0.1;
      EXPECT_LE(block.mse_shifted, block.mse);
      EXPECT_NEAR(alignment.MeanSquareAfter(block, {0, 0}), block.mse, 1e-6);
    }
    EXPECT_GT(right, 0.9 * all) << shift.transpose();
  }
}

}  // namespace
}  // namespace ulf::prediction_error_test
