#include "coverage/bound/view_decision.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "coverage/bound/sphere_outline.h"
#include "coverage/bound/subject_light.h"

namespace ulf::coverage {
namespace {

struct ReasonTexts {
  const char* name;
  const char* words;
};
// The order is that of Reason.
constexpr std::array<ReasonTexts, kReasons.size()> kTexts{{
    {"recorded", "recorded"},
    {"covered", "covered already"},
    {"outside_rectangle", "subject outside the safety rectangle"},
    {"behind", "subject behind the camera"},
    {"inside_sphere", "camera inside the subject"},
    {"tracking", "position or subject not known yet"},
    {"blur", "blurred"},
    {"exposure", "badly exposed"},
    {"unsettled", "exposure still changing"},
    {"speed", "too fast"},
    {"spool", "disk too slow"},
    {"disk", "disk full"},
    {"still", "photograph being taken"},
    {"paused", "recording paused"},
    {"zoomed", "zoom moved"},
    {"bracket", "other exposures being taken"},
}};

// Guessed.
constexpr double kMostMotionBlurPx = 2;   // during the exposure, coverage image pixels
constexpr double kMostErrorShare = 0.01;  // of a pose without a subject, of the distance of what is seen

bool IsTracked(const tracking::Track& track) {
  return track.state == tracking::TrackState::kTracking && !track.skipped && track.cam_from_world;
}

double MotionBlurPx(const FrameToDecide& input) {
  if (input.frame_period_s <= 0 || input.frame.exposure_s <= 0) return 0;
  const double scale = static_cast<double>(input.coverage_width_px) / input.camera.width;
  return input.track.speed_px * scale * input.frame.exposure_s / input.frame_period_s;
}

// Returns what is wrong with the image of an open viewpoint; kRecorded: nothing.
Reason ImageReason(const FrameToDecide& input, const std::vector<Eigen::Vector2d>& outline) {
  const auto light = LightInside(input.frame.image, outline);
  if (light && IsBadlyExposed(*light)) return Reason::kExposure;
  if (!input.exposure_settled) return Reason::kUnsettled;
  if (MotionBlurPx(input) > kMostMotionBlurPx) return Reason::kSpeed;
  if (input.track.sharpness < kLeastSharpness) return Reason::kBlur;
  return Reason::kRecorded;
}

}  // namespace

bool IsBadlyExposed(const SubjectLight& light) {
  return light.clipped_share > kMostClippedShare || light.brightest_tenth < kLeastBrightest;
}

const char* Name(Reason reason) { return kTexts[static_cast<std::size_t>(reason)].name; }
const char* InWords(Reason reason) { return kTexts[static_cast<std::size_t>(reason)].words; }

std::string InWords(const std::string& name) {
  const auto known = std::ranges::find(kTexts, name, &ReasonTexts::name);
  return known == kTexts.end() ? name : known->words;
}

double PoseErrorPx(double center_sigma, double focal_px, double distance, double radius) {
  return focal_px * center_sigma * radius / (distance * (distance - radius));
}

namespace {

// The first tests: of the pose, and of where the subject is in the picture.
struct SubjectInView {
  Reason reason = Reason::kTracking;  // kRecorded: all of it, from a known pose
  std::vector<Eigen::Vector2d> outline = {};
};

SubjectInView LookForSubject(const FrameToDecide& input, const CoverageMap* map) {
  const tracking::Track& track = input.track;
  if (!IsTracked(track) || !map) return {Reason::kTracking};
  if (track.focal_ratio) return {Reason::kZoomed};
  const Rigid3& cam_from_world = *track.cam_from_world;
  const Subject& subject = map->subject();
  const Eigen::Vector3d center_in_cam = cam_from_world * subject.center_in_world;
  if (center_in_cam.norm() <= subject.radius) return {Reason::kInsideSphere};
  const double focal_px = CriterionView::From(input.camera, cam_from_world, input.coverage_width_px).fx;
  const auto sigma = track.PictureSigma();
  if (sigma && PoseErrorPx(*sigma, focal_px, center_in_cam.norm(), subject.radius) > kMostPoseErrorPx)
    return {Reason::kTracking};
  if (center_in_cam.z() <= 0) return {Reason::kBehind};
  auto outline = SphereOutline(input.camera, cam_from_world, subject);
  if (!outline || !SafetyRectangle::Of(input.camera).Holds(*outline)) return {Reason::kOutsideRectangle};
  return {Reason::kRecorded, std::move(*outline)};
}

}  // namespace

bool ShowsWholeSubject(const FrameToDecide& input, const CoverageMap* map) {
  return LookForSubject(input, map).reason == Reason::kRecorded;
}

Decision Decide(const FrameToDecide& input, const CoverageMap* map) {
  const SubjectInView found = LookForSubject(input, map);
  if (found.reason != Reason::kRecorded) return {found.reason, {}};
  const CriterionView candidate =
      CriterionView::From(input.camera, *input.track.cam_from_world, input.coverage_width_px);
  const CoveringView best = map->Best(candidate);
  const std::optional<double> bound_px =
      std::isfinite(best.bound_px) ? std::optional<double>(best.bound_px) : std::nullopt;
  const Eigen::Vector3d direction = (candidate.center_in_world - map->subject().center_in_world).normalized();
  if (bound_px && *bound_px <= map->ThresholdAt(direction)) return {Reason::kCovered, bound_px};
  return {ImageReason(input, found.outline), bound_px};
}

Decision DecideWithoutSubject(const FrameToDecide& input, bool shown_already) {
  const tracking::Track& track = input.track;
  if (!IsTracked(track)) return {};
  if (track.focal_ratio) return {Reason::kZoomed, {}};
  if (const auto sigma = track.PictureSigma(); sigma && *sigma > kMostErrorShare * track.distance) return {};
  if (shown_already) return {Reason::kCovered, {}};
  const double width = input.camera.width, height = input.camera.height;
  return {ImageReason(input, {{0, 0}, {width, height}}), {}};
}

}  // namespace ulf::coverage
