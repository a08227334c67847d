#include "commands/tracking/lens_report.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace ulf::commands {
namespace {

std::string Described(const tracking::LensEstimate& fit) {
  std::string text = fmt::format("focal length {:.2f} px", fit.lens.MeanFocalPx());
  if (fit.free.focal) text += fmt::format(" (± {:.2f})", fit.focal_sigma_px);
  if (fit.free.k1) text += fmt::format(", k1 {:.4f} (± {:.4f})", fit.lens.coefficients[0], fit.k1_sigma);
  if (fit.free.k2) text += fmt::format(", k2 {:.4f} (± {:.4f})", fit.lens.coefficients[1], fit.k2_sigma);
  if (fit.free.principal_point)
    text += fmt::format(", principal point {:.2f} {:.2f} px (± {:.2f})", fit.lens.cx, fit.lens.cy,
                        fit.principal_point_sigma_px);
  return text;
}

// By which the two show a ray at different places of the image.
double LargestShiftPx(const CameraModel& a, const CameraModel& b) {
  constexpr int kSteps = 8;
  double largest = a.width == b.width && a.height == b.height ? 0 : INFINITY;
  for (int y = 0; y <= kSteps; ++y)
    for (int x = 0; x <= kSteps; ++x) {
      const Eigen::Vector2d img(1.0 * x * a.width / kSteps, 1.0 * y * a.height / kSteps);
      const auto ray = a.RayFromImg(img);
      const auto shown = ray ? b.ImgFromCam(*ray) : std::nullopt;
      largest = std::max(largest, shown ? (*shown - img).norm() : INFINITY);
    }
  return largest;
}

}  // namespace

std::string LensFitText(const tracking::LensEstimate& fit, std::span<const CameraModel> cameras,
                        bool is_taken_over) {
  if (is_taken_over) return "new intrinsics: " + Described(fit);
  double shift_px = INFINITY;
  for (const CameraModel& camera : cameras) shift_px = std::min(shift_px, LargestShiftPx(camera, fit.lens));
  constexpr double kSmallPx = 0.5;  // less than what makes a picture worse. Guessed.
  if (shift_px < kSmallPx)
    return fmt::format("the intrinsics are right within {:.1f} px; the images alone would say: {}", shift_px,
                       Described(fit));
  return "the images support other intrinsics (--intrinsics takes them over): " + Described(fit);
}

}  // namespace ulf::commands
