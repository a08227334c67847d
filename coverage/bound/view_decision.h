// Decides whether a frame is recorded, with the reason, from frame, track and coverage map alone.
//
// The tests have this order: the pose is known, the camera sees the whole subject, the viewpoint is open, the
// image is good. So a frame whose viewpoint is covered already is not reported as blurred. The reasons from
// kSpool on, but kZoomed, are given by coverage/session/record/capture_recorder.h.
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
  kCovered,           // the bound from a recorded view is within the threshold
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
  kStill,             // open; a photograph is requested instead of recording the live frame
  kPaused,            // open; recording is paused by request
  kZoomed,            // the zoom was moved: the lens is not the light field's
  kBracket,           // the frame is another exposure of a view, or came while those were taken
};
inline constexpr std::array kReasons{Reason::kRecorded, Reason::kCovered,      Reason::kOutsideRectangle,
                                     Reason::kBehind,   Reason::kInsideSphere, Reason::kTracking,
                                     Reason::kBlur,     Reason::kExposure,     Reason::kUnsettled,
                                     Reason::kSpeed,    Reason::kSpool,        Reason::kDisk,
                                     Reason::kStill,    Reason::kPaused,       Reason::kZoomed,
                                     Reason::kBracket};
const char* Name(Reason reason);               // for reports that programs read: "outside_rectangle"
const char* InWords(Reason reason);            // for the person with the camera
std::string InWords(const std::string& name);  // the same, of a Name(); an unknown name comes back as it is

// Returns by how many pixels of the coverage image (focal length `focal_px`) a camera centre that is off by
// `center_sigma` displaces what its view shows of a sphere of `radius` at `distance`, all in world units
// (docs/coverage_bound.md, "How sure a pose must be").
//
// A pose fits the points that it was estimated from: the rotation compensates for the centre's error, and
// what lies at the sphere's centre projects where it should. The nearest point of the sphere is off most.
double PoseErrorPx(double center_sigma, double focal_px, double distance, double radius);

// Beyond any of these a frame is not recorded. All but the pose's are guessed.
inline constexpr double kMostPoseErrorPx = 1;   // of PoseErrorPx(): up to there the bound holds
inline constexpr double kLeastSharpness = 0.5;  // of Track::sharpness
inline constexpr double kMostClippedShare =
    0.3;  // of the sphere's image; highlights may clip, surfaces may not
inline constexpr double kLeastBrightest = 0.08;  // of SubjectLight::brightest_tenth

struct Decision {
  Reason reason = Reason::kTracking;
  // The smallest bound from the recorded views; none where it is infinite or was not computed.
  std::optional<double> bound_px;
};

struct FrameToDecide {
  const Frame& frame;
  const tracking::Track& track;
  const CameraModel& camera;
  double frame_period_s = 0;  // between the device's frames; 0: unknown
  int coverage_width_px = kCoverageWidthPx;
  bool exposure_settled = true;
};

// Returns whether the subject is clipped or black, so that the frame is not recorded and its sharpness tells
// nothing.
bool IsBadlyExposed(const SubjectLight& light);

// Returns whether a frame shows the whole subject from a known pose: all other reasons not to record it are
// the bound's or the image's. `map`: null while there is no subject, and the answer is no.
bool ShowsWholeSubject(const FrameToDecide& input, const CoverageMap* map);

// Decides where the capture has a subject. `map`: null before it is found, and the reason is kTracking.
Decision Decide(const FrameToDecide& input, const CoverageMap* map);

// Decides where the capture has no subject. `shown_already`: recorded views show what the frame shows
// (posed_photographs.h). The exposure is judged within the ellipse that fills the image.
Decision DecideWithoutSubject(const FrameToDecide& input, bool shown_already);

}  // namespace ulf::coverage
