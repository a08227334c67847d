// Decides whether a frame is recorded, with the reason, from frame, track and coverage map alone.
//
// The tests have this order: the pose is known, the camera sees the whole subject, the viewpoint is open, the
// image is good. So a frame whose viewpoint is covered already is not reported as blurred.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "core/frames/frame.h"
#include "core/geometry/camera_model.h"
#include "coverage/bound/capture_presets.h"
#include "coverage/bound/coverage_map.h"
#include "coverage/bound/subject_light.h"
#include "tracking/tracker/track.h"

namespace ulf::coverage {

enum class Reason {
  kRecorded,
  kCovered,           // a recorded view shows the subject as well within the threshold
  kOutsideRectangle,  // the sphere's silhouette leaves the safety rectangle
  kBehind,            // the subject is behind the camera
  kInsideSphere,      // the camera is inside the subject's sphere
  kTracking,          // no pose, a pose that is too uncertain, or no subject yet
  kBlur,              // less detail than the recent frames
  kExposure,          // the subject is clipped or black
  kUnsettled,         // the exposure, or the light on the subject, is still changing (exposure.h)
  kSpeed,             // the image moves too far during the exposure
  kSpool,             // the disk is behind: views wait to be written
  kDisk,              // the disk is full
  kStill,             // open; a photograph was requested, the live frame itself is not recorded
  kPaused,            // open; recording is paused by request
  kZoomed,            // the zoom was moved: the lens is not the light field's
  kBracket,           // another exposure of a view, or it came while those were taken
};
inline constexpr std::array kReasons{Reason::kRecorded, Reason::kCovered,      Reason::kOutsideRectangle,
                                     Reason::kBehind,   Reason::kInsideSphere, Reason::kTracking,
                                     Reason::kBlur,     Reason::kExposure,     Reason::kUnsettled,
                                     Reason::kSpeed,    Reason::kSpool,        Reason::kDisk,
                                     Reason::kStill,    Reason::kPaused,       Reason::kZoomed,
                                     Reason::kBracket};
const char* Name(Reason reason);               // as in reports for programs
const char* InWords(Reason reason);            // for the person with the camera
std::string InWords(const std::string& name);  // of a reason by its name; a name unknown here as it is

// Returns by how many pixels of the coverage image a camera centre that is off by `center_sigma` moves what
// its view shows of a sphere of `radius` at `distance` (docs/coverage_bound.md, "How sure a pose must be").
//
// A pose fits the points that it was estimated from: where the centre is off by s, the rotation compensates
// for it, and what lies at the sphere's centre, at the distance D, projects where it should. What is nearer
// does not: the nearest point is off by f s (1 / (D - r) - 1 / D) = f s r / (D (D - r)). That is for an error
// across the line of sight; along it the same error moves the sphere's rim by about f s r / D^2, which is
// less.
//
// The limit is one pixel because the bound allows for that already: it takes a recorded pixel for the cone of
// rays through the circle of one pixel spacing (criterion.h). As long as the true ray lies in that cone a
// view that is covered within T pixels is, whatever the pose's error.
double PoseErrorPx(double center_sigma, double focal_px, double distance, double radius);

// Beyond any of these a frame is not recorded. All but the pose's are guessed.
inline constexpr double kMostPoseErrorPx = 1;   // PoseErrorPx; derived there
inline constexpr double kLeastSharpness = 0.5;  // of the recent frames' median
// Of the sphere's image. Highlights may clip, surfaces may not; the brightest tenth is display-encoded.
inline constexpr double kMostClippedShare = 0.3, kLeastBrightest = 0.08;

struct Decision {
  Reason reason = Reason::kTracking;
  // The smallest bound of the recorded views; none where it is infinite or was not computed.
  std::optional<double> bound_px;
};

struct FrameToDecide {
  const Frame& frame;
  const tracking::Track& track;
  const CameraModel& camera;
  double frame_period_s = 0;  // 0: unknown
  int coverage_width_px = kCoverageWidthPx;
  bool exposure_settled = true;
};

// Returns whether the subject is clipped or black, so that the frame is not recorded and its sharpness is
// unknown.
bool IsBadlyExposed(const SubjectLight& light);

// Returns whether a frame shows the whole subject from a known pose: all other reasons not to record it are
// the bound's or the image's. `map`: null while there is no subject.
bool ShowsWholeSubject(const FrameToDecide& input, const CoverageMap* map);

// `map`: null while there is no subject.
Decision Decide(const FrameToDecide& input, const CoverageMap* map);

// Returns the decision without a subject. `shown_already`: by recorded views (posed_photographs.h). The
// exposure is judged on the whole image.
Decision DecideWithoutSubject(const FrameToDecide& input, bool shown_already);

}  // namespace ulf::coverage
