#include "commands/reports/lens_report.h"

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

// Returns the largest distance of a ray's image points in the two lenses, px.
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

constexpr double kSmallPx = 0.5;  // smaller differences do not degrade pictures. Guessed.

}  // namespace

std::string LensFitText(const tracking::LensEstimate& fit, const CameraModel& given, bool is_taken_over) {
  if (is_taken_over) return "new intrinsics: " + Described(fit);
  const double shift_px = LargestShiftPx(given, fit.lens);
  if (shift_px < kSmallPx)
    return fmt::format("the intrinsics are right within {:.1f} px; the images alone would say: {}", shift_px,
                       Described(fit));
  return "the images support other intrinsics (--intrinsics takes them over): " + Described(fit);
}

std::string LensApartText(const tracking::LensEstimate& fit, const CameraModel& given,
                          const std::string& source, bool is_taken_over) {
  constexpr double kSigmas = 3;
  const double was_px = given.MeanFocalPx(), apart_px = fit.lens.MeanFocalPx() - was_px;
  if (!fit.free.focal || std::abs(apart_px) <= kSigmas * fit.focal_sigma_px ||
      LargestShiftPx(given, fit.lens) < kSmallPx)
    return {};
  return fmt::format(
      "this focal length is {:.1f} px ({:.1f} %) {} than the {:.1f} px of before{}, farther than the "
      "deviations account for: {}",
      std::abs(apart_px), 100 * std::abs(apart_px) / was_px, apart_px > 0 ? "longer" : "shorter", was_px,
      source.empty() ? "" : " (from: " + source + ")",
      is_taken_over ? "the new one is kept, because all views together fit it better"
                    : "the one of before is kept, because --intrinsics was not given");
}

std::string LensSigmaWords(FrameSource source) {
  const std::string left_out =
      "± counts the noise of points alone: what a rolling shutter, blur and the lens model add is not in it";
  return IsTaken(source) ? left_out : left_out + "; ulf calibrate with a printed board knows better";
}

}  // namespace ulf::commands
