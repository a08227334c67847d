// Paints the coverage map of a running capture from the recorded views with their present poses, and finds
// the directions that a correction of poses, or a view that was taken back, has reopened.
//
// The map is an immutable snapshot. A new view and corrected poses make a new one; whoever holds the old one
// keeps it as it was.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/light_field/light_field.h"
#include "coverage/bound/capture_presets.h"
#include "coverage/bound/coverage_map.h"
#include "coverage/measured/cover_by.h"
#include "coverage/measured/error_map.h"
#include "coverage/session/record/capture_lens.h"
#include "coverage/session/record/capture_options.h"
#include "coverage/session/record/recorded_views.h"

namespace ulf::coverage {

// A cell of the map that was covered and no longer is.
struct ReopenedDirection {
  Eigen::Vector3d direction;  // from the subject's centre, unit, in the world
  double share = 0;           // the cell's, of the cap; without a cap, of what was covered
};

class CoveragePainter {
 public:
  // `views`, `lens` and `options` outlive it. `up_in_world`: the light field's own, as `ulf info` takes it;
  // none: by the cameras. The owner calls it after changes of `views`.
  CoveragePainter(const RecordedViews& views, const CaptureLens& lens, const CaptureOptions& options,
                  const std::optional<Eigen::Vector3d>& up_in_world);

  const std::shared_ptr<const CoverageMap>& map() const { return map_; }  // null without a subject
  const std::vector<ReopenedDirection>& reopened() const { return reopened_; }

  // Makes the map of this subject from all views. `errors` adapt its thresholds; null: nothing is measured.
  void PaintAnew(const Subject& subject, const ErrorMap* errors);
  // Returns whether no view was added, moved or removed since the map was painted anew.
  bool IsPaintedAnew() const { return painted_ == StateOf(views_); }
  // Call it for another subject, of which nothing was covered before.
  void ForgetReopened() { reopened_.clear(); }
  // Paints anew, notes the directions that this reopens, and returns their share of the cap (without one, of
  // what was covered). 0 without a map.
  double Repaint(const Subject& subject, const ErrorMap* errors);
  // Adapts the map's thresholds to the errors so far. There must be a map.
  void AdaptToErrors(const ErrorMap& errors);

  // Adds the view that was recorded last.
  void AddNewest();

 private:
  struct ViewsState {
    std::uint64_t revision = 0;
    std::size_t size = 0;
    bool operator==(const ViewsState&) const = default;
  };
  static ViewsState StateOf(const RecordedViews& views) { return {views.revision(), views.size()}; }
  void DropCoveredAgain();

  const RecordedViews& views_;
  const CaptureLens& lens_;
  const CaptureOptions& options_;
  const CoverageMapOptions map_options_;
  std::shared_ptr<const CoverageMap> map_;
  std::vector<ReopenedDirection> reopened_;
  ViewsState painted_;  // when all was painted last
};

}  // namespace ulf::coverage
