// The motion between two views from matched rays alone, with the points they triangulate: what starts a map.
//
// Two models compete: an essential matrix (OpenGV's five-point solver inside our seeded sampler) for scenes
// with depth, a homography for flat ones, where the essential matrix has a whole family of solutions. A
// rotation is fitted first: when it alone explains the matches there is no parallax, nothing can be
// triangulated, and the answer is a refusal. A homography decomposes into up to four motions; one is taken
// only when it explains clearly more points than the next. (Hartley and Zisserman, Multiple View Geometry,
// sections 9.6 and 13.4; Faugeras and Lustman 1988.) Translation has unit length. Rays are unit vectors in
// their camera; residuals are angles times the focal length, px.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "acquisition/rigid3.h"

namespace ulf {

struct RayPair {
  Eigen::Vector3d first;
  Eigen::Vector3d second;
};

struct RelativePoseOptions {
  double focal_px = 500;
  double threshold_px = 1.5;
  double min_parallax_deg = 1.0;  // median over the triangulated points
  int min_points = 60;            // triangulated, in front of both views
  double max_ambiguity =
      0.75;  // the second best motion may explain at most this share of the best one's points
  unsigned seed = 1;
};

enum class RelativePoseOutcome {
  kFound,
  kTooFewMatches,
  kRotationOnly,  // a rotation explains the matches
  kLowParallax,
  kTooFewPoints,
  kAmbiguous,  // two motions explain a flat scene about equally well
};
const char* Name(RelativePoseOutcome outcome);

enum class RelativePoseModel { kEssential, kHomography };

struct RelativePoseResult {
  RelativePoseOutcome outcome = RelativePoseOutcome::kTooFewMatches;
  RelativePoseModel model = RelativePoseModel::kEssential;
  Rigid3 second_from_first;                                     // of kFound only, as are the points
  std::vector<std::optional<Eigen::Vector3d>> points_in_first;  // by pair
  int points = 0;
  double median_parallax_deg =
      0;  // after removing the best rotation; known for every outcome with enough matches
};

RelativePoseResult RelativePose(std::span<const RayPair> pairs, const RelativePoseOptions& options = {});

// The rotation that takes the first rays nearest to the second ones, robustly.
Eigen::Quaterniond FitRotation(std::span<const RayPair> pairs, double focal_px, double threshold_px,
                               unsigned seed);

// Distance of a pair from an essential matrix (first-order geometric error on the sphere), radians.
double EpipolarError(const Eigen::Matrix3d& second_from_first_essential, const RayPair& pair);

Eigen::Matrix3d EssentialFromPose(const Rigid3& second_from_first);

}  // namespace ulf
