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

// From chart units to image pixels.
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

// From white to black.
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

const std::array<Eigen::Vector3d, kChartPatches>& ChartLab() {
  static const std::array<Eigen::Vector3d, kChartPatches> lab{{
      {37.986, 13.555, 14.059},  {65.711, 18.130, 17.810},  {49.927, -4.880, -21.925},
      {43.139, -13.095, 21.905}, {55.112, 8.844, -25.399},  {70.719, -33.397, -0.199},
      {62.661, 36.067, 57.096},  {40.020, 10.410, -45.964}, {51.124, 48.239, 16.248},
      {30.325, 22.976, -21.587}, {72.532, -23.709, 57.255}, {71.941, 19.363, 67.857},
      {28.778, 14.179, -50.297}, {55.261, -38.342, 31.370}, {42.101, 53.378, 28.190},
      {81.733, 4.039, 79.819},   {51.935, 49.986, -14.574}, {51.038, -28.631, -28.638},
      {96.539, -0.425, 1.186},   {81.257, -0.638, -0.335},  {66.766, -0.734, -0.504},
      {50.867, -0.153, -0.270},  {35.656, -0.421, -1.231},  {20.461, -0.079, -0.973},
  }};
  return lab;
}

Eigen::Vector2d PatchCenter(int patch) {
  const auto at = [](int n) { return kPatchGap + 0.5 * kPatchWidth + n * (kPatchWidth + kPatchGap); };
  return {at(patch % kChartColumns), at(patch / kChartColumns)};
}

std::optional<MeasuredChart> FindColorChart(const Image& image, double black_level, const cv::Mat& clipped) {
  cv::Mat light = LinearFloat(image);
  // For finding alone: brightened so that a dark picture has contours.
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
