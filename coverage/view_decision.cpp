#include "coverage/view_decision.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "coverage/sphere_outline.h"

namespace ulf {
namespace {

struct ReasonTexts {
  const char* name;
  const char* words;
};
// In the order of Reason.
constexpr std::array<ReasonTexts, kReasons.size()> kTexts{{
    {"recorded", "recorded"},
    {"covered", "covered already"},
    {"outside_rectangle", "subject outside the safety rectangle"},
    {"behind", "subject behind the camera"},
    {"inside_sphere", "camera inside the subject"},
    {"tracking", "looking for the camera's position"},
    {"blur", "blurred"},
    {"exposure", "badly exposed"},
    {"speed", "too fast"},
    {"spool", "waiting for a slow disk"},
    {"disk", "the disk is full"},
    {"still", "a photograph is being taken"},
    {"paused", "recording is paused"},
}};

// A pixel's brightest channel, display-encoded, 0 to 1.
float Brightness(const Image& image, int x, int y) {
  const cv::Mat& pixels = image.pixels;
  const int channels = pixels.channels();
  float brightest = 0;
  for (int c = 0; c < channels; ++c) {
    const int i = x * channels + c;
    float value;
    if (pixels.depth() == CV_8U)
      value = static_cast<float>(pixels.ptr<std::uint8_t>(y)[i]) / 255.0f;
    else if (pixels.depth() == CV_16U)
      value = static_cast<float>(pixels.ptr<std::uint16_t>(y)[i]) / 65535.0f;
    else
      value = pixels.ptr<float>(y)[i];
    brightest = std::max(brightest, value);
  }
  return image.transfer == Transfer::kLinear ? SrgbFromLinear(brightest) : brightest;
}

bool IsWellExposed(const Image& image, const std::vector<Eigen::Vector2d>& outline,
                   const DecisionLimits& limits) {
  Eigen::Vector2d low = outline[0], high = outline[0];
  for (const Eigen::Vector2d& corner : outline) {
    low = low.cwiseMin(corner);
    high = high.cwiseMax(corner);
  }
  constexpr float kClipped = 0.995f;
  constexpr int kSamplesAcross = 40;
  const double step = std::max(1.0, (high - low).maxCoeff() / kSamplesAcross);
  const Eigen::Vector2d middle = 0.5 * (low + high), half = 0.5 * (high - low);
  std::vector<float> values;
  std::size_t clipped = 0;
  for (double v = low.y(); v < high.y(); v += step)
    for (double u = low.x(); u < high.x(); u += step) {
      const Eigen::Vector2d from_middle = (Eigen::Vector2d(u, v) - middle).cwiseQuotient(half);
      if (from_middle.squaredNorm() > 1) continue;
      const int x = std::clamp(static_cast<int>(u), 0, image.width() - 1);
      const int y = std::clamp(static_cast<int>(v), 0, image.height() - 1);
      values.push_back(Brightness(image, x, y));
      clipped += values.back() >= kClipped;
    }
  if (values.empty()) return true;
  if (static_cast<double>(clipped) > limits.max_clipped_share * static_cast<double>(values.size()))
    return false;
  const auto bright = values.begin() + static_cast<std::ptrdiff_t>(0.9 * static_cast<double>(values.size()));
  std::nth_element(values.begin(), bright, values.end());
  return *bright >= limits.min_brightest;
}

double MotionBlurPx(const FrameToDecide& input) {
  if (input.frame_period_s <= 0 || input.frame.exposure_s <= 0) return 0;
  const double scale = static_cast<double>(input.coverage_width_px) / input.camera.width;
  return input.track.speed_px * scale * input.frame.exposure_s / input.frame_period_s;
}

}  // namespace

const char* Name(Reason reason) { return kTexts[static_cast<std::size_t>(reason)].name; }
const char* InWords(Reason reason) { return kTexts[static_cast<std::size_t>(reason)].words; }

std::string InWords(const std::string& name) {
  const auto known =
      std::find_if(kTexts.begin(), kTexts.end(), [&](const auto& text) { return name == text.name; });
  return known == kTexts.end() ? name : known->words;
}

Decision Decide(const FrameToDecide& input, const CoverageMap* map, const DecisionLimits& limits) {
  const Track& track = input.track;
  const bool tracked = track.state == TrackState::kTracking && !track.skipped && track.cam_from_world &&
                       track.quality >= limits.min_tracking_quality;
  if (!tracked || !map) return {Reason::kTracking, {}};

  const Rigid3& cam_from_world = *track.cam_from_world;
  const Subject& subject = map->subject();
  const Eigen::Vector3d center_in_cam = cam_from_world * subject.center_in_world;
  if (center_in_cam.norm() <= subject.radius) return {Reason::kInsideSphere, {}};
  if (center_in_cam.z() <= 0) return {Reason::kBehind, {}};
  const auto outline = SphereOutline(input.camera, cam_from_world, subject);
  if (!outline || !SafetyRectangle::Of(input.camera, limits.rectangle_share).Holds(*outline))
    return {Reason::kOutsideRectangle, {}};

  const CoveringView best =
      map->Best(CriterionView::From(input.camera, cam_from_world, input.coverage_width_px));
  const std::optional<double> bound_px =
      std::isfinite(best.bound_px) ? std::optional<double>(best.bound_px) : std::nullopt;
  if (bound_px && *bound_px <= map->options().threshold_px) return {Reason::kCovered, bound_px};

  if (!IsWellExposed(input.frame.image, *outline, limits)) return {Reason::kExposure, bound_px};
  if (MotionBlurPx(input) > limits.max_motion_blur_px) return {Reason::kSpeed, bound_px};
  if (track.sharpness < limits.min_sharpness) return {Reason::kBlur, bound_px};
  return {Reason::kRecorded, bound_px};
}

}  // namespace ulf
