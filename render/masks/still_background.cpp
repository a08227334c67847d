#include "render/masks/still_background.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/base/at.h"
#include "core/base/parallel_for.h"
#include "core/base/quantile.h"

namespace ulf::render {
namespace {

// All constants are guessed. They are shares of a pixel's pictures: those that agree with a background, and
// those that do so consecutively.
constexpr double kStillShare = 0.96;
constexpr double kDoubtedShare = 0.04, kKnownShare = 0.1;
constexpr std::size_t kRun = 3;
constexpr float kAgreeSigmas = 3.5f, kLeastAgree = 4;  // levels
// Spread of the agreeing values over the noise: a still pixel has 1.
constexpr float kSureSpread = 1.2f, kMostSpread = 1.45f;

using Pixel = cv::Vec3b;

// Standard deviation of a value by its level, from the differences between neighbouring pictures; the smaller
// ones are used, because the subject causes the others.
class NoiseByLevel {
 public:
  explicit NoiseByLevel(std::span<const cv::Mat> pictures) {
    std::array<std::vector<int>, kBins> differences;
    constexpr int kStep = 5;
    for (std::size_t i = 1; i < pictures.size(); ++i)
      for (int y = 0; y < pictures[i].rows; y += kStep)
        for (int x = 0; x < pictures[i].cols; x += kStep)
          for (int c = 0; c < 3; ++c) {
            const int a = pictures[i].at<Pixel>(y, x)[c], b = pictures[i - 1].at<Pixel>(y, x)[c];
            differences[BinOf(0.5f * static_cast<float>(a + b))].push_back(std::abs(a - b));
          }
    std::vector<double> told;
    for (std::size_t bin = 0; bin < kBins; ++bin) {
      sigmas_[bin] = SigmaOf(differences[bin]);
      if (sigmas_[bin] > 0) told.push_back(sigmas_[bin]);
    }
    middle_ = std::max(kLeast, static_cast<float>(Quantile(told, 0.5)));
    // A level that occurs only on the subject gives no noise.
    for (float& sigma : sigmas_) sigma = sigma > 0 ? std::clamp(sigma, kLeast, 1.5f * middle_) : middle_;
  }
  float At(float level) const { return sigmas_[BinOf(level)]; }
  float Middle() const { return middle_; }

 private:
  static constexpr std::size_t kBins = 16, kFewest = 100;
  static constexpr float kLeast = 0.8f;  // of numbers that are rounded to levels
  static std::size_t BinOf(float level) {
    return std::min(kBins - 1, static_cast<std::size_t>(std::max(0.0f, level) * kBins / 256));
  }
  // The mean of the lower 40 % of absolute differences of a normal distribution is 0.26 of its deviation,
  // which rounding to levels does not change. Returns 0 for too few.
  static float SigmaOf(std::vector<int>& differences) {
    constexpr double kLower = 0.4, kMeanOfLower = 0.26;
    if (differences.size() < kFewest) return 0;
    const auto end =
        differences.begin() + static_cast<long>(kLower * static_cast<double>(differences.size()));
    std::nth_element(differences.begin(), end, differences.end());
    double sum = 0;
    for (auto each = differences.begin(); each != end; ++each) sum += *each;
    return static_cast<float>(sum / static_cast<double>(end - differences.begin()) / kMeanOfLower /
                              std::sqrt(2.0));
  }

  std::array<float, kBins> sigmas_{};
  float middle_ = 1;
};

int Apart(const Pixel& a, const Pixel& b) {
  return std::max({std::abs(a[0] - b[0]), std::abs(a[1] - b[1]), std::abs(a[2] - b[2])});
}

struct Mode {
  cv::Vec3f color{0, 0, 0};
  std::size_t count = 0;    // pictures that agree
  std::size_t in_runs = 0;  // of these, consecutive ones
  float spread = 0;         // of the agreeing values, over the noise
};

Mode ModeOf(const std::vector<Pixel>& values, const NoiseByLevel& noise, std::vector<char>& agrees) {
  Mode mode;
  std::size_t best = 0;
  const auto tolerance_at = [&](const Pixel& pixel) {
    const float level = static_cast<float>(pixel[0] + pixel[1] + pixel[2]) / 3;
    return static_cast<int>(std::lround(std::max(kLeastAgree, kAgreeSigmas * noise.At(level))));
  };
  for (std::size_t i = 0; i < values.size(); ++i) {
    std::size_t count = 0;
    const int tolerance = tolerance_at(values[i]);
    for (const Pixel& other : values) count += Apart(values[i], other) <= tolerance;
    if (count > mode.count) mode.count = count, best = i;
    if (20 * count > 19 * values.size()) break;
  }
  // Uses the mean of the agreeing values, because the value with the most neighbours is itself noisy.
  const auto agree_with = [&](const Pixel& center) {
    const int tolerance = tolerance_at(center);
    cv::Vec3f sum(0, 0, 0);
    mode.count = 0;
    agrees.assign(values.size(), 0);
    for (std::size_t i = 0; i < values.size(); ++i)
      if (Apart(center, values[i]) <= tolerance) {
        agrees[i] = 1;
        ++mode.count;
        sum += cv::Vec3f(values[i][0], values[i][1], values[i][2]);
      }
    mode.color = sum / static_cast<float>(std::max<std::size_t>(1, mode.count));
  };
  agree_with(values[best]);
  agree_with({cv::saturate_cast<std::uint8_t>(mode.color[0]), cv::saturate_cast<std::uint8_t>(mode.color[1]),
              cv::saturate_cast<std::uint8_t>(mode.color[2])});
  float squares = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!agrees[i]) continue;
    for (int c = 0; c < 3; ++c) {
      const float off = (static_cast<float>(values[i][c]) - mode.color[c]) / noise.At(mode.color[c]);
      squares += off * off;
    }
  }
  if (mode.count > 1) mode.spread = std::sqrt(squares / static_cast<float>(3 * (mode.count - 1)));
  for (std::size_t i = 0; i < values.size();) {
    std::size_t end = i;
    while (end < values.size() && agrees[end]) ++end;
    if (end - i >= kRun) mode.in_runs += end - i;
    i = std::max(end, i + 1);
  }
  return mode;
}

}  // namespace

