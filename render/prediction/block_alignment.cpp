#include "render/prediction/block_alignment.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace ulf::render {
namespace {

constexpr double kLeastValid = 0.75;          // share of a block's pixels. Guessed.
constexpr int kBlockAlignmentIterations = 4;  // on each of the two levels
constexpr double kMostShiftPx = 6;            // larger displacements are not found. Guessed.

using Eigen::Matrix2d;
using Eigen::Vector2d;

// A row of a block.
using RowOfBlock = Eigen::Array<float, kBlockPx, 1>;

RowOfBlock RowAt(const cv::Mat& picture, int x, int y) {
  return Eigen::Map<const RowOfBlock>(picture.ptr<float>(y) + x);
}

// A row of the prediction, displaced by a constant shift with bilinear interpolation.
struct ShiftedRows {
  int whole_x, whole_y;
  float upper_left, upper_right, lower_left, lower_right;  // weights

  explicit ShiftedRows(const Vector2d& shift)
      : whole_x(static_cast<int>(std::floor(shift.x()))), whole_y(static_cast<int>(std::floor(shift.y()))) {
    const auto x = static_cast<float>(shift.x() - whole_x), y = static_cast<float>(shift.y() - whole_y);
    upper_left = (1 - x) * (1 - y);
    upper_right = x * (1 - y);
    lower_left = (1 - x) * y;
    lower_right = x * y;
  }
  // Returns whether the pixels that a block needs are inside a picture.
  bool Reach(const cv::Rect& block, const cv::Size& size) const {
    return block.x + whole_x >= 0 && block.y + whole_y >= 0 && block.br().x + whole_x < size.width &&
           block.br().y + whole_y < size.height;
  }
  RowOfBlock Values(const cv::Mat& picture, int left, int y) const {
    const int x = left + whole_x, top = y + whole_y;
    return upper_left * RowAt(picture, x, top) + upper_right * RowAt(picture, x + 1, top) +
           lower_left * RowAt(picture, x, top + 1) + lower_right * RowAt(picture, x + 1, top + 1);
  }
  // Returns 1 where all four pixels are valid, else 0.
  RowOfBlock Valid(const cv::Mat& valid, int left, int y) const {
    const int x = left + whole_x, top = y + whole_y;
    return RowAt(valid, x, top) * RowAt(valid, x + 1, top) * RowAt(valid, x, top + 1) *
           RowAt(valid, x + 1, top + 1);
  }
};

cv::Mat AsFloat(const cv::Mat& valid) {
  cv::Mat result;
  cv::threshold(valid, result, 0, 1, cv::THRESH_BINARY);
  result.convertTo(result, CV_32F);
  return result;
}

}  // namespace

// Sums over the valid pixels of a block whose prediction is shifted.
struct BlockAlignment::Sums {
  double pixels = 0;
  Matrix2d structure = Matrix2d::Zero();            // of the gradients, about their mean
  Vector2d gradient_difference = Vector2d::Zero();  // gradient times difference, about their means
  double mse = 0;                                   // of the difference, with its mean
  double mse_leveled = 0;                           // after the best factor
  double frame_variance = 0;
};

// The result of an alignment.
struct BlockAlignment::Found {
  Vector2d shift = Vector2d::Zero();
  Sums sums;
  bool ok = false;  // false: it diverged
};

BlockAlignment::Level BlockAlignment::MakeLevel(const cv::Mat& frame, const cv::Mat& predicted,
                                                const cv::Mat& valid) {
  Level level{frame, predicted, valid, {}, {}, {}};
  constexpr double kCentral = 0.5;
  const cv::Mat kernel = (cv::Mat_<float>(1, 3) << -kCentral, 0, kCentral);
  cv::filter2D(frame, level.by_x, CV_32F, kernel, {-1, -1}, 0, cv::BORDER_REPLICATE);
  cv::filter2D(frame, level.by_y, CV_32F, kernel.t(), {-1, -1}, 0, cv::BORDER_REPLICATE);
  cv::Mat predicted_by_x, predicted_by_y;
  cv::filter2D(predicted, predicted_by_x, CV_32F, kernel, {-1, -1}, 0, cv::BORDER_REPLICATE);
  cv::filter2D(predicted, predicted_by_y, CV_32F, kernel.t(), {-1, -1}, 0, cv::BORDER_REPLICATE);
  level.predicted_gradient2 = predicted_by_x.mul(predicted_by_x) + predicted_by_y.mul(predicted_by_y);
  return level;
}

