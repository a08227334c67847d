#include "acquisition/calibration/color_chart.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <opencv2/mcc.hpp>
#include <vector>

#include "core/base/quantile.h"

namespace ulf::acquisition {
namespace {

// Returns the homography from chart units to image pixels.
cv::Matx33d ImgFromChart(const std::vector<cv::Point2f>& box) {
  const std::vector<cv::Point2f> outline{{0, 0},
                                         {static_cast<float>(kChartWidth), 0},
                                         {static_cast<float>(kChartWidth), static_cast<float>(kChartHeight)},
                                         {0, static_cast<float>(kChartHeight)}};
  return cv::getPerspectiveTransform(outline, box);
}

ChartPatch MeasurePatch(const cv::Mat& light, const cv::Mat& clipped, double black,
                        const cv::Matx33d& img_from_chart, int patch) {
  constexpr double kMiddle = 0.5;  // of the patch's width
  constexpr int kSamples = 24;     // in each direction
  const Eigen::Vector2d center = PatchCenter(patch);
  std::array<std::vector<double>, 3> bgr;
  ChartPatch measured;
  for (int j = 0; j < kSamples; ++j)
    for (int i = 0; i < kSamples; ++i) {
      const auto across = [](int n) { return kMiddle * kPatchWidth * ((n + 0.5) / kSamples - 0.5); };
      const cv::Vec3d img = img_from_chart * cv::Vec3d(center.x() + across(i), center.y() + across(j), 1);
      const cv::Point at(static_cast<int>(std::floor(img[0] / img[2])),
                         static_cast<int>(std::floor(img[1] / img[2])));
      if (!cv::Rect({}, light.size()).contains(at)) continue;
      if (!clipped.empty() && clipped.at<std::uint8_t>(at) != 0) measured.clipped = true;
      for (int c = 0; c < 3; ++c)
        bgr[static_cast<std::size_t>(c)].push_back(light.at<cv::Vec3f>(at)[c] - black);
    }
  if (bgr[0].size() < kSamples * kSamples / 2) return measured;  // outside the picture: no light, not usable
  for (int c = 0; c < 3; ++c) measured.rgb[2 - c] = Median(bgr[static_cast<std::size_t>(c)]);
  for (double& green : bgr[1]) green = std::abs(green - measured.rgb[1]);
  measured.unevenness = measured.rgb[1] > 0 ? Median(std::move(bgr[1])) / measured.rgb[1] : 0;
  return measured;
}

// Returns whether the greys fall from white to black.
bool GreysAreInOrder(const MeasuredChart& chart) {
  double last = std::numeric_limits<double>::infinity();
  for (int grey = kFirstGrey; grey < kChartPatches; ++grey) {
    const ChartPatch& patch = chart.patches[static_cast<std::size_t>(grey)];
    if (patch.clipped) continue;
    if (!(patch.rgb[1] < last)) return false;
    last = patch.rgb[1];
  }
  return true;
}

}  // namespace

std::optional<MeasuredChart> FindColorChart(const Image& image, double black_level, const cv::Mat& clipped) {
  cv::Mat light = LinearFloat(image);
  // A dark picture is brightened to have contours, for the search only.
  double most = 0;
  cv::Mat smooth;
  cv::GaussianBlur(light, smooth, {}, 2);
  cv::minMaxLoc(smooth.reshape(1), nullptr, &most);
  if (!(most > 0)) return std::nullopt;
  cv::Mat shown = Srgb8FromLinear(light / most);
  const auto detector = cv::mcc::CCheckerDetector::create();
  if (!detector->process(shown, cv::mcc::MCC24, 1)) return std::nullopt;
  const std::vector<cv::Point2f> box = detector->getBestColorChecker()->getBox();
  constexpr double kLeastPerimeter = 300;  // pixels: a patch's middle is six pixels wide. Guessed.
  if (box.size() != 4 || cv::arcLength(box, true) < kLeastPerimeter) return std::nullopt;
  MeasuredChart chart;
  for (std::size_t i = 0; i < 4; ++i) chart.corners[i] = {box[i].x, box[i].y};
  const cv::Matx33d img_from_chart = ImgFromChart(box);
  for (int patch = 0; patch < kChartPatches; ++patch)
    chart.patches[static_cast<std::size_t>(patch)] =
        MeasurePatch(light, clipped, black_level, img_from_chart, patch);
  if (!GreysAreInOrder(chart)) return std::nullopt;
  return chart;
}

}  // namespace ulf::acquisition
