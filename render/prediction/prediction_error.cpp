#include "render/prediction/prediction_error.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "core/base/at.h"
#include "core/base/quantile.h"
#include "core/geometry/small_matrices.h"

namespace ulf::render {
namespace {

constexpr int kViewsAligned =
    2;  // nearest ones, each aligned by itself. Guessed: each costs as much as all the rest.
// A block is measured if its shift's standard deviation is smaller in every direction. Guessed.
constexpr double kMostShiftSigmaPx = 0.35;
constexpr double kPredictionErrorLeastDetail =
    0.3;  // mean square gradient: with less, detail is not compared. Guessed.
// Limit of displayed dB: rounding to 8 bits causes as much error. Guessed.
constexpr double kPredictionErrorMostDb = 50;

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Matrix26d = Eigen::Matrix<double, 2, 6>;

constexpr double kPeak = 255;

// Returns whether the ray through an image point meets the subject's sphere.
bool ShowsSubject(const StereoView& frame, const Subject& subject, const Vector2d& img) {
  const Vector3d ray = Vector3d((img.x() - frame.camera.cx) / frame.camera.fx,
                                (img.y() - frame.camera.cy) / frame.camera.fy, 1);
  const Vector3d center = frame.cam_from_world * subject.center_in_world;
  return ray.dot(center) > 0 && ray.cross(center).norm() < subject.radius * ray.norm();
}

// Returns the motion of an image point of inverse depth `near` with the camera's rotation (radians) and
// translation (world units).
Matrix26d FlowOfMotion(const CameraModel& camera, const Vector2d& img, double near) {
  const double x = (img.x() - camera.cx) / camera.fx, y = (img.y() - camera.cy) / camera.fy;
  Matrix26d flow;
  flow << x * y, -(1 + x * x), y, -near, 0, x * near,  //
      1 + y * y, -x * y, -x, 0, -near, y * near;
  flow.row(0) *= camera.fx;
  flow.row(1) *= camera.fy;
  return flow;
}

struct Motion {
  Vector6d value = Vector6d::Zero();  // turn, then translation
  double off_sigmas = 0;
};

// The shift of one block, by one view.
struct ShiftOfView {
  Vector2d shift;
  double variance, weight, mse_shifted;
};

struct MeasuredShift {
  Vector2d shift;
  Matrix2d covariance;
  Matrix26d flow;
};

// Estimates the most probable small motion of the camera from the displacements: within the pose's
// uncertainty, and robust to blocks that are displaced for another reason (Cauchy weights).
Motion MotionBehind(const std::vector<MeasuredShift>& shifts, const Vector6d& sigmas) {
  Motion motion;
  if (shifts.empty()) return motion;
  const Matrix6d prior = sigmas.cwiseInverse().cwiseAbs2().asDiagonal();
  constexpr int kIterations = 6;
  constexpr double kOtherReason_px = 0.3;  // beyond it a block counts less. Guessed.
  for (int i = 0; i < kIterations; ++i) {
    Matrix6d normal = prior;
    Vector6d right = Vector6d::Zero();
    for (const MeasuredShift& at : shifts) {
      const Vector2d rest = at.shift - at.flow * motion.value;
      const Matrix2d information =
          (at.covariance + kOtherReason_px * kOtherReason_px * Matrix2d::Identity()).inverse();
      const double weight = 1 / (1 + rest.dot(information * rest));
      normal += weight * at.flow.transpose() * information * at.flow;
      right += weight * at.flow.transpose() * (information * at.shift);
    }
    motion.value = SolveNormal(normal, right);
  }
  motion.off_sigmas = motion.value.cwiseQuotient(sigmas).norm() / std::sqrt(6.0);
  return motion;
}

struct Sums {
  double detail = 0, predicted_detail = 0;
  double off2 = 0, mse = 0, aligned = 0, contrast = 0;
};

double Db(double mse) {
  const double least = kPeak * kPeak * std::pow(10, -kPredictionErrorMostDb / 10);
  return 10 * std::log10(kPeak * kPeak / std::max(mse, least));
}

void Finish(const Sums& sums, RegionError& region) {
  if (region.measured > 0) region.misregistration_px = std::sqrt(std::max(0.0, sums.off2 / region.measured));
  if (region.seen == 0) return;
  region.db = Db(sums.mse / region.seen);
  region.db_aligned = Db(sums.aligned / region.seen);
  region.contrast = std::sqrt(sums.contrast / region.seen);
}

}  // namespace

double NoiseSigma(const cv::Mat& grey) {
  // Immerkaer's mask (1996) removes constant, linear and most quadratic brightness.
  const cv::Mat mask = (cv::Mat_<float>(3, 3) << 1, -2, 1, -2, 4, -2, 1, -2, 1);
  cv::Mat response;
  cv::filter2D(grey, response, CV_32F, mask);
  constexpr int kPart = 16;
  const cv::Size parts(std::max(1, grey.cols / kPart), std::max(1, grey.rows / kPart));
  cv::Mat mean;
  cv::resize(cv::abs(response), mean, parts, 0, 0, cv::INTER_AREA);
  // At the limits of brightness noise is cut off.
  constexpr double kDark = 10, kBright = 245;
  cv::Mat brightness;
  cv::resize(grey, brightness, parts, 0, 0, cv::INTER_AREA);
  std::vector<double> values;
  for (int y = 0; y < parts.height; ++y)
    for (int x = 0; x < parts.width; ++x)
      if (brightness.at<float>(y, x) > kDark && brightness.at<float>(y, x) < kBright)
        values.push_back(mean.at<float>(y, x));
  constexpr double kLeastDetail = 0.1;  // share of the parts. Guessed.
  constexpr double kOfMean = 0.87;      // ratio of that quantile to the mean for noise alone: simulated
  return Quantile(std::move(values), kLeastDetail) * std::sqrt(M_PI / 2) / (6 * kOfMean);
}

PredictionError MeasureError(const StereoView& frame, const PredictedFrame& predicted, const Subject& subject,
                             const PoseUncertainty& pose, const PredictionErrorOptions& options) {
  PredictionError error;
  const double frame_noise = NoiseSigma(frame.grey);
  const double view_noise_variance = frame_noise * frame_noise * kSmoothedNoiseShare;
  // The views' noise passes through an interpolation as well, which smoothed pictures hardly feel.
  const double noise_variance = view_noise_variance * (1 + predicted.noise_share);
  error.noise_sigma = std::sqrt(noise_variance);
  error.nearest_view_angle = predicted.nearest_view_angle;
  const auto [least_gain, most_gain] =
      std::ranges::minmax_element(predicted.views, {}, &PredictedByView::gain);
  if (least_gain != predicted.views.end()) error.gain_spread = most_gain->gain / least_gain->gain;

  const cv::Mat smoothed = Smoothed(frame.grey);
  const BlockAlignment alignment(smoothed, predicted.grey, predicted.valid, options.blocks);
  const std::vector<BlockShift> blocks = alignment.Blocks(view_noise_variance, noise_variance);
  // A blend of views with opposite errors is blurred and not displaced: each is aligned by itself.
  BlockAlignmentOptions every_other = options.blocks;
  every_other.every_other = true;
  std::vector<std::vector<BlockShift>> by_view;
  for (const PredictedByView& view : predicted.views)
    if (by_view.size() < At(kViewsAligned))
      by_view.push_back(BlockAlignment(smoothed, view.grey, view.seen, every_other)
                            .Blocks(view_noise_variance, 2 * view_noise_variance));

  const double distance = (frame.cam_from_world * subject.center_in_world).norm();
  const double pixel = distance / frame.camera.MeanFocalPx();  // at the subject, world units
  const double center_sigma = std::max(pose.center_sigma.value_or(0.5 * pixel), pose.least_px * pixel);
  Vector6d sigmas;
  sigmas << Vector3d::Constant(center_sigma / distance), Vector3d::Constant(center_sigma);
  const auto inverse_depth_at = [&](const Vector2d& img) {
    return static_cast<double>(predicted.inverse_depth.at<float>(
        std::min(static_cast<int>(img.y()), predicted.inverse_depth.rows - 1),
        std::min(static_cast<int>(img.x()), predicted.inverse_depth.cols - 1)));
  };
  std::map<std::pair<int, int>, std::vector<ShiftOfView>> shifts_of_block;
  std::vector<MeasuredShift> shifts;
  for (std::size_t i = 0; i < by_view.size(); ++i)
    for (const BlockShift& block : by_view[i]) {
      const Eigen::SelfAdjointEigenSolver<Matrix2d> axes(block.covariance, Eigen::EigenvaluesOnly);
      if (!block.converged || axes.eigenvalues().y() > kMostShiftSigmaPx * kMostShiftSigmaPx) continue;
      shifts_of_block[{block.column, block.row}].push_back(
          {block.shift_px, block.covariance.trace(), predicted.views[i].weight, block.mse_shifted});
      shifts.push_back({block.shift_px, block.covariance,
                        FlowOfMotion(frame.camera, block.center_px, inverse_depth_at(block.center_px))});
    }
  // Six unknowns need no more than a few hundred displacements.
  constexpr std::size_t kEnough = 200;
  if (shifts.size() > kEnough) {
    for (std::size_t i = 0; i < kEnough; ++i) shifts[i] = shifts[i * shifts.size() / kEnough];
    shifts.resize(kEnough);
  }
  const Motion motion = MotionBehind(shifts, sigmas);
  error.pose_off_sigmas = motion.off_sigmas;
  error.pose_px =
      (FlowOfMotion(frame.camera, {frame.camera.cx, frame.camera.cy}, 1 / distance) * motion.value).norm();

  Sums inside, outside;
  for (const BlockShift& block : blocks) {
    BlockError at;
    at.center_px = block.center_px;
    const Vector2d by_pose =
        FlowOfMotion(frame.camera, block.center_px, inverse_depth_at(block.center_px)) * motion.value;
    double weight = 0, off2 = 0;
    for (const ShiftOfView& view : shifts_of_block[{block.column, block.row}]) {
      const Vector2d off = view.shift - by_pose;
      weight += view.weight;
      off2 += view.weight * (off.squaredNorm() - view.variance);
      at.mse_by_view += view.weight * std::max(0.0, view.mse_shifted - 2 * view_noise_variance);
    }
    at.measured = weight > 0;
    if (at.measured) {
      at.off_px = std::sqrt(std::max(0.0, off2 / weight));
      at.mse_by_view /= weight;
    }
    at.inside = ShowsSubject(frame, subject, block.center_px);
    const cv::Point middle(static_cast<int>(block.center_px.x()), static_cast<int>(block.center_px.y()));
    at.on_mesh = predicted.on_mesh.at<std::uint8_t>(middle) != 0;
    const auto without_noise = [&](double mse) { return std::max(0.0, mse - noise_variance); };
    at.mse = without_noise(std::min(block.mse, alignment.MeanSquareAfter(block, by_pose)));
    at.mse_aligned = std::min(at.mse, without_noise(block.mse_shifted));
    at.mse_leveled = std::min(at.mse_aligned, without_noise(block.mse_leveled));
    constexpr int half = kBlockPx / 2;
    const cv::Rect rect =
        cv::Rect(middle.x - half, middle.y - half, 2 * half, 2 * half) & cv::Rect({0, 0}, frame.grey.size());
    at.variance_of_views =
        std::max(0.0, cv::mean(predicted.variance_of_views(rect))[0] - view_noise_variance);
    RegionError& region = at.inside ? error.inside : error.outside;
    Sums& sums = at.inside ? inside : outside;
    ++region.seen;
    region.alignable += (block.column + block.row) % 2 == 0;
    sums.mse += at.mse;
    sums.aligned += at.mse_aligned;
    sums.contrast += block.contrast;
    sums.detail += block.detail;
    sums.predicted_detail += block.predicted_detail;
    if (at.measured) {
      ++region.measured;
      sums.off2 += at.off_px * at.off_px;
    }
    error.blocks.push_back(at);
  }
  constexpr int side = kBlockPx;
  int on_mesh = 0;
  for (int top = 0; top + side <= frame.grey.rows; top += side)
    for (int left = 0; left + side <= frame.grey.cols; left += side) {
      const Vector2d center(left + 0.5 * side, top + 0.5 * side);
      if (!ShowsSubject(frame, subject, center)) {
        ++error.outside.blocks;
        continue;
      }
      ++error.inside.blocks;
      on_mesh +=
          predicted.on_mesh.at<std::uint8_t>(static_cast<int>(center.y()), static_cast<int>(center.x())) != 0;
    }
  if (error.inside.blocks > 0) error.on_mesh_share = static_cast<double>(on_mesh) / error.inside.blocks;
  // Noise of a smoothed picture's gradients; interpolation hardly lowers it.
  const double noise_detail = 2 * kGradientNoiseShare * view_noise_variance * error.inside.seen;
  const double predicted_detail = inside.predicted_detail - predicted.noise_share * noise_detail;
  if (error.inside.seen > 0 && predicted_detail > kPredictionErrorLeastDetail * error.inside.seen)
    error.detail_ratio = std::max(0.0, inside.detail - noise_detail) / predicted_detail;
  Finish(inside, error.inside);
  Finish(outside, error.outside);
  return error;
}

}  // namespace ulf::render
