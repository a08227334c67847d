#include "core/image/exposure_merge.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "core/base/error.h"
#include "core/base/quantile.h"
#include "core/image/clipped.h"
#include "core/image/exposure_ghosts.h"

namespace ulf {
namespace {

constexpr double kCutSigmas = 4;  // below full scale
// Constants of MeasuredRatio():
constexpr int kRatioBlock = 8;  // pixels across
constexpr std::size_t kFewBlocks = 20;
constexpr double kRatioSigmas = 3, kMostRatioError = 0.005;

struct Interpolation {
  bool is_mean = false;     // exactly the mean of neighbouring numbers
  bool is_of_full = false;  // one of these is at full scale
};

// Computes Demosaiced()'s (image.h) result for a colour at a pixel of another one: the mean of two opposite
// numbers, or of four. `numbers` is CV_32SC3; `full` CV_8UC3.
Interpolation InterpolationAt(const cv::Mat& numbers, const cv::Mat& full, int y, int x, int c) {
  const auto number = [&](int dy, int dx) { return numbers.at<cv::Vec3i>(y + dy, x + dx)[c]; };
  const auto is_full = [&](int dy, int dx) { return full.at<cv::Vec3b>(y + dy, x + dx)[c] != 0; };
  const int here = number(0, 0);
  Interpolation found;
  for (const auto& [dy, dx] : {std::pair(0, 1), {1, 0}})
    if (std::abs(2 * here - number(dy, dx) - number(-dy, -dx)) <= 1) {
      found.is_mean = true;
      found.is_of_full |= is_full(dy, dx) || is_full(-dy, -dx);
    }
  if (std::abs(4 * here - number(1, 1) - number(1, -1) - number(-1, 1) - number(-1, -1)) <= 2) {
    found.is_mean = true;
    found.is_of_full |= is_full(1, 1) || is_full(1, -1) || is_full(-1, 1) || is_full(-1, -1);
  }
  return found;
}

// Returns whether the picture's colours are means of others as often as Demosaiced() makes them so: two of
// three on average, at numbers so large that chance explains hardly one of ten.
bool IsMadeOfMeans(const cv::Mat& numbers, const cv::Mat& full, int full_scale) {
  constexpr int kGrid = 3, kFew = 200;
  int means = 0, all = 0;
  for (int y = 1; y + 1 < numbers.rows; y += kGrid)
    for (int x = 1; x + 1 < numbers.cols; ++x)
      for (int c = 0; c < 3; ++c) {
        if (numbers.at<cv::Vec3i>(y, x)[c] < full_scale / 8 || full.at<cv::Vec3b>(y, x)[c] != 0) continue;
        ++all;
        means += InterpolationAt(numbers, full, y, x, c).is_mean;
      }
  return all >= kFew && 2 * means > all;
}

// Marks clipped numbers and those whose noise reaches full scale, because noise is cut off there and the mean
// is too dark; and numbers that a demosaicing made of these, but no more: the sensor's own numbers beside
// clipped ones are the best there are just below full scale. If the demosaicing is unknown, marks all around.
cv::Mat ClippedWithNoise(const SensorPicture& picture, const SensorNoise& noise) {
  const double full_light = 1 - picture.black_level;
  const double light =
      std::max(0.5 * full_light, full_light - kCutSigmas * std::sqrt(noise.VarianceAt(full_light)));
  const auto number = static_cast<float>(picture.black_level + light);
  const double from = picture.image.transfer == Transfer::kSrgb ? SrgbFromLinear(number) : number;
  const Image image = Demosaiced(picture.image);
  const cv::Mat full = ClippedColors(image, std::min(kClippedFrom, from));
  if (full.empty()) return cv::Mat::zeros(image.pixels.size(), CV_8UC3);
  cv::Mat clipped = ClippedAfterDemosaicing(full);
  if (picture.mixes_colors) return InThreeColors(AnyColor(clipped));
  if (image.pixels.type() != CV_16UC3) return clipped;
  cv::Mat numbers;
  image.pixels.convertTo(numbers, CV_32S);
  if (!IsMadeOfMeans(numbers, full, static_cast<int>(FullScale(CV_16U)))) return clipped;
  for (int y = 1; y + 1 < full.rows; ++y)
    for (int x = 1; x + 1 < full.cols; ++x)
      for (int c = 0; c < 3; ++c)
        if (clipped.at<cv::Vec3b>(y, x)[c] != 0 && full.at<cv::Vec3b>(y, x)[c] == 0 &&
            !InterpolationAt(numbers, full, y, x, c).is_of_full)
          clipped.at<cv::Vec3b>(y, x)[c] = 0;
  return clipped;
}

// Averages the exposures over their ratios at pixels that are `told`; elsewhere `light` stays. `slope` is the
// change of light in a pixel, which adds uncertainty to an exposure that may be misaligned; empty if not yet
// known.
void WeighByVariance(std::span<const AlignedExposure> exposures, const std::vector<cv::Mat>& told,
                     const cv::Mat& slope, cv::Mat& light) {
  constexpr int kRounds = 3;  // weights and light depend on each other
  for (int y = 0; y < light.rows; ++y)
    for (int x = 0; x < light.cols; ++x) {
      cv::Vec3f& here = light.at<cv::Vec3f>(y, x);
      const cv::Vec3f change = slope.empty() ? cv::Vec3f() : slope.at<cv::Vec3f>(y, x);
      for (int round = 0; round < kRounds; ++round) {
        cv::Vec3d sum, weights;
        for (std::size_t i = 0; i < exposures.size(); ++i) {
          const cv::Vec3b& counts = told[i].at<cv::Vec3b>(y, x);
          if (counts == cv::Vec3b()) continue;
          const cv::Vec3f there = exposures[i].LightAt(y, x);
          for (int c = 0; c < 3; ++c) {
            if (counts[c] == 0) continue;
            const double shift = exposures[i].misaligned_px * change[c];
            const double weight = 1 / std::max(1e-30, exposures[i].VarianceAt(here[c]) + shift * shift);
            sum[c] += weight * there[c];
            weights[c] += weight;
          }
        }
        for (int c = 0; c < 3; ++c)
          if (weights[c] > 0) here[c] = static_cast<float>(sum[c] / weights[c]);
      }
    }
}

}  // namespace

std::vector<ExposedLight> ExposedLightsOf(std::span<const SensorPicture> pictures) {
  std::vector<ExposedLight> lights;
  std::map<double, NoiseSamples> samples;  // by gain
  for (const SensorPicture& picture : pictures) {
    if (!(picture.black_level >= 0 && picture.black_level < 1))
      throw Error("a black level of {} is no share of full scale; correct it in the journal",
                  picture.black_level);
    ExposedLight& exposed = lights.emplace_back();
    exposed.light = LinearFloat(picture.image);
    if (picture.black_level > 0) exposed.light -= cv::Scalar::all(picture.black_level);
    cv::Mat full = ClippedPixels(picture.image);
    if (full.empty()) full = cv::Mat::zeros(exposed.light.size(), CV_8UC1);
    samples[picture.gain].Add(picture.image, exposed.light, full);
  }
  for (std::size_t i = 0; i < lights.size(); ++i) {
    lights[i].noise = samples[pictures[i].gain].Fit();
    lights[i].clipped = ClippedWithNoise(pictures[i], lights[i].noise);
  }
  return lights;
}

double MeasuredRatio(const AlignedExposure& exposure, const AlignedExposure& reference) {
  // The longer exposure selects the places: the noisy shorter one would prefer places that noise made bright.
  const AlignedExposure& longer = exposure.ratio > reference.ratio ? exposure : reference;
  const AlignedExposure& shorter = exposure.ratio > reference.ratio ? reference : exposure;
  const double told = shorter.ratio / longer.ratio;
  const cv::Mat both = exposure.Usable() & reference.Usable();
  std::vector<double> ratios;
  for (int y = 0; y + kRatioBlock <= both.rows; y += kRatioBlock)
    for (int x = 0; x + kRatioBlock <= both.cols; x += kRatioBlock) {
      const cv::Rect block(x, y, kRatioBlock, kRatioBlock);
      const cv::Scalar told_share = cv::mean(both(block));
      if (told_share == cv::Scalar()) continue;
      const cv::Scalar bright = cv::mean(longer.light(block)), dark = cv::mean(shorter.light(block));
      for (int c = 0; c < 3; ++c)
        if (told_share[c] == 255 &&
            told * bright[c] > kRatioSigmas * std::sqrt(shorter.noise.VarianceAt(told * bright[c])))
          ratios.push_back(dark[c] / bright[c]);
    }
  if (ratios.size() < kFewBlocks) return 0;
  const double median = Median(ratios);
  std::vector<double> off;
  for (const double each : ratios) off.push_back(std::abs(each - median));
  const double error = 1.25 * 1.4826 * Median(off) / std::sqrt(ratios.size());  // standard error of a median
  if (error > kMostRatioError * median) return 0;
  return &longer == &exposure ? 1 / median : median;
}

MergedLight MergeExposures(std::span<const AlignedExposure> exposures) {
  CV_Assert(!exposures.empty() && exposures.size() < 256);
  const GhostReference alone = GhostReferenceOf(exposures);
  MergedLight merged{.light = alone.light.clone(),
                     .clipped = AnyColor(alone.clipped),
                     .ghosts = cv::Mat::zeros(alone.light.size(), CV_8UC1)};
  std::vector<cv::Mat> told;
  for (std::size_t i = 0; i < exposures.size(); ++i) {
    const cv::Mat ghosts = GhostsIn(exposures, i, alone);
    merged.ghosts |= ghosts;
    told.push_back(exposures[i].Usable() & ~InThreeColors(ghosts));
  }
  WeighByVariance(exposures, told, {}, merged.light);
  const cv::Mat slope = SlopeOf(merged.light);
  merged.light = alone.light.clone();
  WeighByVariance(exposures, told, slope, merged.light);
  merged.ghost_share = cv::countNonZero(merged.ghosts) / static_cast<double>(merged.ghosts.total());
  return merged;
}

}  // namespace ulf
