// Holds the lenses (camera models) of a running capture: that of the live frames and that of the recorded
// images. They differ only if the device records stills. Every part of a capture takes them from here,
// because the tracker may replace the lens of live frames (LensUse::kRefine), which a capture of stills
// refuses.
#pragma once

#include <optional>
#include <string>

#include "core/geometry/camera_model.h"
#include "tracking/tracker/pose_source.h"

namespace ulf::coverage {

class CaptureLens {
 public:
  // `still`: the lens of stills, if these are recorded in place of live frames.
  explicit CaptureLens(const CameraModel& live, const std::optional<CameraModel>& still = {})
      : live_(live), still_(still) {}

  const CameraModel& live() const { return live_; }
  const CameraModel& recorded() const { return still_ ? *still_ : live_; }

  // Call it after each PoseSource::Step(), with the track that it returned. Returns the former live lens if
  // the tracker replaced it in this frame: whoever holds poses or points under it must then convert them.
  std::optional<CameraModel> Update(const tracking::Track& track, const tracking::PoseSource& poses);
  // Call it after PoseSource::Finish(). Returns the former live lens if Finish() replaced it.
  std::optional<CameraModel> UpdateAfterFinish(const tracking::PoseSource& poses);

  // Returns the lens that replaced the given one; none: the given one is in use.
  const std::optional<tracking::RefinedLens>& found() const { return found_; }
  // Returns where found() is from, for the light field's files: "the images of the capture (± 1.2 px)".
  std::string FoundSource() const;
  // Returns how the images contradict the lens in use, as first found; none while they do not.
  const std::optional<tracking::CalibrationCheck>& contradicted() const { return contradicted_; }

 private:
  CameraModel live_;
  const std::optional<CameraModel> still_;
  int revision_ = 0;
  std::optional<tracking::RefinedLens> found_;
  std::optional<tracking::CalibrationCheck> contradicted_;
};

// Returns the largest distance between the pixels at which two lenses show the same ray, in pixels of an
// image whose longer side is `longer_side_px`. Both lenses must be of images of one size.
double LargestShiftPx(const CameraModel& a, const CameraModel& b, int longer_side_px);

}  // namespace ulf::coverage
