// Whether a pose is to be believed, by what was found of what it should see.
//
// Two explanations compete in each cell of a 4 x 3 grid over the image. The pose is right: then as many
// points are found as their record says, give or take what such counts vary by, or the cell is hidden by
// something (a hand) and hardly any are. Or it is wrong: then points are found by chance, a small share of
// those that were looked for. The evidence is the logarithm of the odds between the two, summed over the
// cells. A hand that hides two thirds of the picture costs little; finding some points everywhere and
// missing most of them, as a wrong pose among similar things does, speaks against the pose however many
// they are.
//
// What repeats is found in the wrong place as well as in the right one: it is left out of the count, found or
// not, when no prediction says which place it is. On a wall of equal tiles nothing is left, and nothing is
// believed.
#pragma once

#include <vector>

#include "core/geometry/camera_model.h"
#include "tracking/features/features.h"
#include "tracking/map/map.h"

namespace ulf::tracking {

struct FramePose;

// What must be outweighed: nothing where a prediction led to the pose; a thousand to one where what the
// picture looks like did.
inline constexpr double kFollowedLogOdds = 0;
inline constexpr double kRelocalizedLogOdds = 7;

// By candidate: whether to leave it out.
using LeftOut = std::vector<bool>;

// Natural logarithm of the odds that the pose is right rather than wrong, both as likely beforehand.
double PoseLogOdds(const CameraModel& camera, const FramePose& located, const LeftOut& left_out = {});

// Leaves out what looks like something elsewhere in the picture, or like another point that the pose should
// see there.
void ExcludeAmbiguousMatches(const CameraModel& camera, const FeatureSet& picture, const FramePose& located,
                             LeftOut& left_out);
// Leaves out what looks like another place's points, those that a keyframe sees. The map's lock is held.
void ExcludeAmbiguousMatches(const Map& map, int keyframe, const FramePose& located, LeftOut& left_out);

}  // namespace ulf::tracking
