#include "coverage/session/subject/subject_finder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace ulf::coverage {

std::optional<double> DepthNearCenter(const std::vector<tracking::VisiblePoint>& points,
                                      const CameraModel& camera) {
  constexpr double kReach = 0.25;  // of the image's height
  constexpr std::size_t kFewest = 8;
  const Eigen::Vector2d middle(0.5 * camera.width, 0.5 * camera.height);
  std::vector<double> depths;
  for (const tracking::VisiblePoint& point : points)
    if ((point.img - middle).norm() < kReach * camera.height && point.depth > 0)
      depths.push_back(point.depth);
  if (depths.size() < kFewest) return std::nullopt;
  std::sort(depths.begin(), depths.end());
  const std::size_t from = depths.size() / 4, to = depths.size() - from;
  double sum = 0;
  for (std::size_t i = from; i < to; ++i) sum += depths[i];
  return sum / static_cast<double>(to - from);
}

std::string ProblemOf(const Subject& subject, const std::optional<Rigid3>& cam_from_world) {
  if (!(subject.radius > 0) || !std::isfinite(subject.radius) || !subject.center_in_world.allFinite())
    return fmt::format(
        "a subject needs a radius above 0 and a centre of numbers, not radius {:g}; write "
        "x,y,z,radius in world units",
        subject.radius);
  if (!cam_from_world) return {};
  const Eigen::Vector3d center_in_cam = *cam_from_world * subject.center_in_world;
  if (center_in_cam.norm() <= subject.radius)
    return fmt::format(
        "the camera is inside that sphere (its centre is {:.3g} away, its radius {:.3g}); give a "
        "smaller radius or step back",
        center_in_cam.norm(), subject.radius);
  if (center_in_cam.z() <= 0)
    return "that subject is behind the camera; turn the camera towards it first, or correct the numbers";
  return {};
}

}  // namespace ulf::coverage
