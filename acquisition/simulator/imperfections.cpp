#include "acquisition/simulator/imperfections.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "acquisition/simulator/scene/noise.h"

namespace ulf::acquisition {
namespace {

float SpotNumber(std::uint64_t seed, int spot, int which) {
  return UnitFloat(HashLattice(spot, which, 57, static_cast<std::uint32_t>(seed)));
}

}  // namespace

void Defocus(cv::Mat& radiance, double radius_px) {
  constexpr double kSharp = 0.3;  // a smaller disc falls into one pixel
  if (radius_px < kSharp) return;
  const int reach = static_cast<int>(std::ceil(radius_px + 0.5));
  cv::Mat disc(2 * reach + 1, 2 * reach + 1, CV_32F);
  for (int y = -reach; y <= reach; ++y)
    for (int x = -reach; x <= reach; ++x)
      disc.at<float>(y + reach, x + reach) =
          static_cast<float>(std::clamp(radius_px + 0.5 - std::hypot(x, y), 0.0, 1.0));
  disc /= cv::sum(disc)[0];
  cv::filter2D(radiance, radiance, -1, disc, {-1, -1}, 0, cv::BORDER_REPLICATE);
}

double FocusHunt::BlurPx(double t_s) const {
  return period_s > 0 ? radius_px * 0.5 * (1 - std::cos(2 * M_PI * t_s / period_s)) : 0;
}

double FocusHunt::FocalRatio(double t_s) const {
  constexpr double kBreathes = 0.02;
  return radius_px > 0 ? 1 + kBreathes * BlurPx(t_s) / radius_px : 1;
}

void Breathe(cv::Mat& radiance, const CameraModel& camera, double focal_ratio) {
  if (focal_ratio == 1) return;
  // From the new picture to the old one; pixel centres are integers to OpenCV.
  const double cx = camera.cx - 0.5, cy = camera.cy - 0.5, back = 1 / focal_ratio;
  const cv::Matx23d old_from_new(back, 0, cx * (1 - back), 0, back, cy * (1 - back));
  cv::Mat breathed;
  cv::warpAffine(radiance, breathed, old_from_new, radiance.size(), cv::INTER_LINEAR | cv::WARP_INVERSE_MAP,
                 cv::BORDER_REPLICATE);
  radiance = breathed;
}

double LampFlicker::During(double open_s, double exposure_s, std::uint64_t seed) const {
  if (!(depth > 0)) return 1;
  const double half = M_PI * hz * exposure_s;
  const double left = half > 0 ? std::sin(half) / half : 1;
  const double phase = 2 * M_PI * SpotNumber(seed, 0, 0);
  return 1 + depth * left * std::cos(2 * M_PI * hz * (open_s + 0.5 * exposure_s) + phase);
}

cv::Mat DustSpots(const CameraModel& camera, int spots, std::uint64_t seed) {
  cv::Mat light(camera.height, camera.width, CV_32FC1, cv::Scalar(1));
  for (int spot = 1; spot <= spots; ++spot) {
    const auto within = [&](int which, double low, double high) {
      return low + (high - low) * SpotNumber(seed, spot, which);
    };
    const double x = within(1, 0.1, 0.9) * camera.width, y = within(2, 0.1, 0.9) * camera.height;
    const double radius = 0.5 * within(3, 0.01, 0.02) * camera.width, kept_off = within(4, 0.15, 0.4);
    const double soft = 0.3 * radius;
    const int reach = static_cast<int>(std::ceil(radius + 2 * soft));
    for (int v = std::max(0, static_cast<int>(y) - reach);
         v < std::min(light.rows, static_cast<int>(y) + reach); ++v)
      for (int u = std::max(0, static_cast<int>(x) - reach);
           u < std::min(light.cols, static_cast<int>(x) + reach); ++u) {
        const double edge = (std::hypot(u + 0.5 - x, v + 0.5 - y) - radius) / soft;
        light.at<float>(v, u) *= static_cast<float>(1 - kept_off * std::clamp(0.5 - 0.5 * edge, 0.0, 1.0));
      }
  }
  return light;
}

}  // namespace ulf::acquisition
