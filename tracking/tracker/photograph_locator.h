// Finds where a photograph was taken, in the map that was made from a live view: a tethered camera's full
// resolution differs from its live view in size, crop and distortion.
//
// The locator reduces the photograph until its focal length in pixels is the live view's, so that the map's
// descriptors, patches and pyramid levels fit it. It searches near the expected pose first, widely, because
// the hand moves on after the release, and else by descriptors alone. Then it refines the pose at full
// resolution: the same points, their patches aligned in the photograph itself.
#pragma once

#include <opencv2/core.hpp>
#include <optional>

#include "tracking/map/frame_locator.h"
#include "tracking/map/relocalizer.h"

namespace ulf::tracking {

class PhotographLocator {
 public:
  // `live` and `photograph` are the two cameras, `features` the number of corners in the photograph.
  PhotographLocator(const CameraModel& live, const CameraModel& photograph, const SharedMap& shared,
                    const KeyframeIndex& index, int features, unsigned seed);

  // `gray` has the photograph's size; `fiducials` and the result's matches are in its pixels. `near` is the
  // expected pose, if known. Takes the map's lock. Returns none if the pose is not certain.
  std::optional<FramePose> Locate(const cv::Mat& gray, const std::optional<Rigid3>& near,
                                  const std::optional<FiducialObservation>& fiducials = {}) const;

 private:
  std::optional<FramePose> LocateNear(const TrackedImage& image, const Rigid3& near) const;
  FramePose RefineAtFull(TrackedImage image, FramePose frame_pose) const;

  int features_;
  unsigned seed_;
  Eigen::Vector2d photograph_px_;  // width and height
  CameraModel full_;               // the photograph's, as far as the pyramid's levels reach
  CameraModel small_;              // the photograph's, reduced to the live view's focal length
  const SharedMap& shared_;
  const KeyframeIndex& index_;
  FrameLocator locator_;
};

}  // namespace ulf::tracking
