// Every recorded view registered against all others: matches, points, poses and, where the pictures tell, the
// lens (thesis, section 6.2, which found it too expensive).
//
//   corners of every view -> pairs by the poses -> matches -> tracks over all views, triangulated
//   -> adjustment -> the same points looked for in every view, by their patches -> adjustment, twice
//
// Start poses may be off by a percent and a degree: how far they are is measured first, and matching takes it
// into account. What pictures cannot tell (position, orientation, scale of the whole) comes from the start
// poses. A view that fits nowhere keeps its pose and says why. The same input gives the same bytes, whatever
// the number of threads.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "core/image/image.h"
#include "core/light_field/light_field.h"
#include "tracking/estimation/calibration_check.h"
#include "tracking/estimation/lens_evidence.h"

namespace ulf::tracking {

struct RefineInput {
  struct View {
    std::string name;
    int lens = 0;  // index into lenses
    Rigid3 cam_from_world;
  };
  std::vector<CameraModel> lenses;
  std::vector<View> views;
  std::function<Image(int view)> read;  // in any thread; throws Error
};

struct RefineOptions {
  int features = 0;         // corners a view; 0: by the number of views
  int max_side_px = 1600;   // larger pictures are reduced
  bool intrinsics = false;  // take over the lens that the evidence speaks for
  bool all_points = false;  // measures all points that the views share, not only those that poses need
  unsigned seed = 1;
  std::function<void(double share, const std::string& stage)> progress = {};
};

struct RefinedView {
  Rigid3 cam_from_world;  // the start pose where it is not registered
  bool registered = false;
  std::string why;  // it is not
  int points = 0;
};

struct RefineResult {
  std::vector<RefinedView> views;
  // Under the new poses, with what views show of them; in a track a view is its index.
  std::vector<ScenePoint> points;
  std::vector<CameraModel> lenses;      // changed with RefineOptions::intrinsics only
  std::vector<LensEstimate> lens_fits;  // what the evidence speaks for, lens by lens; sizes of the input
  std::vector<std::vector<LensTrial>> lens_trials;  // how they were chosen, for every lens
  std::vector<CalibrationCheck> checks;             // of the given lenses, for those with enough views
  int registered = 0;
  int groups = 0;  // of views that share points; more than one: they hold together by their start poses alone
  std::size_t adjusted_points = 0, adjusted_observations = 0;  // that the poses come from
  double start_error_px = 0;  // of epipolar lines by the start poses, one standard deviation
  // Of the same observations, root mean square and median, px; the points are best for each set of poses.
  double rms_before_px = 0, rms_after_px = 0;
  double median_before_px = 0, median_after_px = 0;
  double rms_after_sigmas = 0;
  bool settled = false;   // the last adjustment ended by itself: more iterations would change little
  int contradicted = -1;  // the view most of whose points disagree with where it was put; -1: none
  // How far centres and directions of the registered views moved.
  double moved_median = 0, moved_max = 0;
  double turned_median_deg = 0, turned_max_deg = 0;
  int moved_most = -1;  // the view
  // What the pictures leave open of where the registered views' centres are, one standard deviation; infinite
  // where something can move freely. None of more than 200 views, nor of several groups.
  std::optional<double> center_sigma_median, center_sigma_max;
  int least_sure = -1;  // the view
};

// Throws Error when nothing can be registered: fewer than two readable views, views that share nothing or
// were all taken from one place.
RefineResult Refine(const RefineInput& input, const RefineOptions& options = {});

}  // namespace ulf::tracking
