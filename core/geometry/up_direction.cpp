#include "core/geometry/up_direction.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/geometry/angles.h"
#include "core/geometry/small_matrices.h"

namespace ulf {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Guessed, and settled on drawn sets of all shapes with up to 7 of 12 photographs turned.
constexpr double kTilted = 0.12;           // sine of the tilt at which a camera has lost most of its weight
constexpr double kUprightWeight = 0.5;     // of a camera's up axis along up, against one camera's misfit
constexpr double kLevelWeight = 0.1;       // of the squared sine of a camera's pitch, likewise
constexpr double kLooksDownWeight = 0.35;  // of a look down, against an up axis upwards, for the sign
constexpr double kUsualTilt = Radians(2);  // of cameras in the hand, expected before any is known
constexpr double kUsualTiltWeight = 3;     // in cameras

struct CameraAxes {
  Vector3d right, up, forward;
};

std::vector<CameraAxes> AxesOf(std::span<const Matrix3d> cam_from_world) {
  std::vector<CameraAxes> axes;
  for (const Matrix3d& rotation : cam_from_world)
    axes.push_back({rotation.row(0), -rotation.row(1), rotation.row(2)});
  return axes;
}

// Returns at most `most` of the cameras, spread over all of them.
std::vector<CameraAxes> Some(const std::vector<CameraAxes>& cameras, std::size_t most) {
  const std::size_t count = std::min(most, cameras.size());
  std::vector<CameraAxes> some;
  for (std::size_t i = 0; i < count; ++i) some.push_back(cameras[i * cameras.size() / count]);
  return some;
}

// Returns the axis that is level if the camera was held level, or turned by any multiple of 90 degrees.
const Vector3d& LevelAxis(const CameraAxes& camera, const Vector3d& up) {
  return std::abs(camera.right.dot(up)) < std::abs(camera.up.dot(up)) ? camera.right : camera.up;
}

double SquaredTilt(const CameraAxes& camera, const Vector3d& up) {
  const double tilt = LevelAxis(camera, up).dot(up) / kTilted;
  return tilt * tilt;
}

// Returns how badly a direction or its opposite explains the cameras as upright, level and without tilt.
// Round a subject on one level, turned cameras would do as well with another up, far below and above
// themselves.
double CostOf(const Vector3d& up, const std::vector<CameraAxes>& cameras) {
  double cost = 0, upright = 0;
  for (const CameraAxes& camera : cameras) {
    const double squared = SquaredTilt(camera, up), pitch = camera.forward.dot(up);
    cost += squared / (1 + squared) + kLevelWeight * pitch * pitch;
    upright += camera.up.dot(up);
  }
  return cost - kUprightWeight * std::abs(upright);
}

// Returns the cameras' axes and the directions at right angles to those of two cameras.
std::vector<Vector3d> Candidates(const std::vector<CameraAxes>& cameras) {
  constexpr double kLeastSine = 0.1;
  std::vector<Vector3d> candidates;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    for (const Vector3d& axis : {cameras[i].up, cameras[i].right, cameras[i].forward})
      candidates.push_back(axis);
    for (std::size_t j = i + 1; j < cameras.size(); ++j)
      for (const Vector3d& a : {cameras[i].right, cameras[i].up})
        for (const Vector3d& b : {cameras[j].right, cameras[j].up})
          if (const Vector3d across = a.cross(b); across.norm() > kLeastSine)
            candidates.push_back(across.normalized());
  }
  return candidates;
}

Vector3d BestCandidate(const std::vector<CameraAxes>& cameras) {
  constexpr std::size_t kPaired = 10, kAsked = 40;
  const std::vector<CameraAxes> asked = Some(cameras, kAsked);
  Vector3d best = -Vector3d::UnitY();
  double least = std::numeric_limits<double>::infinity();
  for (const Vector3d& candidate : Candidates(Some(cameras, kPaired)))
    if (const double cost = CostOf(candidate, asked); cost < least) {
      least = cost;
      best = candidate;
    }
  return best;
}

// The scatter of the level axes about the direction at right angles to them, and how certain it is.
struct LevelAxes {
  Matrix3d scatter = Matrix3d::Zero();
  double cameras = 0;

  double MisfitOf(const Vector3d& up) const { return up.dot(scatter * up); }
  // Returns the direction with the least misfit, to which `weight` adds the square of its part along `axis`.
  Vector3d Across(const Vector3d& axis, double weight) const {
    return EigenvaluesOf(scatter + weight * axis * axis.transpose()).vectors.col(0);
  }
};

LevelAxes LevelAxesOf(const std::vector<CameraAxes>& cameras, const Vector3d& up) {
  LevelAxes level;
  for (const CameraAxes& camera : cameras) {
    const Vector3d& axis = LevelAxis(camera, up);
    const double not_tilted = 1 / (1 + SquaredTilt(camera, up));
    level.scatter += not_tilted * not_tilted * axis * axis.transpose();
  }
  level.cameras = static_cast<double>(cameras.size());
  return level;
}

// Returns the direction at right angles to the axes, without a pitch of the cameras that their spread does
// not prove. `ahead` is the axis along which most cameras look.
Vector3d Fitted(const LevelAxes& level, const Vector3d& ahead) {
  constexpr double kNearlyNone = 1e-9, kNearlyAll = 1e6;
  constexpr double kProven = 9;  // variances that the misfit of a level view must exceed. Guessed.
  // Times the axes' noise, of their spread: below, the direction across them is chance. Settled on drawn
  // grids before a wall and narrow arcs.
  constexpr double kSpread = 6;
  const Vector3d free = level.Across(ahead, kNearlyNone);
  Vector3d straight = level.Across(ahead, kNearlyAll * level.cameras);
  if (straight.dot(free) < 0) straight = -straight;
  const double variance = (level.MisfitOf(free) + kUsualTiltWeight * kUsualTilt * kUsualTilt) /
                          (level.cameras + kUsualTiltWeight);
  const double gain = (level.MisfitOf(straight) - level.MisfitOf(free)) / variance;
  const double spread = EigenvaluesOf(level.scatter).values(1) / level.cameras / variance;
  if (!(gain > 0 && spread > 0)) return straight;
  const double share = 1 / (1 + std::pow(kProven / gain, 2) + std::pow(kSpread / spread, 6));
  return ((1 - share) * straight + share * free).normalized();
}

bool PointsDown(const Vector3d& up, const std::vector<CameraAxes>& cameras) {
  double upwards = 0;
  for (const CameraAxes& camera : cameras)
    upwards += camera.up.dot(up) - kLooksDownWeight * camera.forward.dot(up);
  return upwards < 0;
}

}  // namespace

Vector3d UpOfCameras(std::span<const Matrix3d> cam_from_world) {
  constexpr int kRounds = 5;  // the axes and weights of most sets no longer change after the second
  const std::vector<CameraAxes> cameras = AxesOf(cam_from_world);
  if (cameras.empty()) return -Vector3d::UnitY();
  Matrix3d views = Matrix3d::Zero();
  for (const CameraAxes& camera : cameras) views += camera.forward * camera.forward.transpose();
  const Vector3d ahead = EigenvaluesOf(views).vectors.col(2);
  Vector3d up = BestCandidate(cameras);
  for (int round = 0; round < kRounds; ++round) up = Fitted(LevelAxesOf(cameras, up), ahead);
  return PointsDown(up, cameras) ? Vector3d(-up) : up;
}

}  // namespace ulf
