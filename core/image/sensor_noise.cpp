#include "core/image/sensor_noise.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/base/quantile.h"
#include "core/geometry/small_matrices.h"
#include "core/image/clipped.h"

namespace ulf {
namespace {

constexpr int kNoiseBlock = 16;            // pixels across
constexpr std::size_t kBrightnesses = 24;  // groups of blocks
// Blocks of one brightness that are used; the others have texture besides noise.
constexpr double kSmoothest = 0.2;
// Ratio of the variance in the smoothest blocks to that of noise: estimates from 64 numbers differ by a
// seventh.
constexpr double kOfSmoothest = 0.75;
// Share of a block's numbers that may be 0, which hardly changes the median.
constexpr double kMostAtBlack = 0.05;
constexpr std::size_t kPhases = 4;  // of a mosaic
constexpr double kLeastVariance = 1e-12;

// Returns the variance of rounding to integers: constant in linear numbers; for display-encoded ones nearly
// in proportion to the light, because a step of light is 2.4 light^0.58 steps of the number.
SensorNoise RoundingOf(const Image& image) {
  if (image.pixels.depth() != CV_8U && image.pixels.depth() != CV_16U) return {0, kLeastVariance};
  const double step = 1 / FullScale(image.pixels.depth()), variance = step * step / 12;
  if (image.transfer == Transfer::kLinear) return {0, variance};
  constexpr double kSlopeAtBlack = 1 / 12.92;
  return {2.4 * 2.4 * variance, kSlopeAtBlack * kSlopeAtBlack * variance};
}

// Returns CV_8UC1, 255 where any number is 0; empty for floats, which go on below black.
cv::Mat AtBlack(const Image& image) {
  if (image.pixels.depth() == CV_32F) return {};
  return AnyColor(image.pixels == cv::Scalar::all(0));
}

// Uses one colour in every other pixel of every other row.
double VarianceIn(const cv::Mat& differences, int color, std::size_t phase) {
  std::vector<double> sizes;
  for (int y = static_cast<int>(phase / 2); y < differences.rows; y += 2)
    for (int x = static_cast<int>(phase % 2); x < differences.cols; x += 2)
      sizes.push_back(std::abs(differences.at<cv::Vec3f>(y, x)[color]));
  const double sigma = Median(sizes) / (0.6745 * 6);
  return sigma * sigma;
}

std::vector<NoiseOfLight> SmoothestOfEachBrightness(std::vector<NoiseOfLight> blocks) {
  std::ranges::sort(blocks, {}, &NoiseOfLight::light);
  std::vector<NoiseOfLight> smoothest;
  for (std::size_t group = 0; group < kBrightnesses; ++group) {
    const std::size_t from = group * blocks.size() / kBrightnesses,
                      end = (group + 1) * blocks.size() / kBrightnesses;
    if (from == end) continue;
    std::vector<double> variances, lights;
    for (std::size_t i = from; i < end; ++i) {
      variances.push_back(blocks[i].variance);
      lights.push_back(blocks[i].light);
    }
    smoothest.push_back({Median(lights), Quantile(variances, kSmoothest) / kOfSmoothest});
  }
  return smoothest;
}

// Solves the normal equations with no unknown negative: takes the best of all choices of positive unknowns.
Eigen::Vector3d NotNegative(const Eigen::Matrix3d& products, const Eigen::Vector3d& right) {
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  double least = 0;  // squares, relative to those without unknowns
  for (unsigned chosen = 1; chosen < 8; ++chosen) {
    Eigen::Matrix3d those = products;
    Eigen::Vector3d of_those = right;
    for (int i = 0; i < 3; ++i)
      if ((chosen >> i & 1u) == 0) {
        those.row(i).setZero();
        those.col(i).setZero();
        those(i, i) = 1;
        of_those[i] = 0;
      }
    const Eigen::Vector3d unknowns = SolveNormal(those, of_those);
    const double squares = unknowns.dot(products * unknowns) - 2 * unknowns.dot(right);
    if (unknowns.minCoeff() < 0 || !(squares < least)) continue;
    least = squares;
    best = unknowns;
  }
  return best;
}

// Fits read noise, shot noise in proportion to the light, and texture and uneven pixels in proportion to its
// square (EMVA 1288's photon transfer), by errors relative to the curve, which determines their weights: the
// measured variances as weights would bias it towards those that are too low.
SensorNoise PhotonTransferThrough(const std::vector<NoiseOfLight>& points) {
  constexpr int kRounds = 8;
  double mean = 0;
  for (const NoiseOfLight& point : points) mean += point.variance / static_cast<double>(points.size());
  Eigen::Vector3d parts(mean, 0, 0);
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const auto& [light, variance] : points) {
      const Eigen::Vector3d row(1, light, light * light);
      const double weight = std::pow(std::max(kLeastVariance, row.dot(parts)), -2);
      products += weight * row * row.transpose();
      right += weight * variance * row;
    }
    parts = NotNegative(products, right);
  }
  return {parts[1], parts[0]};
}

