// Holds the camera models of a running capture: of the live frames, and of what is recorded, which is the
// same unless the device takes photographs. Every part of a capture takes them from here, because the tracker
// may replace the given lens (tracking/tracker_options.h, LensUse::kRefine).
#pragma once

#include <optional>
#include <string>

#include "core/geometry/camera_model.h"
#include "tracking/tracker/pose_source.h"

namespace ulf::coverage {

class CaptureLens {
 public:
  // `still`: the camera of photographs, where these are recorded in place of live frames.
  explicit CaptureLens(const CameraModel& live, const std::optional<CameraModel>& still = {})
      : live_(live), still_(still) {}

  const CameraModel& live() const { return live_; }
  const CameraModel& recorded() const { return still_ ? *still_ : live_; }

  // Call it after each frame of `poses`. Returns the former live lens where the tracker has replaced it in
  // this frame: everything that holds poses or points under the former one must be converted.
  std::optional<CameraModel> Update(const tracking::Track& track, const tracking::PoseSource& poses);
  // Does the same after PoseSource::Finish().
  std::optional<CameraModel> UpdateAfterFinish(const tracking::PoseSource& poses);

  // Returns the lens that replaced the given one; none: the given one is in use.
  const std::optional<tracking::RefinedLens>& found() const { return found_; }
  // Returns where the lens that was found is from, for the record.
  std::string FoundSource() const;
  // Returns what the images say against the lens in use, as they said it first; none if nothing (any more).
  const std::optional<tracking::CalibrationCheck>& contradicted() const { return contradicted_; }

 private:
  CameraModel live_;
  const std::optional<CameraModel> still_;
  int revision_ = 0;
  std::optional<tracking::RefinedLens> found_;
  std::optional<tracking::CalibrationCheck> contradicted_;
};

// Returns by how much two lenses show the same ray apart, at most, in pixels of a picture with this longer
// side.
double LargestShiftPx(const CameraModel& a, const CameraModel& b, int longer_side_px);

}  // namespace ulf::coverage
