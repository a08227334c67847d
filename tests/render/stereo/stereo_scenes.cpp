#include "tests/render/stereo/stereo_scenes.h"
#include "tests/support/floors.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace ulf::test {

using Eigen::Vector3d;

std::function<float(double, double)> Mottled(double finest, unsigned seed) {
  struct Wave {
    double a, b, phase;
  };
  std::vector<Wave> waves;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> any(0, 2 * M_PI), scale(0.15, 1);
  for (int i = 0; i < 24; ++i) {
    const double angle = any(random), frequency = 2 * M_PI * scale(random) / finest;
    waves.push_back({frequency * std::cos(angle), frequency * std::sin(angle), any(random)});
  }
  return [waves](double u, double v) {
    double sum = 0;
    for (const Wave& wave : waves) sum += std::sin(wave.a * u + wave.b * v + wave.phase);
    return std::clamp(static_cast<float>(127 + 16 * sum), 0.0f, 255.0f);
  };
}

std::function<float(double, double)> Plain(float grey) {
  return [grey](double, double) { return grey; };
}

Drawn Draw(const std::vector<Patch>& patches, const Vector3d& center, const Vector3d& target, int width,
           int height, double focal_px, float gain, float offset) {
  Drawn drawn;
  drawn.view.camera = CameraModel::Pinhole(width, height, focal_px);
  drawn.view.cam_from_world = LookAt(center, target, Vector3d::UnitY());
  drawn.view.center_in_world = center;
  drawn.view.grey = cv::Mat(height, width, CV_32F, cv::Scalar(0));
  drawn.depth = cv::Mat::zeros(height, width, CV_32F);
  const Rigid3 world_from_cam = drawn.view.cam_from_world.Inverse();
  // What turns a point of a patch's plane into its coordinates on the patch.
  struct OnPatch {
    const Patch* patch;
    Vector3d normal, along_side, along_other;
    double distance;  // of the plane, along the normal
  };
  std::vector<OnPatch> planes;
  for (const Patch& patch : patches) {
    const Vector3d normal = patch.side.cross(patch.other_side);
    planes.push_back({&patch, normal, patch.other_side.cross(normal) / normal.squaredNorm(),
                      normal.cross(patch.side) / normal.squaredNorm(), normal.dot(patch.corner - center)});
  }
  // Grey and depth of the nearest patch; the depth is along the axis, because rays have a z of 1.
  const auto look = [&](double x, double y) {
    const Vector3d ray = world_from_cam.rotation * Vector3d((x - drawn.view.camera.cx) / focal_px,
                                                            (y - drawn.view.camera.cy) / focal_px, 1);
    std::pair<float, double> nearest{0, std::numeric_limits<double>::infinity()};
    for (const OnPatch& plane : planes) {
      const double depth = plane.distance / plane.normal.dot(ray);
      if (!(depth > 0 && depth < nearest.second)) continue;
      const Vector3d from_corner = center + depth * ray - plane.patch->corner;
      const double u = plane.along_side.dot(from_corner), v = plane.along_other.dot(from_corner);
      if (u < 0 || u > 1 || v < 0 || v > 1) continue;
      nearest = {plane.patch->grey(u, v), depth};
    }
    return nearest;
  };
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      float grey = 0;
      for (const auto& [dx, dy] : {std::pair{0.25, 0.25}, {0.75, 0.25}, {0.25, 0.75}, {0.75, 0.75}})
        grey += look(x + dx, y + dy).first / 4;
      drawn.view.grey.at<float>(y, x) = gain * grey + offset;
      const double depth = look(x + 0.5, y + 0.5).second;
      if (std::isfinite(depth)) drawn.depth.at<float>(y, x) = static_cast<float>(depth);
    }
  return drawn;
}

}  // namespace ulf::test
