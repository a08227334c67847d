// Estimates the motion between two views, and the points that both see, from matched rays alone: this starts
// a map. (Hartley and Zisserman, Multiple View Geometry, sections 9.6 and 13.4; Faugeras and Lustman 1988.)
//
// A rotation is fitted first: if it alone explains the matches there is no parallax, and no motion is found.
// Then two models are fitted: an essential matrix for scenes with depth (five-point solver), and a homography
// for flat scenes, in which five points have a whole family of solutions. All motions that either model
// suggests, and a fan of others, are refined on the same epipolar error. The best one is accepted only if no
// clearly different motion explains the matches about as well and its direction is well determined; short
// baselines and planes with two solutions are refused. Residuals are angles times the focal length, px.
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
  double threshold_px = 1.5;      // largest epipolar error of an inlier
  double min_parallax_deg = 0.8;  // of the median over the triangulated points
  double min_point_share = 0;     // of the pairs, that must be triangulated
  unsigned seed = 1;
};

enum class RelativePoseOutcome {
  kFound,
  kTooFewMatches,  // fewer than 20, or fewer than 20 agree with any motion
  kRotationOnly,   // a rotation explains the matches
  kLowParallax,    // or the translation's direction is too uncertain
  kTooFewPoints,   // fewer than 60 points were triangulated
  kAmbiguous,      // two motions explain the matches about equally well
  kConflicting,    // too many of the matches follow another motion than the best
};
const char* Name(RelativePoseOutcome outcome);  // "too few matches", for people

enum class RelativePoseModel { kEssential, kHomography };

// Tells how many of the matches each model explains, and by how much the cost of the best clearly different
// motion is higher and must be, in variances of the noise.
struct MotionEvidence {
  int matches = 0, by_rotation = 0, by_homography = 0, by_essential = 0;
  double runner_up = 0, runner_up_needed = 0;
};

struct RelativePoseResult {
  RelativePoseOutcome outcome = RelativePoseOutcome::kTooFewMatches;
  RelativePoseModel model = RelativePoseModel::kEssential;  // kHomography: the scene is flat
  // Set for kFound alone: the motion with a translation of length 1, and the points by pair; none where rays
  // do not meet before both cameras.
  Rigid3 second_from_first;
  std::vector<std::optional<Eigen::Vector3d>> points_in_first;
  int points = 0;                  // number of triangulated points
  double direction_sigma_deg = 0;  // one standard deviation of the translation's direction
  MotionEvidence evidence;
  // The median parallax of the points or, without points, what the best rotation leaves of it.
  double median_parallax_deg = 0;
  double parallax_needed_deg = 0;  // that would suffice, as far as this pair of views tells
};

RelativePoseResult RelativePose(std::span<const RayPair> pairs, const RelativePoseOptions& options = {});

// Returns the rotation second_from_first that explains the matches best; the identity if none does.
Eigen::Quaterniond FitRotation(std::span<const RayPair> pairs, double focal_px, double threshold_px,
                               unsigned seed);

}  // namespace ulf::tracking
