// Finds a frame's pose from a board or from markers of known size, without a map, from the first frame on.
// Lengths are metres, image points pixels of the image as it comes.
//
// The locator searches markers where they were last, with a margin, else in the whole image, and measures
// their corners to a fraction of a pixel. A plane seen from afar has two poses that look nearly alike
// (Schweighofer and Pinz 2006). Both are computed (Collins and Bartoli 2014, OpenCV's IPPE), refined over all
// corners with the full camera model, and compared. If the corners cannot tell them apart and their centres
// are apart, the frame before decides; without one the frame has no pose.
//
// With several markers of unknown arrangement the first one seen well is the world. Another marker gets its
// place from frames that show it beside known ones without ambiguity; from then on both are refined together
// (marker_map.h).
#pragma once

#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "core/geometry/trajectory.h"
#include "tracking/estimation/absolute_pose.h"
#include "tracking/sources/marker_map.h"
#include "tracking/sources/marker_spec.h"
#include "tracking/tracker/track.h"

namespace ulf::tracking {

struct MarkerPose {
  Rigid3 cam_from_world;
  // The corners that support the pose, with sigmas so large that their errors may count as independent.
  std::vector<PointObservation> corners;
  // One standard deviation of the centre; if both of a plane's poses remain, at least half their distance.
  double center_sigma = 0;
  double distance = 0;  // from the camera to the corners' mean
  double rms_px = 0;
  bool by_history = false;  // the corners left two poses, and the frame before decided
};

// Fills in what a track says of a pose, but no anchor.
void Describe(const MarkerPose& pose, Track& track);
std::vector<VisiblePoint> VisibleCorners(const MarkerPose& pose);
// Returns the frame with Frame::known_cam_from_world replaced by this pose, or by none.
Frame WithPose(const Frame& frame, const std::optional<MarkerPose>& pose);

class MarkerLocator {
 public:
  // A pose is accepted if the other's squared errors (sigmas) add up to more by this: odds of 1000 : 1.
  static constexpr double kSureDifference = 14;

  // Throws Error if the camera's intrinsics are out of range.
  MarkerLocator(const CameraModel& camera, const MarkerSpec& spec, double sure_difference = kSureDifference);

  // Returns none if the markers are not seen, or leave the pose open. `gray` is CV_8UC1, display-encoded
  // (GrayForTracking()). Throws Error if it has not the camera's size. Call it for the frames in order.
  std::optional<MarkerPose> Locate(const cv::Mat& gray, double time_s);
  std::optional<MarkerPose> Locate(const Frame& frame);  // none for an incomplete frame

  // Returns a locator of the same markers, with the places known so far, for a photograph of another camera.
  MarkerLocator For(const CameraModel& camera) const;

  const MarkerSpec& spec() const { return spec_; }
  const CameraModel& camera() const { return camera_; }
  // Returns a sentence that names the marker of several that became the world, as `--poses` takes it, or "".
  std::string WorldInWords() const;
  int AmbiguousFrames() const { return ambiguous_frames_; }  // two poses were possible, none was given

 private:
  struct Detections {
    std::map<int, MarkerImage> markers;   // by number; none that is seen twice
    std::vector<PointObservation> board;  // corners of a board
    std::vector<cv::Point2f> all;         // all corners
  };
  // `is_part` says that `gray` is a part of the image, and the whole may show more.
  Detections Detect(const cv::Mat& gray, bool is_part) const;
  Detections DetectNearLast(const cv::Mat& gray) const;
  std::vector<PointObservation> KnownCorners(const Detections& detections) const;
  // Sets `ambiguous`, unless null, if nothing decides between two poses.
  std::optional<MarkerPose> Solve(std::vector<PointObservation> corners, const std::optional<Rigid3>& history,
                                  bool* ambiguous = nullptr) const;
  void Learn(const Detections& detections, const std::optional<MarkerPose>& pose);
  std::optional<Rigid3> Predicted(double time_s) const;

  CameraModel camera_;
  MarkerSpec spec_;
  double sure_difference_;
  MarkerMap map_;  // of markers that are learnt
  std::optional<cv::Rect> last_seen_;
  int frames_near_ = 0;  // number since the whole image was searched
  std::optional<TimedPose> last_pose_;
  int ambiguous_frames_ = 0;
};

// Finds where another camera took a photograph of the markers that `locator` knows; throws as Locate() does.
std::optional<MarkerPose> LocateByMarkers(const MarkerLocator& locator, const Frame& photograph,
                                          const CameraModel& camera);

}  // namespace ulf::tracking
