#include "core/geometry/camera_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace ulf {
namespace {

using Vector9d = Eigen::Matrix<double, 9, 1>;
using Matrix9d = Eigen::Matrix<double, 9, 9>;

struct ShownRay {
  Eigen::Vector3d ray_in_cam;
  Eigen::Vector2d img;
};

// Returns rays that the lens images within the picture.
std::vector<ShownRay> RaysOver(const Projection& project, const CameraModel& start) {
  constexpr int kAcross = 40;  // on each side
  constexpr double kAround = 0.5;
  std::vector<ShownRay> rays;
  for (int row = 0; row <= kAcross; ++row)
    for (int column = 0; column <= kAcross; ++column) {
      const auto at = [&](int i, int side) {
        return side * (-0.5 * kAround + (1 + kAround) * static_cast<double>(i) / kAcross);
      };
      const auto ray = start.RayFromImg({at(column, start.width), at(row, start.height)});
      const auto img = ray ? project(*ray) : std::nullopt;
      if (img && img->allFinite() && start.Contains(*img)) rays.push_back({*ray, *img});
    }
  return rays;
}

// Returns how far the model shows a ray from where the lens does. A ray that it cannot show is a picture off.
CameraFit Compare(const std::vector<ShownRay>& rays, const CameraModel& camera) {
  CameraFit fit{.camera = camera};
  double squares = 0;
  for (const ShownRay& shown : rays) {
    const auto img = camera.ImgFromCam(shown.ray_in_cam);
    const double distance = img ? (*img - shown.img).norm() : std::hypot(camera.width, camera.height);
    squares += distance * distance;
    fit.largest_px = std::max(fit.largest_px, distance);
  }
  if (!rays.empty()) fit.rms_px = std::sqrt(squares / static_cast<double>(rays.size()));
  return fit;
}

std::array<double*, 9> ParametersOf(CameraModel& camera) {
  auto& c = camera.coefficients;
  return {&camera.fx, &camera.fy, &camera.cx, &camera.cy, &c[0], &c[1], &c[2], &c[3], &c[4]};
}

// Returns how many of ParametersOf() a kind of lens has.
int FreeParameters(Distortion distortion) {
  switch (distortion) {
    case Distortion::kNone:
      return 4;
    case Distortion::kRadialTangential:
      return 9;
    case Distortion::kFisheye:
      return 8;
  }
  return 4;
}

}  // namespace

CameraFit FitCamera(const Projection& project, const CameraModel& start) {
  const std::vector<ShownRay> rays = RaysOver(project, start);
  const int free = FreeParameters(start.distortion);
  CameraFit best = Compare(rays, start);
  double damping = 1e-9;
  constexpr int kMostSteps = 60;
  constexpr double kSettled = 1e-9;  // relative gain
  for (int step = 0; step < kMostSteps; ++step) {
    Matrix9d normal = Matrix9d::Zero();
    Vector9d right = Vector9d::Zero();
    for (const ShownRay& shown : rays) {
      Eigen::Matrix<double, 2, 3> by_point;
      Eigen::Matrix<double, 2, 9> by_parameters;
      const auto img = best.camera.ImgFromCam(shown.ray_in_cam, &by_point, &by_parameters);
      if (!img) continue;
      normal += by_parameters.transpose() * by_parameters;
      right += by_parameters.transpose() * (shown.img - *img);
    }
    for (int i = 0; i < 9; ++i) {
      normal(i, i) *= 1 + damping;
      if (i < free && normal(i, i) > 0) continue;
      normal.row(i).setZero();
      normal.col(i).setZero();
      normal(i, i) = 1;
      right(i) = 0;
    }
    const Vector9d change = normal.ldlt().solve(right);
    CameraModel moved = best.camera;
    const auto parameters = ParametersOf(moved);
    for (std::size_t i = 0; i < parameters.size(); ++i)
      *parameters[i] += change(static_cast<Eigen::Index>(i));
    const CameraFit next = Compare(rays, moved);
    if (!change.allFinite() || !(next.rms_px < best.rms_px)) {
      damping = std::max(damping, 1e-9) * 100;
      if (damping > 1e6) break;
      continue;
    }
    const double gain = best.rms_px - next.rms_px;
    best = next;
    damping /= 10;
    if (gain < kSettled * best.rms_px) break;
  }
  return best;
}

CameraFit CompareCamera(const Projection& project, const CameraModel& camera) {
  return Compare(RaysOver(project, camera), camera);
}

}  // namespace ulf
