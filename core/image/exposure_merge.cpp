#include "core/image/exposure_merge.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/base/error.h"
#include "core/base/quantile.h"
#include "core/image/clipped.h"

namespace ulf {
namespace {

constexpr int kBlock = 16;                 // pixels across, on which noise is measured
constexpr std::size_t kBrightnesses = 12;  // groups of blocks
// Of the blocks of one brightness, which have texture besides noise.
constexpr double kSmoothest = 0.2;
constexpr double kMisalignedPx = 0.5, kWrongTimes = 0.02, kGhostSigmas = 4;  // guessed
constexpr double kMostNoisier =
    4;  // than measured, in variance: resampling and demosaicing tie neighbours. Guessed.
constexpr std::size_t kFewPixels = 500;  // for a ratio

struct BlockNoise {
  double light = 0, variance = 0;
};

// The median of a second difference in both directions, which light that rises evenly does not change (Immerkaer 1996,
// "Fast noise variance estimation").
std::vector<BlockNoise> NoiseOfBlocks(const cv::Mat& light, const cv::Mat& clipped) {
  const cv::Mat kernel = (cv::Mat_<float>(3, 3) << 1, -2, 1, -2, 4, -2, 1, -2, 1);
  cv::Mat differences;
  cv::filter2D(light, differences, CV_32F, kernel);
  std::vector<BlockNoise> blocks;
  std::vector<double> sizes;
  for (int y = 0; y + kBlock <= light.rows; y += kBlock)
    for (int x = 0; x + kBlock <= light.cols; x += kBlock) {
      const cv::Rect block(x, y, kBlock, kBlock);
      if (cv::countNonZero(clipped(block)) > 0) continue;
      const cv::Scalar mean = cv::mean(light(block));
      for (int c = 0; c < 3; ++c) {
        sizes.clear();
        for (int v = 0; v < kBlock; ++v)
          for (int u = 0; u < kBlock; ++u)
            sizes.push_back(std::abs(differences.at<cv::Vec3f>(y + v, x + u)[c]));
        const double sigma = Median(sizes) / (0.6745 * 6);
        blocks.push_back({std::max(0.0, mean[c]), sigma * sigma});
      }
    }
  return blocks;
}

// A line through the smoothest blocks of each brightness, by least squares of relative errors; no part is negative.
SensorNoise LineThrough(std::vector<BlockNoise> blocks, double least) {
  std::ranges::sort(blocks, {}, &BlockNoise::light);
  double ll = 0, l1 = 0, one = 0, l = 0, n = 0;
  for (std::size_t group = 0; group < kBrightnesses; ++group) {
    const std::size_t from = group * blocks.size() / kBrightnesses,
                      end = (group + 1) * blocks.size() / kBrightnesses;
    if (from == end) continue;
    std::vector<double> variances, lights;
    for (std::size_t i = from; i < end; ++i) {
      variances.push_back(blocks[i].variance);
      lights.push_back(blocks[i].light);
    }
    const double variance = std::max(least, Quantile(variances, kSmoothest)), light = Median(lights);
    const double weight = 1 / (variance * variance);
    ll += weight * light * light;
    l1 += weight * light;
    one += weight;
    l += weight * light * variance;
    n += weight * variance;
  }
  if (one == 0) return {0, least};
  const double determinant = ll * one - l1 * l1;
  SensorNoise noise{0, n / one};
  if (determinant > 1e-9 * ll * one)
    noise = {(l * one - l1 * n) / determinant, (ll * n - l1 * l) / determinant};
  if (noise.per_light < 0) noise = {0, n / one};
  if (noise.floor < least) noise = {std::max(0.0, ll > 0 ? (l - least * l1) / ll : 0), least};
  return noise;
}

// Of rounding to whole numbers: constant in linear numbers; of display-encoded ones nearly in proportion to the light,
// because a step of light is 2.4 light^0.58 steps of the number.
SensorNoise RoundingOf(const Image& image) {
  if (image.pixels.depth() != CV_8U && image.pixels.depth() != CV_16U) return {};
  const double step = 1 / FullScale(image.pixels.depth()), variance = step * step / 12;
  if (image.transfer == Transfer::kLinear) return {0, variance};
  constexpr double kSlopeAtBlack = 1 / 12.92;
  return {2.4 * 2.4 * variance, kSlopeAtBlack * kSlopeAtBlack * variance};
}

cv::Vec3f At(const AlignedExposure& exposure, int y, int x) {
  return exposure.light.at<cv::Vec3f>(y, x) * static_cast<float>(1 / exposure.ratio);
}

// Of the light over its ratio.
double VarianceAt(const AlignedExposure& exposure, double light) {
  return exposure.noise.VarianceAt(light * exposure.ratio) / (exposure.ratio * exposure.ratio);
}

bool Tells(const AlignedExposure& exposure, int y, int x) {
  return exposure.seen.at<std::uint8_t>(y, x) != 0 && exposure.clipped.at<std::uint8_t>(y, x) == 0;
}

// Which exposure counts alone where they disagree: the reference, else the one nearest to it that tells the light, first
// of shorter ones. Where all are clipped that see the pixel it is the shortest of them.
cv::Mat AloneAt(std::span<const AlignedExposure> exposures, cv::Mat& clipped) {
  std::vector<int> order(exposures.size());
  std::iota(order.begin(), order.end(), 0);
  const auto stops = [&](int i) { return std::log2(exposures[static_cast<std::size_t>(i)].ratio); };
  std::ranges::stable_sort(order, [&](int a, int b) {
    const double off_a = std::abs(stops(a)), off_b = std::abs(stops(b));
    return off_a != off_b ? off_a < off_b : stops(a) < stops(b);
  });
  const cv::Mat& like = exposures[0].light;
  cv::Mat alone(like.size(), CV_8UC1);
  clipped = cv::Mat::zeros(like.size(), CV_8UC1);
  for (int y = 0; y < like.rows; ++y)
    for (int x = 0; x < like.cols; ++x) {
      int chosen = -1, shortest = 0;
      for (const int i : order) {
        const AlignedExposure& exposure = exposures[static_cast<std::size_t>(i)];
        if (exposure.seen.at<std::uint8_t>(y, x) == 0) continue;
        if (stops(i) < stops(shortest)) shortest = i;
        if (chosen < 0 && Tells(exposure, y, x)) chosen = i;
      }
      if (chosen < 0) clipped.at<std::uint8_t>(y, x) = 255;
      alone.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(chosen < 0 ? shortest : chosen);
    }
  return alone;
}

cv::Mat LightAlone(std::span<const AlignedExposure> exposures, const cv::Mat& alone) {
  cv::Mat light(alone.size(), CV_32FC3);
  for (int y = 0; y < light.rows; ++y)
    for (int x = 0; x < light.cols; ++x)
      light.at<cv::Vec3f>(y, x) = At(exposures[alone.at<std::uint8_t>(y, x)], y, x);
  return light;
}

// Half a pixel's worth of change of the light around each pixel.
cv::Mat MisalignmentOf(const cv::Mat& light) {
  cv::Mat by_x, by_y, sizes;
  cv::Sobel(light, by_x, CV_32F, 1, 0, 3, 1.0 / 8);
  cv::Sobel(light, by_y, CV_32F, 0, 1, 3, 1.0 / 8);
  cv::sqrt(by_x.mul(by_x) + by_y.mul(by_y), sizes);
  return sizes * kMisalignedPx;
}

// How far an exposure is from the one that counts alone, each a mean over three by three pixels, squared, in units of its
// variance: the largest of the three colours. Negative where they cannot be compared.
cv::Mat Disagreement(std::span<const AlignedExposure> exposures, std::size_t index, const cv::Mat& alone,
                     const cv::Mat& light, const cv::Mat& misaligned) {
  const AlignedExposure& exposure = exposures[index];
  cv::Mat difference = cv::Mat::zeros(light.size(), CV_32FC3), variance = difference.clone();
  cv::Mat compared = cv::Mat::zeros(light.size(), CV_32FC1);
  for (int y = 0; y < light.rows; ++y)
    for (int x = 0; x < light.cols; ++x) {
      const std::size_t other = alone.at<std::uint8_t>(y, x);
      if (other == index || !Tells(exposure, y, x) || !Tells(exposures[other], y, x)) continue;
      compared.at<float>(y, x) = 1;
      const cv::Vec3f here = light.at<cv::Vec3f>(y, x);
      difference.at<cv::Vec3f>(y, x) = At(exposure, y, x) - here;
      for (int c = 0; c < 3; ++c)
        variance.at<cv::Vec3f>(y, x)[c] =
            static_cast<float>(VarianceAt(exposure, here[c]) + VarianceAt(exposures[other], here[c]));
    }
  constexpr int kAcross = 3;
  cv::Mat count;
  cv::boxFilter(compared, count, -1, {kAcross, kAcross}, {-1, -1}, false);
  cv::boxFilter(difference, difference, -1, {kAcross, kAcross}, {-1, -1}, false);
  cv::boxFilter(variance, variance, -1, {kAcross, kAcross}, {-1, -1}, false);
  cv::Mat squares(light.size(), CV_32FC1, cv::Scalar(-1));
  std::vector<double> of_noise;
  for (int y = 0; y < light.rows; ++y)
    for (int x = 0; x < light.cols; ++x) {
      if (compared.at<float>(y, x) == 0) continue;
      const double n = count.at<float>(y, x);
      const cv::Vec3f d = difference.at<cv::Vec3f>(y, x), v = variance.at<cv::Vec3f>(y, x);
      const cv::Vec3f shift = misaligned.at<cv::Vec3f>(y, x), here = light.at<cv::Vec3f>(y, x);
      for (int c = 0; c < 3; ++c) {
        const double allowed = shift[c] + kWrongTimes * std::abs(here[c]);
        if (allowed * allowed < v[c] / (n * n)) of_noise.push_back(d[c] * d[c] / v[c]);
      }
    }
  constexpr double kMedianOfChiSquare = 0.4549;
  const double noisier =
      of_noise.size() < kFewPixels ? 1 : std::clamp(Median(of_noise) / kMedianOfChiSquare, 1.0, kMostNoisier);
  for (int y = 0; y < light.rows; ++y)
    for (int x = 0; x < light.cols; ++x) {
      if (compared.at<float>(y, x) == 0) continue;
      const double n = count.at<float>(y, x);
      const cv::Vec3f d = difference.at<cv::Vec3f>(y, x), v = variance.at<cv::Vec3f>(y, x);
      const cv::Vec3f shift = misaligned.at<cv::Vec3f>(y, x), here = light.at<cv::Vec3f>(y, x);
      double largest = 0;
      for (int c = 0; c < 3; ++c) {
        const double off = d[c] / n, times = kWrongTimes * here[c];
        largest =
            std::max(largest, off * off / (noisier * v[c] / (n * n) + shift[c] * shift[c] + times * times));
      }
      squares.at<float>(y, x) = static_cast<float>(largest);
    }
  return squares;
}

// A clipped pixel says that there is at least as much light as filled it.
void MarkBelowClipped(const AlignedExposure& exposure, const cv::Mat& light, const cv::Mat& misaligned,
                      cv::Mat& ghosts) {
  for (int y = 0; y < light.rows; ++y)
    for (int x = 0; x < light.cols; ++x) {
      if (exposure.seen.at<std::uint8_t>(y, x) == 0 || exposure.clipped.at<std::uint8_t>(y, x) == 0) continue;
      const cv::Vec3f here = light.at<cv::Vec3f>(y, x), there = At(exposure, y, x),
                      shift = misaligned.at<cv::Vec3f>(y, x);
      for (int c = 0; c < 3; ++c) {
        const double sigma = std::sqrt(VarianceAt(exposure, there[c])) + shift[c] + kWrongTimes * there[c];
        if (here[c] < there[c] - kGhostSigmas * sigma) ghosts.at<std::uint8_t>(y, x) = 255;
      }
    }
}

cv::Mat GhostsAmong(std::span<const AlignedExposure> exposures, const cv::Mat& alone, const cv::Mat& light,
                    const cv::Mat& clipped) {
  cv::Mat ghosts = cv::Mat::zeros(light.size(), CV_8UC1);
  const cv::Mat misaligned = MisalignmentOf(light);
  for (std::size_t i = 0; i < exposures.size(); ++i) {
    ghosts |= Disagreement(exposures, i, alone, light, misaligned) > kGhostSigmas * kGhostSigmas;
    MarkBelowClipped(exposures[i], light, misaligned, ghosts);
  }
  ghosts.setTo(0, clipped);
  // A single pixel is noise; what moved has a border that is mixed.
  const cv::Mat around = cv::Mat::ones(3, 3, CV_8UC1);
  cv::morphologyEx(ghosts, ghosts, cv::MORPH_OPEN, around);
  cv::dilate(ghosts, ghosts, around);
  ghosts.setTo(0, clipped);
  return ghosts;
}

}  // namespace

ExposedLight ExposedLightOf(const Image& image, double black_level) {
  if (!(black_level >= 0 && black_level < 1))
    throw Error("a black level of {} is no share of full scale; correct it in the journal", black_level);
  ExposedLight exposed;
  exposed.light = LinearFloat(image);
  if (black_level > 0) exposed.light -= cv::Scalar::all(black_level);
  exposed.clipped = ClippedPixels(image);
  if (exposed.clipped.empty()) exposed.clipped = cv::Mat::zeros(exposed.light.size(), CV_8UC1);
  const SensorNoise rounding = RoundingOf(image);
  exposed.noise = LineThrough(NoiseOfBlocks(exposed.light, exposed.clipped), 1e-12);
  exposed.noise.per_light = std::max(exposed.noise.per_light, rounding.per_light);
  exposed.noise.floor += rounding.floor;
  if (image.pixels.depth() == CV_32F) return exposed;
  // Where noise reaches full scale it is cut off on one side, and what is left is too dark.
  const double full = 1 - black_level, from = full - kGhostSigmas * std::sqrt(exposed.noise.VarianceAt(full));
  cv::Mat brightest;
  cv::reduce(exposed.light.reshape(1, static_cast<int>(exposed.light.total())), brightest, 1, cv::REDUCE_MAX);
  exposed.clipped |= brightest.reshape(1, exposed.light.rows) > std::max(0.5 * full, from);
  // A mosaic that was demosaicked before has mixed full pixels with those beside them.
  cv::dilate(exposed.clipped, exposed.clipped, cv::Mat::ones(3, 3, CV_8UC1));
  return exposed;
}

double MeasuredRatio(const AlignedExposure& exposure, const AlignedExposure& reference) {
  constexpr double kSigmas = 10;
  std::vector<double> ratios;
  for (int y = 0; y < reference.light.rows; ++y)
    for (int x = 0; x < reference.light.cols; ++x) {
      if (!Tells(exposure, y, x) || !Tells(reference, y, x)) continue;
      const cv::Vec3f a = exposure.light.at<cv::Vec3f>(y, x), b = reference.light.at<cv::Vec3f>(y, x);
      for (int c = 0; c < 3; ++c)
        if (a[c] > kSigmas * std::sqrt(exposure.noise.VarianceAt(a[c])) &&
            b[c] > kSigmas * std::sqrt(reference.noise.VarianceAt(b[c])))
          ratios.push_back(a[c] / b[c]);
    }
  return ratios.size() < kFewPixels ? 0 : Median(ratios);
}

MergedLight MergeExposures(std::span<const AlignedExposure> exposures) {
  CV_Assert(!exposures.empty() && exposures.size() < 256);
  MergedLight merged;
  const cv::Mat alone = AloneAt(exposures, merged.clipped);
  merged.light = LightAlone(exposures, alone);
  merged.ghosts = GhostsAmong(exposures, alone, merged.light, merged.clipped);
  merged.ghost_share = cv::countNonZero(merged.ghosts) / static_cast<double>(merged.ghosts.total());
  constexpr int kRounds = 3;  // weights and light follow from each other
  for (int y = 0; y < merged.light.rows; ++y)
    for (int x = 0; x < merged.light.cols; ++x) {
      if (merged.clipped.at<std::uint8_t>(y, x) != 0 || merged.ghosts.at<std::uint8_t>(y, x) != 0) continue;
      cv::Vec3f& light = merged.light.at<cv::Vec3f>(y, x);
      for (int round = 0; round < kRounds; ++round) {
        cv::Vec3d sum, weights;
        for (const AlignedExposure& exposure : exposures) {
          if (!Tells(exposure, y, x)) continue;
          const cv::Vec3f here = At(exposure, y, x);
          for (int c = 0; c < 3; ++c) {
            const double weight = 1 / std::max(1e-30, VarianceAt(exposure, light[c]));
            sum[c] += weight * here[c];
            weights[c] += weight;
          }
        }
        for (int c = 0; c < 3; ++c) light[c] = static_cast<float>(sum[c] / weights[c]);
      }
    }
  return merged;
}

}  // namespace ulf
