// A frame's pose from a board or markers of known size: metric, from the first frame on, without a map.
//
// Corners are found where the markers were last, with a margin, else in the whole image; each to a part of a
// pixel. A plane seen from afar has two poses that show nearly the same (Schweighofer and Pinz 2006); both
// are computed (Collins and Bartoli 2014, OpenCV's IPPE), refined over all corners with the full camera
// model, and compared. Where the corners cannot tell them apart the frame before decides; without one there
// is no pose rather than a wrong one.
//
// Markers whose arrangement nobody knows: the first that is seen well is the world. Another gets its place
// from frames that show it beside known ones and leave no doubt; from then on both are refined together
// (marker_map.h).
#pragma once

#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "tracking/estimation/absolute_pose.h"
#include "tracking/sources/marker_map.h"
#include "tracking/sources/marker_spec.h"
#include "tracking/tracker/tracker.h"

namespace ulf::tracking {

struct MarkerPose {
  Rigid3 cam_from_world;
  std::vector<PointObservation> corners;  // that support it, with what they come to as independent ones
  double center_sigma = 0;  // metres; no less than half of what lies between the two poses of a plane
  double distance = 0;      // from the camera to the corners' mean, metres
  double rms_px = 0;
  bool by_history = false;  // the corners alone could not tell
};

void Describe(const MarkerPose& pose, Track& track);  // but for its anchor
std::vector<VisiblePoint> VisibleCorners(const MarkerPose& pose);
// The frame as if it had come with this pose, or with none.
Frame WithPose(const Frame& frame, const std::optional<MarkerPose>& pose);

struct MarkerLocatorOptions {
  double corner_sigma_px = 0.15;  // what is usual; where corners are many they say it themselves
  // The worse of the two poses must be this much less likely: difference of squared errors in sigmas.
  double sure_difference = 14;  // 1000 : 1
  double history_s = 0.5;       // a pose older than this decides nothing
};

class MarkerLocator {
 public:
  // Throws Error when the camera's intrinsics are out of range.
  MarkerLocator(const CameraModel& camera, const MarkerSpec& spec, const MarkerLocatorOptions& options = {});

  // `gray`: CV_8UC1 of the camera's size, display-encoded (GrayForTracking).
  std::optional<MarkerPose> Locate(const cv::Mat& gray, double time_s);

  // The same markers, as far as they are known, for another camera's photographs.
  MarkerLocator For(const CameraModel& camera) const;

  const MarkerSpec& spec() const { return spec_; }
  const CameraModel& camera() const { return camera_; }
  // Markers with a place in the world: 1 but for markers that are learnt.
  int KnownMarkers() const;
  // To be told at the end: which of several markers became the world, as --poses names it. Empty: not to be
  // told.
  std::string WorldInWords() const;
  int AmbiguousFrames() const { return ambiguous_frames_; }

 private:
  struct Detections {
    std::map<int, MarkerImage> markers;   // by number; none that is seen twice
    std::vector<PointObservation> board;  // corners of a board
    std::vector<cv::Point2f> all;         // in OpenCV's pixels
  };
  Detections Detect(const cv::Mat& gray) const;
  Detections DetectNearLast(const cv::Mat& gray) const;
  std::vector<PointObservation> KnownCorners(const Detections& detections) const;
  std::optional<MarkerPose> Solve(std::vector<PointObservation> corners, const std::optional<Rigid3>& history,
                                  bool* ambiguous) const;
  void Learn(const Detections& detections, const std::optional<MarkerPose>& pose);
  std::optional<Rigid3> Predicted(double time_s) const;

  CameraModel camera_;
  MarkerSpec spec_;
  MarkerLocatorOptions options_;
  MarkerMap map_;  // of markers that are learnt
  std::optional<cv::Rect> last_seen_;
  int frames_near_ = 0;  // since the whole image was searched
  struct TimedPoseOfCamera {
    double time_s;
    Rigid3 cam_from_world;
  };
  std::vector<TimedPoseOfCamera> history_;  // the last two
  int ambiguous_frames_ = 0;
};

// Where another camera took a photograph of the markers that `locator` knows.
std::optional<MarkerPose> LocateByMarkers(const MarkerLocator& locator, const Frame& photograph,
                                          const CameraModel& camera);

}  // namespace ulf::tracking