StillBackground EstimateBackground(std::span<const cv::Mat> pictures, std::span<const cv::Mat> turning) {
  CV_Assert(!pictures.empty() && (turning.empty() || turning.size() == pictures.size()));
  const cv::Size size = pictures[0].size();
  const NoiseByLevel noise(pictures);
  StillBackground background{cv::Mat::zeros(size, CV_32FC3), cv::Mat::zeros(size, CV_32F),
                             cv::Mat::zeros(size, CV_8U), cv::Mat(size, CV_32F, cv::Scalar(noise.Middle()))};
  cv::Mat spread = cv::Mat::zeros(size, CV_32F);
  const auto all = static_cast<double>(pictures.size());
  ParallelFor(At(size.height), [&](std::size_t row) {
    const int y = static_cast<int>(row);
    std::vector<Pixel> values;
    std::vector<char> agrees;
    for (int x = 0; x < size.width; ++x) {
      values.clear();
      for (std::size_t i = 0; i < pictures.size(); ++i)
        if (turning.empty() || turning[i].empty() || turning[i].at<std::uint8_t>(y, x) == 0)
          values.push_back(pictures[i].at<Pixel>(y, x));
      if (values.size() < kRun) continue;
      const Mode mode = ModeOf(values, noise, agrees);
      background.color.at<cv::Vec3f>(y, x) = mode.color;
      background.noise.at<float>(y, x) = noise.At((mode.color[0] + mode.color[1] + mode.color[2]) / 3);
      spread.at<float>(y, x) = mode.spread;
      const bool still = static_cast<double>(mode.count) >= kStillShare * all;
      background.still.at<std::uint8_t>(y, x) = still ? 255 : 0;
      const double share = static_cast<double>(mode.in_runs) / all;
      background.known.at<float>(y, x) =
          still ? 1.0f
                : static_cast<float>(
                      std::clamp((share - kDoubtedShare) / (kKnownShare - kDoubtedShare), 0.0, 1.0));
    }
  });
  // A slowly turning, nearly uniform surface recurs nearly unchanged: its values spread wider than noise.
  cv::Mat around;
  cv::boxFilter(spread.mul(spread), around, CV_32F, {5, 5});
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      const float wide = std::sqrt(around.at<float>(y, x));
      const float belief = std::clamp((kMostSpread - wide) / (kMostSpread - kSureSpread), 0.0f, 1.0f);
      background.known.at<float>(y, x) *= belief;
      if (belief < 0.5f) background.still.at<std::uint8_t>(y, x) = 0;
    }
  return background;
}

cv::Mat StillConnectedToRim(const StillBackground& background) {
  cv::Mat still;
  cv::morphologyEx(background.still, still, cv::MORPH_OPEN, cv::Mat::ones(3, 3, CV_8U));
  cv::Mat parts;
  const int count = cv::connectedComponents(still, parts, 4, CV_32S);
  std::vector<char> reaches(static_cast<std::size_t>(count), 0);
  for (int y = 0; y < parts.rows; ++y)
    for (int x = 0; x < parts.cols; ++x)
      if (y == 0 || x == 0 || y == parts.rows - 1 || x == parts.cols - 1)
        reaches[At(parts.at<int>(y, x))] = 1;
  reaches[0] = 0;
  cv::Mat outside = cv::Mat::zeros(still.size(), CV_8U);
  for (int y = 0; y < parts.rows; ++y)
    for (int x = 0; x < parts.cols; ++x)
      if (reaches[At(parts.at<int>(y, x))]) outside.at<std::uint8_t>(y, x) = 255;
  return outside;
}

