// Finds a frame's pose from a board or from markers of known size: metric (metres), from the first frame on,
// without a map. Image points are pixels of the image as it comes.
//
// The locator searches markers where they were last, with a margin, else in the whole image, and measures
// their corners to a fraction of a pixel. A plane seen from afar has two poses that look nearly alike
// (Schweighofer and Pinz 2006). Both are computed (Collins and Bartoli 2014, OpenCV's IPPE), refined over all
// corners with the full camera model, and compared. Where the corners cannot tell them apart, the frame
// before decides; without one the frame has no pose.
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
  // The corners that support the pose, with sigmas so large that these count as independent.
  std::vector<PointObservation> corners;
  double center_sigma = 0;  // metres; at least half the distance of a plane's two poses, if both are possible
  double distance = 0;      // from the camera to the corners' mean, metres
  double rms_px = 0;
  bool by_history = false;  // the corners left two poses, and the frame before decided
};

void Describe(const MarkerPose& pose, Track& track);  // everything but the anchor
std::vector<VisiblePoint> VisibleCorners(const MarkerPose& pose);
// Returns the frame with this known pose, or with none.
Frame WithPose(const Frame& frame, const std::optional<MarkerPose>& pose);

class MarkerLocator {
 public:
  // One of a plane's two poses is accepted when the other's sum of squared errors, in sigmas, is larger by
  // this: odds of 1000 : 1.
  static constexpr double kSureDifference = 14;

  // Throws Error when the camera's intrinsics are out of range.
  MarkerLocator(const CameraModel& camera, const MarkerSpec& spec, double sure_difference = kSureDifference);

  // `gray`: CV_8UC1 of the camera's size, display-encoded (GrayForTracking).
  std::optional<MarkerPose> Locate(const cv::Mat& gray, double time_s);
  std::optional<MarkerPose> Locate(const Frame& frame);  // none in an incomplete one

  // Returns a locator of the same markers, with the places known so far, for another camera's photographs.
  MarkerLocator For(const CameraModel& camera) const;

  const MarkerSpec& spec() const { return spec_; }
  const CameraModel& camera() const { return camera_; }
  // Returns which of several markers became the world, as PosesSpec::Parse() names it; empty without a
  // choice.
  std::string WorldInWords() const;
  int AmbiguousFrames() const { return ambiguous_frames_; }

 private:
  struct Detections {
    std::map<int, MarkerImage> markers;   // by number; none that is seen twice
    std::vector<PointObservation> board;  // corners of a board
    std::vector<cv::Point2f> all;         // in OpenCV's pixels
  };
  // `is_part`: of the image, so that the whole may show more.
  Detections Detect(const cv::Mat& gray, bool is_part) const;
  Detections DetectNearLast(const cv::Mat& gray) const;
  std::vector<PointObservation> KnownCorners(const Detections& detections) const;
  // `ambiguous`: set where nothing decides between two poses.
  std::optional<MarkerPose> Solve(std::vector<PointObservation> corners, const std::optional<Rigid3>& history,
                                  bool* ambiguous = nullptr) const;
  void Learn(const Detections& detections, const std::optional<MarkerPose>& pose);
  std::optional<Rigid3> Predicted(double time_s) const;

  CameraModel camera_;
  MarkerSpec spec_;
  double sure_difference_;
  MarkerMap map_;  // of markers that are learnt
  std::optional<cv::Rect> last_seen_;
  int frames_near_ = 0;  // since the whole image was searched
  std::optional<TimedPose> last_pose_;
  int ambiguous_frames_ = 0;
};

// Finds where another camera took a photograph of the markers that `locator` knows.
std::optional<MarkerPose> LocateByMarkers(const MarkerLocator& locator, const Frame& photograph,
                                          const CameraModel& camera);

}  // namespace ulf::tracking
