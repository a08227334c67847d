// The cameras of a running capture: of the live frames, and of what is recorded, which is the same unless the
// device takes photographs. Every part of a capture asks here, because the tracker may go on with another
// lens than the given one (tracking/tracker_options.h, LensUse::kRefine).
#pragma once

#include <optional>
#include <string>

#include "core/geometry/camera_model.h"
#include "tracking/sources/poses_spec.h"

namespace ulf::coverage {

class CaptureLens {
 public:
  // `still`: of photographs, where these are recorded in place of live frames.
  explicit CaptureLens(const CameraModel& live, const std::optional<CameraModel>& still = {})
      : live_(live), still_(still) {}

  const CameraModel& live() const { return live_; }
  const CameraModel& recorded() const { return still_ ? *still_ : live_; }

  // After each frame of `poses`. Returns the live lens of before where the tracker has gone on with another
  // one in this frame; everything that knows poses or points by the old one is to follow.
  std::optional<CameraModel> After(const tracking::Track& track, const tracking::PoseSource& poses);
  // After PoseSource::Finish(), in the same way.
  std::optional<CameraModel> AfterFinish(const tracking::PoseSource& poses);

  // That took the given one's place; none: the given one is in use.
  const std::optional<tracking::RefinedLens>& found() const { return found_; }
  // Where the lens that was found is from, for the record.
  std::string FoundSource() const;
  // What the images say against the lens in use, as they said it first; none: nothing (any more).
  const std::optional<tracking::CalibrationCheck>& contradicted() const { return contradicted_; }

 private:
  CameraModel live_;
  const std::optional<CameraModel> still_;
  int revision_ = 0;
  std::optional<tracking::RefinedLens> found_;
  std::optional<tracking::CalibrationCheck> contradicted_;
};

// By how much two lenses show the same ray apart, at most, in pixels of a picture with this longer side.
double LargestShiftPx(const CameraModel& a, const CameraModel& b, int longer_side_px);

}  // namespace ulf::coverage
