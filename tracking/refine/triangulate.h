// All points that views of known pose share, each measured in every view that shows it: what a model for
// other programs is made of. Poses stay as they are.
//
//   corners of every view -> pairs by the poses -> matches along epipolar lines -> tracks, triangulated
//   -> the same points looked for in every view, by their patches -> points where all of that has them
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tracking/refine/refine.h"
#include "tracking/refine/refine_scene.h"
#include "tracking/refine/view_pairs.h"

namespace ulf::tracking {

struct TriangulationOptions {
  int features = 0;        // corners a view; 0: by the number of views
  int max_side_px = 1600;  // larger pictures are reduced
  std::function<void(double share, const std::string& stage)> progress = {};
};

struct TriangulationResult {
  std::vector<ScenePoint> points;   // in a track a view is its index; pixels are the input's
  double pose_error_px = 0;         // of epipolar lines by the poses, one standard deviation
  std::vector<std::string> unread;  // views that could not be read, and why
};

TriangulationResult TriangulateViews(const RefineInput& input, const TriangulationOptions& options = {});

// Replaces the tracks by all that the matches come to.
void MeasureAllTracks(const std::vector<PairMatches>& matched, RefineScene& scene);

// As points of a light field with these cameras.
std::vector<ScenePoint> PointsOf(const RefineScene& scene, const std::vector<CameraModel>& cameras);

}  // namespace ulf::tracking
