#include "core/light_field/formats/fitted_lens.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <utility>

#include "core/base/counted.h"
#include "core/base/error.h"

namespace ulf {
namespace {

// Returns the formula where its image points move away from the axis with the ray: a polynomial turns back
// somewhere, and no lens does.
Projection WhereItGrows(const Projection& project) {
  return [&project](const Eigen::Vector3d& ray) -> std::optional<Eigen::Vector2d> {
    constexpr int kSteps = 8;
    const auto axis = project(Eigen::Vector3d::UnitZ());
    const double angle = std::atan2(ray.head<2>().norm(), ray.z());
    if (!axis || !(angle > 0)) return axis;
    const Eigen::Vector2d across = ray.head<2>().normalized();
    double before = 0;
    std::optional<Eigen::Vector2d> img;
    for (int step = 1; step <= kSteps; ++step) {
      const double part = angle * step / kSteps;
      img = project({std::sin(part) * across.x(), std::sin(part) * across.y(), std::cos(part)});
      if (!img || !((*img - *axis).norm() > before)) return std::nullopt;
      before = (*img - *axis).norm();
    }
    return img;
  };
}

// Returns how far a camera moves any pixel of the lens; infinite if it does not show all of the picture, or
// the lens does not. Rays are laid by a camera without distortion.
double LargestMovePx(const Projection& project, const CameraModel& straight, const CameraModel& camera) {
  constexpr int kAcross = 48, kCells = 8;  // rays and cells of the picture on each side
  constexpr double kAround = 1.0;          // share of the picture beyond its sides
  constexpr double kNotShown = std::numeric_limits<double>::infinity();
  double largest = 0;
  std::set<std::pair<int, int>> reached;
  for (int row = 0; row <= kAcross; ++row)
    for (int column = 0; column <= kAcross; ++column) {
      const auto at = [&](int i, int side) {
        return side * (-0.5 * kAround + (1 + kAround) * static_cast<double>(i) / kAcross);
      };
      const auto ray = straight.RayFromImg({at(column, straight.width), at(row, straight.height)});
      const auto img = ray ? project(*ray) : std::nullopt;
      if (!img || !img->allFinite() || !straight.Contains(*img)) continue;
      const auto ours = camera.ImgFromCam(*ray);
      if (!ours) return kNotShown;
      largest = std::max(largest, (*ours - *img).norm());
      reached.emplace(static_cast<int>(kCells * img->x() / straight.width),
                      static_cast<int>(kCells * img->y() / straight.height));
    }
  return reached.size() == kCells * kCells ? largest : kNotShown;
}

}  // namespace

CameraModel FittedLenses::Take(const Projection& formula, const CameraModel& start, const std::string& lens,
                               const std::string& where, const std::string& remedy) {
  constexpr double kUnseen_px = 0.02;  // a tenth of what features are found to
  constexpr double kMost_px = 2;       // guessed: beyond, poses and photographs no longer fit
  const Projection project = WhereItGrows(formula);
  CameraModel straight = start;
  straight.coefficients = {};
  if (LargestMovePx(project, straight, start) <= kUnseen_px) return start;
  const CameraModel fitted = FitCamera(project, straight).camera;
  const double largest_px = LargestMovePx(project, straight, fitted);
  if (!(largest_px <= kMost_px))
    throw Error("{}: {} is not one of ours, and the nearest that we have {}; {}", where, lens,
                std::isfinite(largest_px) ? fmt::format("moves pixels by {:.3g} px", largest_px)
                                          : std::string("does not show all of the picture"),
                remedy);
  if (largest_px > kUnseen_px) {
    Fits& fits = fits_[lens];
    ++fits.cameras;
    fits.largest_px = std::max(fits.largest_px, largest_px);
  }
  return fitted;
}

void FittedLenses::Note(std::vector<std::string>& doubts) const {
  for (const auto& [lens, fits] : fits_)
    doubts.push_back(fmt::format("{} is taken into our model for {}: no pixel moves by more than {:.2g} px",
                                 lens, Counted(fits.cameras, "camera"), fits.largest_px));
}

}  // namespace ulf
