#include "render/masks/background_cut.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <opencv2/imgproc/detail/gcgraph.hpp>
#include <vector>

namespace ulf::render {
namespace {

// All constants are guessed, as logarithms of odds.
constexpr float kUndecided =
    4.5f;  // the cost of turning: a pixel three deviations off the background is as likely either
constexpr float kCutMost = 14;      // the cost of being still is limited to this
constexpr float kUnknownLeans = 2;  // towards turning, without a background
constexpr float kBorder = 7;        // of a border through an even area
constexpr float kWobblePx = 0.3f;   // camera motion whose effect on the background's gradient is tolerated

// Returns each pixel's deviation from the background, in sigmas.
cv::Mat DeviationsFrom(const StillBackground& background, const cv::Mat& picture, float wobble_px) {
  cv::Mat grey, dx, dy, steepness;
  cv::cvtColor(background.color, grey, cv::COLOR_BGR2GRAY);
  cv::Sobel(grey, dx, CV_32F, 1, 0, 3, 1.0 / 4);
  cv::Sobel(grey, dy, CV_32F, 0, 1, 3, 1.0 / 4);
  cv::magnitude(dx, dy, steepness);
  cv::Mat deviations(picture.size(), CV_32F);
  for (int y = 0; y < picture.rows; ++y)
    for (int x = 0; x < picture.cols; ++x) {
      const float sigma = 1.3f * background.noise.at<float>(y, x) + 1 + wobble_px * steepness.at<float>(y, x);
      const cv::Vec3f off = cv::Vec3f(picture.at<cv::Vec3b>(y, x)) - background.color.at<cv::Vec3f>(y, x);
      deviations.at<float>(y, x) = static_cast<float>(cv::norm(off, cv::NORM_INF)) / sigma;
    }
  return deviations;
}

float EdgeOf(const cv::Mat& pixels, const cv::Point& a, const cv::Point& b) {
  const cv::Vec3f d = pixels.type() == CV_32FC3
                          ? pixels.at<cv::Vec3f>(a) - pixels.at<cv::Vec3f>(b)
                          : cv::Vec3f(pixels.at<cv::Vec3b>(a)) - cv::Vec3f(pixels.at<cv::Vec3b>(b));
  return d.dot(d);
}

// Returns the mean of the squared differences between neighbours.
float ContrastOf(const cv::Mat& picture) {
  double sum = 0, count = 0;
  for (int y = 0; y < picture.rows; y += 2)
    for (int x = 1; x < picture.cols; x += 2, ++count) sum += EdgeOf(picture, {x, y}, {x - 1, y});
  return std::max(20.0f, static_cast<float>(sum / std::max(1.0, count)));
}

}  // namespace

cv::Mat CutFromBackground(const cv::Mat& picture, const StillBackground& background, const cv::Mat& labels,
                          const cv::Mat& leans) {
  const cv::Size size = picture.size();
  const cv::Mat deviations = DeviationsFrom(background, picture, kWobblePx);
  const float contrast = ContrastOf(picture);
  const auto label_at = [&](int y, int x) { return static_cast<CutLabel>(labels.at<std::uint8_t>(y, x)); };
  cv::Mat index(size, CV_32S, cv::Scalar(-1));
  int unknown = 0;
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x)
      if (label_at(y, x) == CutLabel::kUnknown) index.at<int>(y, x) = unknown++;
  cv::Mat turning = labels == static_cast<int>(CutLabel::kTurning);
  if (unknown == 0) return turning;
  cv::detail::GCGraph<float> graph(static_cast<unsigned>(unknown), static_cast<unsigned>(8 * unknown));
  for (int i = 0; i < unknown; ++i) graph.addVtx();

  const auto border_between = [&](const cv::Point& a, const cv::Point& b) {
    // An edge that the background also has belongs to it as far as both pixels look like it.
    const float off = std::max(deviations.at<float>(a), deviations.at<float>(b));
    const float known = std::min(background.known.at<float>(a), background.known.at<float>(b));
    const float like = known * std::exp(-off * off / 18);
    const float behind = EdgeOf(background.color, a, b);
    const float edge = EdgeOf(picture, a, b) / (1 + like * behind / 25);
    return kBorder * std::exp(-edge / (2 * contrast));
  };
  constexpr int kAcross[4][2] = {{1, 0}, {0, 1}, {1, 1}, {-1, 1}};
  constexpr float kShare[4] = {1, 1, 0.7071f, 0.7071f};
  std::vector<float> source(static_cast<std::size_t>(unknown)), sink(static_cast<std::size_t>(unknown));
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      const cv::Point here(x, y);
      const int own = index.at<int>(here);
      if (own >= 0) {
        const float known = background.known.at<float>(here), off = deviations.at<float>(here);
        const float still = known * std::min(0.5f * off * off, kCutMost) +
                            (1 - known) * (kUndecided + kUnknownLeans) +
                            (leans.empty() ? 0.0f : leans.at<float>(here));
        source[static_cast<std::size_t>(own)] += std::max(0.0f, still);
        sink[static_cast<std::size_t>(own)] += kUndecided + std::max(0.0f, -still);
      }
      for (int k = 0; k < 4; ++k) {
        const cv::Point there = here + cv::Point(kAcross[k][0], kAcross[k][1]);
        if (there.x < 0 || there.x >= size.width || there.y >= size.height) continue;
        const int other = index.at<int>(there);
        if (own < 0 && other < 0) continue;
        const float border = kShare[k] * border_between(here, there);
        if (own >= 0 && other >= 0) {
          graph.addEdges(own, other, border, border);
          continue;
        }
        const bool known_turns =
            label_at(own >= 0 ? there.y : y, own >= 0 ? there.x : x) == CutLabel::kTurning;
        (known_turns ? source : sink)[static_cast<std::size_t>(std::max(own, other))] += border;
      }
    }
  for (int i = 0; i < unknown; ++i)
    graph.addTermWeights(i, source[static_cast<std::size_t>(i)], sink[static_cast<std::size_t>(i)]);
  graph.maxFlow();
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x)
      if (const int own = index.at<int>(y, x); own >= 0 && graph.inSourceSegment(own))
        turning.at<std::uint8_t>(y, x) = 255;
  return turning;
}

}  // namespace ulf::render
