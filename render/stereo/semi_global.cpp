#include "render/stereo/semi_global.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace ulf::render {
namespace {

constexpr std::uint16_t kNever = 30000;  // above any cost of a path
constexpr std::size_t kSide = 16;        // padding with this cost on both sides of a pixel's labels, aligned

// The least cost of reaching each label along one direction, for the pixels of one row.
struct Paths {
  Paths(int width, std::size_t labels)
      : step(labels + 2 * kSide),
        costs(static_cast<std::size_t>(width) * step, kNever),
        least(static_cast<std::size_t>(width), 0) {}
  std::uint16_t* At(int x) { return costs.data() + static_cast<std::size_t>(x) * step + kSide; }
  std::size_t step;
  std::vector<std::uint16_t> costs;
  std::vector<std::uint16_t> least;
};

std::uint16_t Extend(const std::uint8_t* __restrict cost, const std::uint16_t* __restrict before,
                     std::uint16_t least_before, std::uint16_t small, std::uint16_t large, std::size_t labels,
                     std::uint16_t* __restrict path, std::uint16_t* __restrict sum) {
  const auto lower = [](std::uint16_t a, std::uint16_t b) { return a < b ? a : b; };
  const std::uint16_t jump = static_cast<std::uint16_t>(least_before + large);
  std::uint16_t least = kNever;
  for (std::size_t d = 0; d < labels; ++d) {
    const std::uint16_t beside = static_cast<std::uint16_t>(lower(before[d - 1], before[d + 1]) + small);
    const std::uint16_t from = lower(lower(before[d], beside), jump);
    const std::uint16_t value = static_cast<std::uint16_t>(cost[d] + from - least_before);
    path[d] = value;
    sum[d] = static_cast<std::uint16_t>(sum[d] + value);
    least = lower(least, value);
  }
  return least;
}

std::uint16_t Begin(const std::uint8_t* cost, std::size_t labels, std::uint16_t* path, std::uint16_t* sum) {
  std::uint16_t least = kNever;
  for (std::size_t d = 0; d < labels; ++d) {
    path[d] = cost[d];
    sum[d] = static_cast<std::uint16_t>(sum[d] + cost[d]);
    least = std::min<std::uint16_t>(least, cost[d]);
  }
  return least;
}

// Returns the minimum of the parabola through the costs of the best label and its neighbours, summed over the
// surrounding pixels that have about the same label.
float BetweenLabels(const CostVolume& volume, const cv::Mat_<int>& best, int x, int y) {
  const int label = best(y, x);
  if (label == 0 || label == volume.labels() - 1) return static_cast<float>(label);
  int before = 0, at = 0, after = 0;
  for (int v = std::max(0, y - 1); v <= std::min(volume.height() - 1, y + 1); ++v)
    for (int u = std::max(0, x - 1); u <= std::min(volume.width() - 1, x + 1); ++u) {
      if (std::abs(best(v, u) - label) > 1) continue;
      const std::uint8_t* cost = volume.At(u, v) + label;
      before += cost[-1];
      at += cost[0];
      after += cost[1];
    }
  const int bend = before - 2 * at + after;
  const float shift = bend > 0 ? 0.5f * static_cast<float>(before - after) / static_cast<float>(bend) : 0;
  return static_cast<float>(label) + std::clamp(shift, -0.5f, 0.5f);
}

}  // namespace

cv::Mat SemiGlobalMinimum(const CostVolume& volume, const cv::Mat& grey, const SemiGlobalOptions& options) {
  const int width = volume.width(), height = volume.height();
  const std::size_t labels = volume.stride();
  std::vector<std::uint16_t> sums(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * labels,
                                  0);
  const auto sum_at = [&](int x, int y) {
    return sums.data() +
           (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)) *
               labels;
  };
  const std::uint16_t small = static_cast<std::uint16_t>(options.small_step);
  const auto large_between = [&](int x, int y, int other_x, int other_y) {
    const float change = std::abs(grey.at<float>(y, x) - grey.at<float>(other_y, other_x));
    return static_cast<std::uint16_t>(std::max<int>(
        options.small_step + 2,
        static_cast<int>(static_cast<float>(options.large_step) / (1 + change / options.edge_grey))));
  };

  // Paths come from above and the left, then from below and the right.
  for (const int way : {1, -1}) {
    std::array<Paths, 3> above{Paths(width, labels), Paths(width, labels), Paths(width, labels)},
        here = above;
    Paths beside(width, labels);
    for (int i = 0; i < height; ++i) {
      const int y = way > 0 ? i : height - 1 - i;
      for (int j = 0; j < width; ++j) {
        const int x = way > 0 ? j : width - 1 - j;
        const std::uint8_t* cost = volume.At(x, y);
        std::uint16_t* sum = sum_at(x, y);
        const std::size_t at = static_cast<std::size_t>(x);
        const int behind = x - way;
        if (behind >= 0 && behind < width)
          beside.least[at] = Extend(cost, beside.At(behind), beside.least[static_cast<std::size_t>(behind)],
                                    small, large_between(x, y, behind, y), labels, beside.At(x), sum);
        else
          beside.least[at] = Begin(cost, labels, beside.At(x), sum);
        for (int k = 0; k < 3; ++k) {
          const int from = x + k - 1;
          Paths& paths = here[static_cast<std::size_t>(k)];
          Paths& last = above[static_cast<std::size_t>(k)];
          if (i > 0 && from >= 0 && from < width)
            paths.least[at] = Extend(cost, last.At(from), last.least[static_cast<std::size_t>(from)], small,
                                     large_between(x, y, from, y - way), labels, paths.At(x), sum);
          else
            paths.least[at] = Begin(cost, labels, paths.At(x), sum);
        }
      }
      std::swap(above, here);
    }
  }

  cv::Mat_<int> best(height, width);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::uint16_t* sum = sum_at(x, y);
      best(y, x) = static_cast<int>(std::min_element(sum, sum + volume.labels()) - sum);
    }
  cv::Mat result(height, width, CV_32F);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) result.at<float>(y, x) = BetweenLabels(volume, best, x, y);
  return result;
}

}  // namespace ulf::render
