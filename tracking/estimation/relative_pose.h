// Estimates the motion between two views, and the points, from matched rays alone: this starts a map.
//
// Two models are fitted: an essential matrix for scenes with depth (OpenGV's five-point solver inside the
// seeded sampler; OpenGV's RANSAC needs eight points a sample and never improves a model), and a homography
// for flat scenes, where five points have a whole family of solutions. A rotation is fitted first: when it
// alone explains the matches there is no parallax, and the result is a refusal. All motions that either model
// suggests, and a fan of others, are refined on the same epipolar error. The best one is accepted only when
// no clearly different motion explains the matches about as well and its direction is well determined; short
// baselines and planes with two solutions are refused. (Hartley and Zisserman, Multiple View Geometry,
// sections 9.6 and 13.4; Faugeras and Lustman 1988.) The translation has unit length. Rays are unit vectors
// in their camera; residuals are angles times the focal length, px.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "core/geometry/rigid3.h"
#include "tracking/estimation/two_view_motion.h"

namespace ulf::tracking {

struct RelativePoseOptions {
  double focal_px = 500;
  double threshold_px = 1.5;
  double min_parallax_deg = 0.8;  // median over the triangulated points
  double min_point_share = 0;     // triangulated, of all pairs
  unsigned seed = 1;
};

enum class RelativePoseOutcome {
  kFound,
  kTooFewMatches,
  kRotationOnly,  // a rotation explains the matches
  kLowParallax,
  kTooFewPoints,
  kAmbiguous,    // two motions explain the matches about equally well
  kConflicting,  // too many of the matches follow another motion than the best
};
const char* Name(RelativePoseOutcome outcome);

enum class RelativePoseModel { kEssential, kHomography };

// Describes how many of the matches each model explains, and the evidence for the choice between motions.
struct MotionEvidence {
  int matches = 0, by_rotation = 0, by_homography = 0, by_essential = 0;
  double runner_up = 0, runner_up_needed = 0;  // excess cost of the best different motion, in noise variances
};

struct RelativePoseResult {
  RelativePoseOutcome outcome = RelativePoseOutcome::kTooFewMatches;
  RelativePoseModel model = RelativePoseModel::kEssential;
  Rigid3 second_from_first;                                     // of kFound only, as are the points
  std::vector<std::optional<Eigen::Vector3d>> points_in_first;  // by pair
  int points = 0;                                               // that were triangulated
  double direction_sigma_deg = 0;  // one standard deviation of the translation's direction
  MotionEvidence evidence;
  // The median parallax, for every outcome with enough matches: beside the best rotation, or of the points.
  double median_parallax_deg = 0;
  // The parallax that would suffice, as far as this pair of views tells.
  double parallax_needed_deg = 0;
};

RelativePoseResult RelativePose(std::span<const RayPair> pairs, const RelativePoseOptions& options = {});

// Returns the rotation that takes the first rays nearest to the second ones, robustly.
Eigen::Quaterniond FitRotation(std::span<const RayPair> pairs, double focal_px, double threshold_px,
                               unsigned seed);

}  // namespace ulf::tracking