SensorNoise NotBelow(const SensorNoise& least, const SensorNoise& noise) {
  return {std::max(noise.per_light, least.per_light), std::max(noise.floor, least.floor)};
}

}  // namespace

void NoiseSamples::Add(const Image& image, const cv::Mat& light, const cv::Mat& clipped) {
  rounding_ = NotBelow(rounding_, RoundingOf(image));
  const cv::Mat at_black = AtBlack(image);
  // Compares pixels two apart, which are of one kind in a mosaic.
  const cv::Mat along = (cv::Mat_<float>(1, 5) << 1, 0, -2, 0, 1);
  cv::Mat differences;
  cv::sepFilter2D(light, differences, CV_32F, along, along);
  std::array<std::array<std::vector<NoiseOfLight>, kPhases>, 3> of_blocks;  // by colour
  for (int y = 0; y + kNoiseBlock <= light.rows; y += kNoiseBlock)
    for (int x = 0; x + kNoiseBlock <= light.cols; x += kNoiseBlock) {
      const cv::Rect block(x, y, kNoiseBlock, kNoiseBlock);
      if (cv::countNonZero(clipped(block)) > 0) continue;
      const cv::Scalar mean = cv::mean(light(block));
      const bool is_cut =
          !at_black.empty() && cv::countNonZero(at_black(block)) > kMostAtBlack * block.area();
      for (int c = 0; c < 3; ++c) {
        if (is_cut) dark_light_.push_back(mean[c]);
        for (std::size_t phase = 0; phase < kPhases && !is_cut; ++phase)
          of_blocks[static_cast<std::size_t>(c)][phase].push_back(
              {std::max(0.0, mean[c]), VarianceIn(differences(block), c, phase)});
      }
    }
  // A demosaicing has computed the others from those of one phase, and made them less noisy.
  for (const auto& of_phases : of_blocks) {
    const auto noisiest =
        std::ranges::max_element(of_phases, {}, [](const std::vector<NoiseOfLight>& blocks) {
          double sum = 0;
          for (const NoiseOfLight& each : blocks) sum += std::sqrt(each.variance);
          return sum;
        });
    blocks_.insert(blocks_.end(), noisiest->begin(), noisiest->end());
  }
}

SensorNoise NoiseSamples::Fit() const {
  if (blocks_.empty()) {
    // The upper half of zero-mean noise has a mean of 0.4 sigma.
    const double sigma = dark_light_.empty() ? 0 : std::max(0.0, Quantile(dark_light_, kSmoothest)) / 0.3989;
    return {rounding_.per_light, std::max(rounding_.floor, sigma * sigma)};
  }
  return NotBelow(rounding_, PhotonTransferThrough(SmoothestOfEachBrightness(blocks_)));
}

}  // namespace ulf