BlockAlignment::Level BlockAlignment::Halved(const Level& fine) {
  cv::Mat frame, predicted, valid;
  cv::pyrDown(fine.frame, frame);
  cv::pyrDown(fine.predicted, predicted);
  cv::resize(fine.valid, valid, frame.size(), 0, 0, cv::INTER_AREA);
  constexpr double kAlmostWhole = 0.99;
  cv::threshold(valid, valid, kAlmostWhole, 1, cv::THRESH_BINARY);
  return MakeLevel(frame, predicted, valid);
}

BlockAlignment::Sums BlockAlignment::SumsOf(const Level& level, const cv::Rect& block,
                                            const Vector2d& shift) {
  Sums sums;
  const ShiftedRows shifted(shift);
  if (!shifted.Reach(block, level.frame.size())) return sums;
  const RowOfBlock none = RowOfBlock::Zero();
  RowOfBlock n = none, gx = none, gy = none, gxx = none, gxy = none, gyy = none, d = none, dd = none,
             gxd = none, gyd = none, f = none, ff = none, pp = none, fp = none;
  for (int y = block.y; y < block.br().y; ++y) {
    const RowOfBlock valid = RowAt(level.valid, block.x, y) * shifted.Valid(level.valid, block.x, y);
    const RowOfBlock frame = RowAt(level.frame, block.x, y) * valid;
    const RowOfBlock value = shifted.Values(level.predicted, block.x, y) * valid;
    const RowOfBlock by_x = RowAt(level.by_x, block.x, y) * valid,
                     by_y = RowAt(level.by_y, block.x, y) * valid;
    const RowOfBlock difference = frame - value;
    n += valid;
    gx += by_x;
    gy += by_y;
    gxx += by_x * by_x;
    gxy += by_x * by_y;
    gyy += by_y * by_y;
    d += difference;
    dd += difference * difference;
    gxd += by_x * difference;
    gyd += by_y * difference;
    f += frame;
    ff += frame * frame;
    pp += value * value;
    fp += frame * value;
  }
  const double pixels = n.sum();
  sums.pixels = pixels;
  if (pixels == 0) return sums;
  const Vector2d gradient(gx.sum(), gy.sum());
  sums.structure << gxx.sum(), gxy.sum(), gxy.sum(), gyy.sum();
  sums.structure -= gradient * gradient.transpose() / pixels;
  sums.gradient_difference = Vector2d(gxd.sum(), gyd.sum()) - gradient * d.sum() / pixels;
  sums.mse = dd.sum() / pixels;
  const double of_prediction = pp.sum(), of_both = fp.sum(), of_frame = ff.sum(), mean = f.sum() / pixels;
  const double factor = of_prediction > 0 ? of_both / of_prediction : 1;
  sums.mse_leveled =
      std::max(0.0, (of_frame - 2 * factor * of_both + factor * factor * of_prediction) / pixels);
  sums.frame_variance = std::max(0.0, of_frame / pixels - mean * mean);
  return sums;
}

BlockAlignment::Found BlockAlignment::Align(const Level& level, const cv::Rect& block, const Vector2d& start,
                                            double least_pixels, double most_px) const {
  Found found{.shift = start, .sums = SumsOf(level, block, start), .ok = true};
  Vector2d shift = start;
  Sums sums = found.sums;
  for (int i = 0; i < kBlockAlignmentIterations; ++i) {
    constexpr double kNoTexture = 1e-3;  // grey values squared, a pixel: keeps the step finite
    const Matrix2d structure = sums.structure + kNoTexture * sums.pixels * Matrix2d::Identity();
    const Vector2d step = structure.inverse() * sums.gradient_difference;
    constexpr double kLongestStep_px = 1.5;
    shift += step.norm() > kLongestStep_px ? Vector2d(step * (kLongestStep_px / step.norm())) : step;
    found.ok = shift.norm() <= most_px;
    if (!found.ok) return found;
    sums = SumsOf(level, block, shift);
    found.ok = sums.pixels >= least_pixels;
    if (!found.ok) return found;
    if (sums.mse < found.sums.mse) found = {shift, sums, true};
    constexpr double kSettled_px = 0.01;
    if (step.norm() < kSettled_px) break;
  }
  return found;
}

