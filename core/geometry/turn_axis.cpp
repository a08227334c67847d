#include "core/geometry/turn_axis.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "core/geometry/angles.h"
#include "core/geometry/small_matrices.h"

namespace ulf {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Guessed: a board's pose is about 0.2 degrees and 0.2 % of the distance off where few of its markers show.
constexpr double kLeastTurn = Radians(8);  // between two poses that determine the axis
constexpr int kComparedPoses = 40;         // a pose is compared with this many later ones
constexpr double kSameDirection = Radians(1), kSamePlaceShare = 0.012;  // of the distance
constexpr double kLeastAgreeing = 0.15;  // of the pairs; others are of two stands, or of a carried camera

constexpr double kMostTurn = Radians(170);  // near half a turn the axis' direction is ambiguous
constexpr std::size_t kMostGuesses = 200, kFewestPairs = 3;

// The world's motion between two poses: a world point at `from` has moved to rotation * from + shift.
struct Turn {
  Matrix3d rotation;
  Vector3d shift, axis;  // axis: unit
  double weight;         // certainty of the axis
  double distance;       // of the cameras from the world's origin
};

std::vector<Turn> TurnsBetween(std::span<const Rigid3> poses) {
  std::vector<Turn> turns;
  for (std::size_t i = 0; i < poses.size(); ++i)
    for (std::size_t j = i + 1; j < std::min(poses.size(), i + 1 + static_cast<std::size_t>(kComparedPoses));
         ++j) {
      const Rigid3 motion = poses[i].Inverse() * poses[j];
      const double angle = RotationAngle(motion.rotation);
      if (angle < kLeastTurn || angle > kMostTurn) continue;
      const Eigen::AngleAxisd turn(motion.rotation);
      turns.push_back({motion.RotationMatrix(), motion.translation, turn.axis(), std::sin(0.5 * angle),
                       poses[i].OriginInSource().norm()});
    }
  return turns;
}

// Returns the point nearest to the origin on the common axis of these motions; `axis` keeps it from sliding.
Vector3d PointOn(const Vector3d& axis, std::span<const Turn* const> turns) {
  Matrix3d normal = axis * axis.transpose();
  Vector3d right = Vector3d::Zero();
  for (const Turn* turn : turns) {
    const Matrix3d a = Matrix3d::Identity() - turn->rotation;
    normal += a.transpose() * a;
    right += a.transpose() * turn->shift;
  }
  const Vector3d point = SolveNormal(normal, right);
  return point - axis.dot(point) * axis;
}

bool Agrees(const Turn& turn, const Vector3d& axis, const Vector3d& point) {
  return std::abs(turn.axis.dot(axis)) > std::cos(kSameDirection / std::min(1.0, 2 * turn.weight)) &&
         (turn.rotation * point + turn.shift - point).norm() < kSamePlaceShare * turn.distance;
}

TurnAxis FitTo(std::span<const Turn* const> turns) {
  Matrix3d scatter = Matrix3d::Zero();
  for (const Turn* turn : turns) scatter += turn->weight * turn->axis * turn->axis.transpose();
  const Vector3d axis = EigenvaluesOf(scatter).vectors.col(2);
  return {PointOn(axis, turns), axis};
}

std::vector<const Turn*> Agreeing(const std::vector<Turn>& turns, const TurnAxis& axis) {
  std::vector<const Turn*> agreeing;
  for (const Turn& turn : turns)
    if (Agrees(turn, axis.direction_in_world, axis.point_in_world)) agreeing.push_back(&turn);
  return agreeing;
}

// Returns whether a shift is within `times` the variation inside one stand.
bool IsWithin(const StandShift& shift, double times) {
  return shift.direction < times * kSameDirection && shift.place_share < times * kSamePlaceShare;
}

}  // namespace

std::optional<TurnAxis> FitTurnAxis(std::span<const Rigid3> cam_from_world) {
  const std::vector<Turn> turns = TurnsBetween(cam_from_world);
  const auto enough = std::max<std::size_t>(
      kFewestPairs, static_cast<std::size_t>(kLeastAgreeing * static_cast<double>(turns.size())));
  std::vector<const Turn*> most;
  const std::size_t step = std::max<std::size_t>(1, turns.size() / kMostGuesses);
  for (std::size_t i = 0; i < turns.size(); i += step) {
    const Turn* one = &turns[i];
    auto agreeing = Agreeing(turns, FitTo({&one, 1}));
    if (agreeing.size() > most.size()) most = std::move(agreeing);
  }
  if (most.size() < enough) return std::nullopt;
  TurnAxis axis = FitTo(most);
  constexpr int kRounds = 2;
  for (int i = 0; i < kRounds; ++i) {
    most = Agreeing(turns, axis);
    if (most.size() < enough) return std::nullopt;
    axis = FitTo(most);
  }
  return axis;
}

StandShift ShiftBetween(const TurnAxis& axis, const Rigid3& a_from_world, const Rigid3& b_from_world) {
  const Vector3d in_a = a_from_world * axis.point_in_world, in_b = b_from_world * axis.point_in_world;
  const Vector3d along_a = a_from_world.rotation * axis.direction_in_world,
                 along_b = b_from_world.rotation * axis.direction_in_world;
  return {std::atan2(along_a.cross(along_b).norm(), along_a.dot(along_b)),
          (in_a - in_b).norm() / in_a.norm()};
}

bool IsSameStand(const StandShift& shift) { return IsWithin(shift, 1); }

std::vector<int> StandsOf(const TurnAxis& axis, std::span<const Rigid3> cam_from_world) {
  std::vector<int> stands;
  int stand = -1;
  std::size_t first = 0;  // of the stand's first pose
  for (std::size_t i = 0; i < cam_from_world.size(); ++i) {
    // A single wrong pose must not end a stand, so the middle one represents it.
    const std::size_t middle = first + (i - first) / 2;
    const StandShift shift = ShiftBetween(axis, cam_from_world[middle], cam_from_world[i]);
    const bool same = i > 0 && (IsSameStand(shift) ||
                                IsSameStand(ShiftBetween(axis, cam_from_world[i - 1], cam_from_world[i])));
    const bool crept = same && !IsWithin(shift, 2);
    if (!same || crept) {
      ++stand;
      first = i;
    }
    stands.push_back(stand);
  }
  return stands;
}

}  // namespace ulf
