#include "coverage/bound/subject_light.h"

#include <algorithm>

#include "core/base/quantile.h"

namespace ulf::coverage {
namespace {

// Returns the brightest channel as stored, 0 to 1.
float Brightness(const Image& image, int x, int y) {
  const cv::Mat& pixels = image.pixels;
  const int channels = pixels.channels();
  float brightest = 0;
  for (int c = 0; c < channels; ++c) {
    const int i = x * channels + c;
    float value;
    if (pixels.depth() == CV_8U)
      value = static_cast<float>(pixels.ptr<std::uint8_t>(y)[i]) / 255.0f;
    else if (pixels.depth() == CV_16U)
      value = static_cast<float>(pixels.ptr<std::uint16_t>(y)[i]) / 65535.0f;
    else
      value = pixels.ptr<float>(y)[i];
    brightest = std::max(brightest, value);
  }
  return brightest;
}

}  // namespace

std::optional<SubjectLight> LightInside(const Image& image, const std::vector<Eigen::Vector2d>& outline) {
  Eigen::Vector2d low = outline[0], high = outline[0];
  for (const Eigen::Vector2d& corner : outline) {
    low = low.cwiseMin(corner);
    high = high.cwiseMax(corner);
  }
  constexpr float kClipped = 0.995f;  // display-encoded
  constexpr int kSamplesAcross = 40;
  const double step = std::max(1.0, (high - low).maxCoeff() / kSamplesAcross);
  const Eigen::Vector2d middle = 0.5 * (low + high), half = 0.5 * (high - low);
  const bool linear = image.transfer == Transfer::kLinear;
  std::vector<double> values;
  std::size_t clipped = 0;
  double sum = 0;
  for (double v = low.y(); v < high.y(); v += step)
    for (double u = low.x(); u < high.x(); u += step) {
      const Eigen::Vector2d from_middle = (Eigen::Vector2d(u, v) - middle).cwiseQuotient(half);
      if (from_middle.squaredNorm() > 1) continue;
      const int x = std::clamp(static_cast<int>(u), 0, image.width() - 1);
      const int y = std::clamp(static_cast<int>(v), 0, image.height() - 1);
      const float brightness = Brightness(image, x, y);
      values.push_back(brightness);
      clipped += (linear ? SrgbFromLinear(brightness) : brightness) >= kClipped;
      sum += linear ? brightness : LinearFromSrgb(brightness);
    }
  if (values.empty()) return std::nullopt;
  const auto count = static_cast<double>(values.size());
  const auto encoded = [&](double share) -> double {
    const auto value = static_cast<float>(Quantile(values, share));
    return linear ? SrgbFromLinear(value) : value;
  };
  return SubjectLight{.clipped_share = static_cast<double>(clipped) / count,
                      .brightest_tenth = encoded(0.9),
                      .brightest_hundredth = encoded(0.99),
                      .mean_linear = sum / count};
}

}  // namespace ulf::coverage