// Returns the block as near to that place as the picture allows.
cv::Rect BlockAlignment::BlockAt(const Vector2d& center_px, const cv::Size& size) {
  const auto start = [](double center, int length) {
    return std::clamp(static_cast<int>(std::lround(center - 0.5 * kBlockPx)), 0,
                      std::max(0, length - kBlockPx - 1));
  };
  return {start(center_px.x(), size.width), start(center_px.y(), size.height), kBlockPx, kBlockPx};
}

BlockAlignment::BlockAlignment(const cv::Mat& frame, const cv::Mat& predicted, const cv::Mat& valid,
                               const BlockAlignmentOptions& options)
    : options_(options), fine_(MakeLevel(frame, predicted, AsFloat(valid))), coarse_(Halved(fine_)) {}

void BlockAlignment::SetDetail(const Level& level, const cv::Rect& rect, BlockShift& block) {
  RowOfBlock n = RowOfBlock::Zero(), of_frame = n, of_prediction = n;
  for (int y = rect.y; y < rect.br().y; ++y) {
    const RowOfBlock valid = RowAt(level.valid, rect.x, y);
    n += valid;
    of_frame += valid * (RowAt(level.by_x, rect.x, y).square() + RowAt(level.by_y, rect.x, y).square());
    of_prediction += valid * RowAt(level.predicted_gradient2, rect.x, y);
  }
  block.detail = of_frame.sum() / n.sum();
  block.predicted_detail = of_prediction.sum() / n.sum();
}

// Noise adds to the structure without being texture.
Matrix2d BlockAlignment::CovarianceOf(const Sums& sums, double frame_noise_variance, double noise_variance) {
  constexpr double kSurely = 1.7;  // a block's sum may exceed it by chance
  const double by_noise = kSurely * kGradientNoiseShare * frame_noise_variance * sums.pixels;
  const Eigen::SelfAdjointEigenSolver<Matrix2d> axes(sums.structure);
  constexpr double kNoStructure = 1e-9;
  const Vector2d texture = (axes.eigenvalues().array() - by_noise).max(kNoStructure);
  return std::max(noise_variance, sums.mse_leveled) * axes.eigenvectors() *
         texture.cwiseInverse().asDiagonal() * axes.eigenvectors().transpose();
}

std::vector<BlockShift> BlockAlignment::Blocks(double frame_noise_variance, double noise_variance) const {
  constexpr int side = kBlockPx;
  constexpr double least_pixels = kLeastValid * (side * side);
  std::vector<BlockShift> shifts;
  for (int top = 0; top + side < fine_.frame.rows; top += side)
    for (int left = 0; left + side < fine_.frame.cols; left += side) {
      if (options_.every_other && (left + top) / side % 2 != 0) continue;
      const cv::Rect rect(left, top, side, side);
      const Sums as_predicted = SumsOf(fine_, rect, Vector2d::Zero());
      if (as_predicted.pixels < least_pixels) continue;
      BlockShift block;
      block.column = left / side;
      block.row = top / side;
      block.center_px = {left + 0.5 * side, top + 0.5 * side};
      block.mse = as_predicted.mse;
      block.contrast = as_predicted.frame_variance;
      SetDetail(fine_, rect, block);
      Found found = Align(fine_, rect, Vector2d::Zero(), least_pixels, kMostShiftPx);
      // The same number of pixels of the halved pictures covers four times the area, with twice the range.
      const cv::Rect wide = BlockAt(0.5 * block.center_px, coarse_.frame.size());
      const Found rough = Align(coarse_, wide, Vector2d::Zero(), 0.5 * least_pixels, 0.5 * kMostShiftPx);
      constexpr double kWorthAnotherStart_px = 0.25;
      if (rough.ok && rough.shift.norm() > kWorthAnotherStart_px) {
        const Found from_rough = Align(fine_, rect, 2 * rough.shift, least_pixels, kMostShiftPx);
        if (from_rough.sums.pixels >= least_pixels && from_rough.sums.mse < found.sums.mse)
          found = from_rough;
      }
      block.shift_px = found.shift;
      block.converged = found.ok;
      block.mse_shifted = found.sums.mse;
      block.mse_leveled = std::min(found.sums.mse, found.sums.mse_leveled);
      block.covariance = CovarianceOf(found.sums, frame_noise_variance, noise_variance);
      shifts.push_back(block);
    }
  return shifts;
}

double BlockAlignment::MeanSquareAfter(const BlockShift& block, const Vector2d& shift_px) const {
  const Sums sums = SumsOf(fine_, BlockAt(block.center_px, fine_.frame.size()), shift_px);
  return sums.pixels > 0 ? sums.mse : block.mse;
}

}  // namespace ulf::render
