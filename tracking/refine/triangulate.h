// Measures all points that views of known pose share, each in every view that shows it, for other programs
// that need them. Poses stay as they are.
//
//   1. detect corners in every view
//   2. choose pairs of views by the poses, and match along epipolar lines
//   3. join the matches to tracks, and triangulate
//   4. search the points in every view by their patches
//   5. fit each point to all its observations
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tracking/refine/refine_input.h"
#include "tracking/refine/refine_scene.h"
#include "tracking/refine/view_pairs.h"

namespace ulf::tracking {

struct TriangulationOptions {
  int features = 0;        // number of corners a view; 0: chosen by the number of views
  int max_side_px = 1600;  // to which the longer side of larger pictures is reduced
  std::function<void(double share, const std::string& stage)> progress = {};
};

struct TriangulationResult {
  std::vector<ScenePoint> points;   // a track names a view by its index; pixels are the input's
  double pose_error_px = 0;         // MeasurePoseErrorPx(); 0: unknown
  std::vector<std::string> unread;  // messages about views that could not be read
};

// Reads every view; one that cannot be read takes no part.
TriangulationResult TriangulateViews(const RefineInput& input, const TriangulationOptions& options = {});

// Replaces the scene's tracks by all that the matches give, in steps 3 to 5.
void MeasureAllTracks(const std::vector<PairMatches>& matched, RefineScene& scene);

// Returns the tracks as points in pixels of the given cameras, by lens; tracks name views by index.
std::vector<ScenePoint> PointsOf(const RefineScene& scene, const std::vector<CameraModel>& cameras);

}  // namespace ulf::tracking
