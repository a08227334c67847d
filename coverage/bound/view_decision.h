// What becomes of a frame, and why: recorded, or one of the reasons not to. Pure: frame, track and map in,
// decision out.
//
// The reasons are asked in an order in which each makes sense of the next: where is the camera, does it look
// at the subject, is its viewpoint wanted, is the picture good. A frame that is covered is never blamed for
// its blur.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "core/geometry/camera_model.h"
#include "core/image/frame.h"
#include "coverage/bound/coverage_map.h"
#include "tracking/tracker/tracker.h"

namespace ulf::coverage {

enum class Reason {
  kRecorded,
  kCovered,           // a recorded view shows the subject as well within the threshold
  kOutsideRectangle,  // the sphere's silhouette leaves the safety rectangle
  kBehind,            // the subject is behind the camera
  kInsideSphere,      // the camera is inside the subject's sphere
  kTracking,          // no pose, one that is not sure enough, or no subject yet
  kBlur,              // less detail than the recent frames
  kExposure,          // the subject is clipped or black
  kUnsettled,         // the exposure, or the light on the subject, is still changing (exposure_watch.h)
  kSpeed,             // the image moves too far during the exposure
  kSpool,             // the disk is behind: views wait to be written
  kDisk,              // the disk is full
  kStill,             // wanted, and a photograph is on its way: the live frame itself is not recorded
  kPaused,            // wanted, but the recording is paused as asked
};
inline constexpr std::array kReasons{Reason::kRecorded, Reason::kCovered,      Reason::kOutsideRectangle,
                                     Reason::kBehind,   Reason::kInsideSphere, Reason::kTracking,
                                     Reason::kBlur,     Reason::kExposure,     Reason::kUnsettled,
                                     Reason::kSpeed,    Reason::kSpool,        Reason::kDisk,
                                     Reason::kStill,    Reason::kPaused};
const char* Name(Reason reason);               // as in --json
const char* InWords(Reason reason);            // for the person with the camera
std::string InWords(const std::string& name);  // of a reason by its name; a name unknown here as it is

// How far, in pixels of the coverage image, a camera centre that is off by `center_sigma` moves what its view
// shows of a sphere of `radius` at `distance`.
//
// A pose fits what it was found by: where the centre is off by s, the rotation has taken it along, and what
// lies at the sphere's centre, at the distance D, falls where it should. What is nearer does not: the nearest
// point is off by f s (1 / (D - r) - 1 / D) = f s r / (D (D - r)). That is for an error across the line of
// sight; along it the same error moves the sphere's rim by about f s r / D^2, which is less.
//
// The limit is one pixel because the bound allows for that already: it takes a recorded pixel for the cone of
// rays through the circle of one pixel spacing (criterion.h). As long as the true ray lies in that cone a
// view that is covered within T pixels is, whatever the pose's error.
double PoseErrorPx(double center_sigma, double focal_px, double distance, double radius);

struct DecisionLimits {
  double rectangle_share = 0.8;
  double max_pose_error_px = 1;    // PoseErrorPx
  double min_sharpness = 0.5;      // of the recent frames' median
  double max_motion_blur_px = 2;   // during the exposure, coverage image pixels
  double max_clipped_share = 0.3;  // of the sphere's image
  double min_brightest = 0.08;     // display-encoded, of the brightest tenth of the sphere's image
};

struct Decision {
  Reason reason = Reason::kTracking;
  std::optional<double>
      bound_px;  // from the nearest recorded view; none where it is infinite or was not asked
};

struct FrameToDecide {
  const Frame& frame;
  const tracking::Track& track;
  const CameraModel& camera;
  double frame_period_s = 0;  // 0: unknown
  int coverage_width_px = 640;
  bool exposure_settled = true;
};

// `map`: none while there is no subject.
Decision Decide(const FrameToDecide& input, const CoverageMap* map, const DecisionLimits& limits = {});

// The same where there is no subject: whether recorded views show it already is told (posed_photographs.h),
// the light is that of the whole picture, and a pose must be known to a hundredth of the distance of what is
// seen.
Decision DecideWithoutSubject(const FrameToDecide& input, bool shown_already,
                              const DecisionLimits& limits = {});

}  // namespace ulf::coverage
