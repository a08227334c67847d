// Where a photograph was taken, against the map that another camera's live view has made: a tethered camera's
// full resolution differs from its live view in size, crop and distortion.
//
// Matched at live scale: the photograph is reduced until its focal length is the live view's, so that the
// map's descriptors, patches and pyramid levels mean the same in both. First near the pose where it is
// expected; the hand has moved on since the release, so the search is wide; failing that from nothing, by
// descriptors. Then refined at full resolution: the same points, aligned with their patches in the photograph
// itself.
#pragma once

#include <opencv2/core.hpp>
#include <optional>

#include "tracking/map/relocalizer.h"
#include "tracking/tracker/frame_locator.h"

namespace ulf::tracking {

class PhotographLocator {
 public:
  struct Options {
    int features = 2000;
    unsigned seed = 1;
  };
  PhotographLocator(const CameraModel& live, const CameraModel& photograph, const SharedMap& shared,
                    const KeyframeIndex& index, const Options& options);

  // `gray` has the photograph's size, and `fiducials`, what it shows of a given world, is in its pixels.
  // Takes the map's lock. None when unsure. Matches are in pixels of the photograph.
  std::optional<FramePose> Locate(const cv::Mat& gray, const std::optional<Rigid3>& near,
                                  const std::optional<FiducialObservation>& fiducials = {}) const;

 private:
  std::optional<FramePose> LocateNear(const TrackedImage& image, const Rigid3& near) const;
  FramePose RefineAtFull(TrackedImage image, FramePose located) const;

  Options options_;
  Eigen::Vector2d photograph_px_;  // its size
  CameraModel full_;               // of the photograph as it is
  CameraModel small_;              // the same with the live view's focal length
  const SharedMap& shared_;
  const KeyframeIndex& index_;
  FrameLocator locator_;
};

}  // namespace ulf::tracking
