// Measures all points that views of known pose share, each in every view that shows it: the points of a model
// for other programs. Poses stay as they are.
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

struct AllTracksOptions {
  double gate_px = 3;   // of triangulation, under poses that stay. Guessed
  int per_view = 4000;  // points a view, about: more cost time. Guessed
  // Observations are dropped that are off by so many times the usual error, within these limits. Guessed.
  double most_times_usual = 5, least_px = 0.5, most_px = 4;
};

struct TriangulationOptions {
  int features = 0;  // corners a view; 0: by the number of views
  // Corners of each of few views (kFewViews), which can afford more, and of each of many. Guessed.
  int corners_of_few = 4000, corners = 2500;
  int max_side_px = 1600;  // larger pictures are reduced
  AllTracksOptions all_tracks = {};
  std::function<void(double share, const std::string& stage)> progress = {};
};

struct TriangulationResult {
  std::vector<ScenePoint> points;   // a track names a view by its index; pixels are the input's
  double pose_error_px = 0;         // of matches from the poses' epipolar lines, one standard deviation
  std::vector<std::string> unread;  // views that could not be read, and why
};

TriangulationResult TriangulateViews(const RefineInput& input, const TriangulationOptions& options = {});

// Replaces the scene's tracks by all that the matches give.
void MeasureAllTracks(const std::vector<PairMatches>& matched, const AllTracksOptions& options,
                      RefineScene& scene);

// The tracks as points of a light field with these cameras.
std::vector<ScenePoint> PointsOf(const RefineScene& scene, const std::vector<CameraModel>& cameras);

}  // namespace ulf::tracking
