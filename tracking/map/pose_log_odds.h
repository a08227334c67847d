// Computes the log odds that a pose is right, from the points that were found of those that it should see.
//
// Two explanations compete in each cell of a grid over the image. If the pose is right, either as many points
// are found as their find rates say, within the spread of such counts, or something (a hand) hides the cell
// and hardly any are found. If it is wrong, points are found by chance: a small share of those that were
// searched. The evidence is the logarithm of the odds, summed over the cells. A hand that hides two thirds of
// the image costs little. If some points are found in every cell and most are missed, as under a wrong pose
// among similar things, the evidence is against the pose, however many are found.
//
// Repetitive points are found in a wrong place as well as in the right one. Without a prediction they are
// excluded from the count, found or not. On a wall of equal tiles none remain, and no pose is accepted.
#pragma once

#include <vector>

#include "core/geometry/camera_model.h"
#include "tracking/features/features.h"
#include "tracking/map/map.h"
#include "tracking/map/map_matching.h"

namespace ulf::tracking {

// Log odds that a pose must exceed: even odds with a prediction, a thousand to one by the image alone.
inline constexpr double kFollowedLogOdds = 0;
inline constexpr double kRelocalizedLogOdds = 7;

// Tells for each candidate whether it is excluded.
using ExcludedCandidates = std::vector<bool>;

// Returns the natural logarithm of the odds that the pose is right, with even odds beforehand.
double PoseLogOdds(const CameraModel& camera, const FramePose& frame_pose,
                   const ExcludedCandidates& left_out = {});

// Also excludes candidates that look like other features of the image, or like other points in view.
void ExcludeAmbiguousMatches(const CameraModel& camera, const FeatureSet& picture,
                             const FramePose& frame_pose, ExcludedCandidates& left_out);
// Also excludes candidates that look like points that this keyframe, of another place, shows. Points nearer
// than `apart_share` of the distance (guessed) are second copies. The caller holds the map's lock.
void ExcludeAmbiguousMatches(const Map& map, int keyframe, const FramePose& frame_pose,
                             ExcludedCandidates& left_out, double apart_share = 0.05);

}  // namespace ulf::tracking
