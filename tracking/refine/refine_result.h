// Defines the result of refining: views, points and lenses, and figures of what improved.
//
// Poses are cam_from_world in the input's units, image quantities are pixels of the input's images, angles
// are degrees.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "core/light_field/light_field.h"
#include "tracking/estimation/calibration_check.h"
#include "tracking/estimation/lens_evidence.h"

namespace ulf::tracking {

struct RefinedView {
  Rigid3 cam_from_world;  // the start pose if the view is not registered
  bool registered = false;
  std::string why;     // the view is not registered
  int points = 0;      // number of points that it shows
  double quality = 1;  // Track::quality of a located photograph; 1 for a recorded view
  // The camera's pose when its middle row was read, relative to cam_from_world; none with a global shutter.
  std::optional<Rigid3> middle_row_from_picture = {};
};

struct RefineResult {
  std::vector<RefinedView> views;
  // The points under the new poses, with the views that show them; a track names a view by its index.
  std::vector<ScenePoint> points;
  std::vector<CameraModel> lenses;                  // changed with RefineOptions::intrinsics only
  std::map<int, LensEstimate> lens_fits;            // by lens, the one that the evidence supports
  std::vector<std::vector<LensTrial>> lens_trials;  // by lens, the steps of the choice
  std::vector<CalibrationCheck> checks;             // of the given lenses that have enough views
  int registered = 0;                               // number of views
  int groups = 0;  // of views that share points; only the start poses say how groups lie to each other
  std::size_t adjusted_points = 0, adjusted_observations = 0;  // numbers that the last adjustment kept
  // One standard deviation of the matches' distances from the start poses' epipolar lines.
  double start_error_px = 0;
  // Reprojection errors of the same observations; the points are fitted to the poses before and after.
  double rms_before_px = 0, rms_after_px = 0;
  double median_before_px = 0, median_after_px = 0;
  double rms_after_sigmas = 0;  // in standard deviations of the observations
  bool settled = false;         // lens and last adjustment converged: more iterations would change little
  int contradicted = -1;        // index of a view most of whose points contradict its pose; -1: none
  // How far the registered recorded views' centres moved, and by how much the views turned.
  double moved_median = 0, moved_max = 0;
  double turned_median_deg = 0, turned_max_deg = 0;
  int moved_most = -1;  // index of the view that moved farthest
  // One standard deviation of the registered views' centres; infinite if something can move freely. None for
  // more than 200 views or several groups.
  std::optional<double> center_sigma_median, center_sigma_max;
  int least_sure = -1;  // index of the view with the largest deviation
};

struct RefineScene;

// Returns `result`, which has lenses and groups, with views, counts, errors, moves and certainty.
RefineResult Summarise(const RefineScene& scene, RefineResult result);

}  // namespace ulf::tracking