BackgroundColors::BackgroundColors(const StillBackground& background, const cv::Mat& outside)
    : shares_(kBins * kBins * kBins, 0.0f) {
  constexpr double kLeastShare = 0.05;  // of the picture, for the background's colours. Guessed.
  is_reliable_ = cv::countNonZero(outside) >= kLeastShare * static_cast<double>(outside.total());
  float count = 0;
  for (int y = 0; y < outside.rows; ++y)
    for (int x = 0; x < outside.cols; ++x) {
      if (outside.at<std::uint8_t>(y, x) == 0) continue;
      const cv::Vec3f& color = background.color.at<cv::Vec3f>(y, x);
      ++shares_[Index(BinOf(color[0]), BinOf(color[1]), BinOf(color[2]))];
      ++count;
    }
  for (float& share : shares_) share /= std::max(1.0f, count);
}

float BackgroundColors::ShareAround(const cv::Vec3f& color) const {
  const int at[3] = {BinOf(color[0]), BinOf(color[1]), BinOf(color[2])};
  float sum = 0;
  for (int b = std::max(0, at[0] - 1); b <= std::min(kBins - 1, at[0] + 1); ++b)
    for (int g = std::max(0, at[1] - 1); g <= std::min(kBins - 1, at[1] + 1); ++g)
      for (int r = std::max(0, at[2] - 1); r <= std::min(kBins - 1, at[2] + 1); ++r)
        sum += shares_[Index(b, g, r)];
  return sum;
}

int BackgroundColors::BinOf(float level) {
  return std::clamp(static_cast<int>(level * kBins / 256), 0, kBins - 1);
}

std::size_t BackgroundColors::Index(int b, int g, int r) { return At((b * kBins + g) * kBins + r); }

void DropForeignColors(StillBackground& background, const cv::Mat& outside, const BackgroundColors& colors) {
  constexpr float kForeign = 5e-5f,
                  kFamiliar = 3e-4f;  // shares of the outside's pixels around a colour. Guessed.
  if (!colors.IsReliable()) return;
  for (int y = 0; y < outside.rows; ++y)
    for (int x = 0; x < outside.cols; ++x) {
      float& known = background.known.at<float>(y, x);
      if (known == 0 || outside.at<std::uint8_t>(y, x) != 0) continue;
      const float share = colors.ShareAround(background.color.at<cv::Vec3f>(y, x));
      known *= std::clamp((share - kForeign) / (kFamiliar - kForeign), 0.0f, 1.0f);
    }
}

cv::Point2d ShiftAgainst(const StillBackground& background, const cv::Mat& picture) {
  // Solves the least squares of Lucas and Kanade (1981) over the still pixels with the background's
  // gradients.
  cv::Mat grey, moved, dx, dy;
  cv::cvtColor(background.color, grey, cv::COLOR_BGR2GRAY);
  cv::GaussianBlur(grey, grey, {}, 1);
  cv::Sobel(grey, dx, CV_32F, 1, 0, 3, 1.0 / 8);
  cv::Sobel(grey, dy, CV_32F, 0, 1, 3, 1.0 / 8);
  cv::Mat own;
  cv::cvtColor(picture, own, cv::COLOR_BGR2GRAY);
  own.convertTo(own, CV_32F);
  cv::GaussianBlur(own, own, {}, 1);
  cv::Point2d shift(0, 0);
  constexpr int kRounds = 6, kRim = 4;
  constexpr float kOutlier = 40;  // levels; guessed
  constexpr double kSurePx =
      0.02;  // px, of an accepted shift; neighbouring pixels are not independent. Guessed.
  const double noise = cv::mean(background.noise)[0];
  for (int round = 0; round < kRounds; ++round) {
    const cv::Matx23d by(1, 0, shift.x, 0, 1, shift.y);
    cv::warpAffine(own, moved, by, own.size(), cv::INTER_LINEAR | cv::WARP_INVERSE_MAP, cv::BORDER_REPLICATE);
    cv::Matx22d normal = cv::Matx22d::zeros();
    cv::Vec2d right(0, 0);
    for (int y = kRim; y < own.rows - kRim; ++y)
      for (int x = kRim; x < own.cols - kRim; ++x) {
        if (background.still.at<std::uint8_t>(y, x) == 0) continue;
        const float difference = grey.at<float>(y, x) - moved.at<float>(y, x);
        if (std::abs(difference) > kOutlier) continue;
        const cv::Vec2d g(dx.at<float>(y, x), dy.at<float>(y, x));
        normal += g * g.t();
        right += difference * g;
      }
    // Computes the standard deviation of the shift along its least certain direction.
    const double half_trace = 0.5 * cv::trace(normal), det = cv::determinant(normal);
    const double least = half_trace - std::sqrt(std::max(0.0, half_trace * half_trace - det));
    if (!(least > 0) || noise > kSurePx * std::sqrt(least)) return {0, 0};
    const cv::Vec2d step = normal.solve(right, cv::DECOMP_CHOLESKY);
    shift += cv::Point2d(step[0], step[1]);
    if (cv::norm(step) < 0.01) break;
  }
  return shift;
}

}  // namespace ulf::render
