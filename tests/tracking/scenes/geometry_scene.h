// Point scenes with exact truth for the pure geometry: every draw by seed.
#pragma once

#include <cmath>
#include <random>
#include <vector>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "tests/support/floors.h"
#include "tracking/estimation/absolute_pose.h"
#include "tracking/estimation/relative_pose.h"

namespace ulf::test {

inline CameraModel SceneCamera() {
  return CameraModel::FromOpenCv(640, 480, 525, 524, 321, 239, Distortion::kRadialTangential,
                                 {-0.12, 0.05, 0.0005, -0.0004, 0});
}

class Draw {
 public:
  explicit Draw(unsigned seed) : random_(seed) {}
  double Uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(random_()) / 4294967295.0;
  }
  double Normal(double sigma) {
    const double u = Uniform(1e-12, 1), v = Uniform(0, 1);
    return sigma * std::sqrt(-2 * std::log(u)) * std::cos(2 * M_PI * v);
  }
  Eigen::Vector3d Direction() { return Eigen::Vector3d(Normal(1), Normal(1), Normal(1)).normalized(); }

 private:
  std::mt19937 random_;
};

inline Rigid3 RandomPose(Draw& draw, double max_angle, double max_shift) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(draw.Uniform(0, max_angle), draw.Direction())),
          draw.Uniform(0, max_shift) * draw.Direction()};
}

struct AbsoluteScene {
  Rigid3 cam_from_world;
  std::vector<PointObservation> matches;
};

inline AbsoluteScene MakeAbsoluteScene(int count, double noise_px, double outliers, unsigned seed) {
  Draw draw(seed);
  const CameraModel camera = SceneCamera();
  AbsoluteScene scene;
  scene.cam_from_world = RandomPose(draw, 2.5, 3);
  const Rigid3 world_from_cam = scene.cam_from_world.Inverse();
  while (static_cast<int>(scene.matches.size()) < count) {
    const Eigen::Vector3d in_cam(draw.Uniform(-3, 3), draw.Uniform(-2.5, 2.5), draw.Uniform(2, 8));
    const auto img = camera.ImgFromCam(in_cam);
    if (!img || !camera.Contains(*img)) continue;
    PointObservation seen{world_from_cam * in_cam, *img, std::max(noise_px, 0.1)};
    seen.img += Eigen::Vector2d(draw.Normal(noise_px), draw.Normal(noise_px));
    if (draw.Uniform(0, 1) < outliers) seen.img = {draw.Uniform(0, 640), draw.Uniform(0, 480)};
    scene.matches.push_back(seen);
  }
  return scene;
}

enum class Shape { kDeep, kFlat };

struct RelativeScene {
  Rigid3 second_from_first;
  std::vector<RayPair> pairs;
};

inline RelativeScene MakeRelativeScene(int count, Shape shape, double baseline, double noise_px,
                                       double outliers, unsigned seed) {
  Draw draw(seed);
  const CameraModel camera = SceneCamera();
  RelativeScene scene;
  Eigen::Vector3d direction = draw.Direction();
  direction.z() *= 0.5;
  scene.second_from_first = {Eigen::Quaterniond(Eigen::AngleAxisd(draw.Uniform(0.02, 0.2), draw.Direction())),
                             baseline * direction.normalized()};
  const Eigen::Vector3d normal =
      Eigen::Vector3d(draw.Uniform(-0.5, 0.5), draw.Uniform(-0.5, 0.5), 1).normalized();
  while (static_cast<int>(scene.pairs.size()) < count) {
    const Eigen::Vector2d img(draw.Uniform(0, 640), draw.Uniform(0, 480));
    const Eigen::Vector3d ray = *camera.RayFromImg(img);
    const double depth = shape == Shape::kFlat ? 4 * normal.z() / normal.dot(ray) : draw.Uniform(2, 7);
    const auto second = camera.ImgFromCam(scene.second_from_first * (depth * ray));
    if (!second || !camera.Contains(*second)) continue;
    const auto jitter = [&] { return Eigen::Vector2d(draw.Normal(noise_px), draw.Normal(noise_px)); };
    Eigen::Vector2d seen = *second + jitter();
    if (draw.Uniform(0, 1) < outliers) seen = {draw.Uniform(0, 640), draw.Uniform(0, 480)};
    const auto first_ray = camera.RayFromImg(img + jitter()), second_ray = camera.RayFromImg(seen);
    if (first_ray && second_ray) scene.pairs.push_back({*first_ray, *second_ray});
  }
  return scene;
}

inline double DegreesBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / M_PI;
}

inline double DegreesBetween(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  return RotationAngle(a * b.conjugate()) * 180 / M_PI;
}

}  // namespace ulf::test
