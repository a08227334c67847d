#include "coverage/still_capture.h"

#include <spdlog/spdlog.h>

#include <cmath>
#include <filesystem>
#include <opencv2/imgproc.hpp>

#include "acquisition/calibration/calibration_io.h"
#include "acquisition/error.h"

namespace ulf {

StillCapture::StillCapture(Device& device, const CameraModel& camera, const PoseSource& poses,
                           const DecisionLimits& limits, int coverage_width_px)
    : device_(device),
      camera_(camera),
      poses_(poses),
      limits_(limits),
      coverage_width_px_(coverage_width_px) {}

void StillCapture::Follow(const Frame& live, const Track& track) {
  if (!track.cam_from_world) return;
  live_.push_back({live.device_time_s, *track.cam_from_world,
                   track.speed_px * camera_.width / std::max(1, live.image.width())});
  if (live_.size() > kRemembered) live_.pop_front();
}

void StillCapture::Ask() {
  if (device_.RequestStill() == StillRequest::kAsked) ++counts_.asked;
}

std::optional<Rigid3> StillCapture::LivePoseAt(double time_s) const {
  const LivePose* nearest = nullptr;
  for (const LivePose& pose : live_)
    if (!nearest || std::abs(pose.time_s - time_s) < std::abs(nearest->time_s - time_s)) nearest = &pose;
  return nearest ? std::optional(nearest->cam_from_world) : std::nullopt;
}

// Over several frames: live view's times are those of its arrival, which comes in fits.
double StillCapture::SpeedPxPerS() const {
  constexpr std::size_t kFrames = 8;
  if (live_.size() < 2) return 0;
  const std::size_t first = live_.size() - std::min(live_.size(), kFrames);
  double moved_px = 0;
  for (std::size_t i = first + 1; i < live_.size(); ++i) moved_px += live_[i].speed_px;
  const double seconds = live_.back().time_s - live_[first].time_s;
  return seconds > 0 ? moved_px / seconds : 0;
}

bool StillCapture::HasTheSize(const Frame& still) {
  if (still.image.width() == camera_.width && still.image.height() == camera_.height) return true;
  if (!said_size_)
    spdlog::warn(
        "a photograph is {}x{}, the calibration's still mode is for {}x{}: such photographs are kept in "
        "unposed/; set the camera's image size back, or calibrate with --mode still",
        still.image.width(), still.image.height(), camera_.width, camera_.height);
  said_size_ = true;
  return false;
}

StillVerdict StillCapture::Judge(const Frame& still, const CoverageMap* map) {
  ++counts_.arrived;
  StillVerdict verdict;
  if (still.status == FrameStatus::kComplete && HasTheSize(still))
    verdict.track = poses_.Locate(still, camera_, LivePoseAt(still.device_time_s));
  if (!verdict.track) {
    ++counts_.without_pose;
    return verdict;
  }
  // It was exposed while the live image moved at this speed.
  verdict.track->speed_px = SpeedPxPerS();
  verdict.decision = Decide({.frame = still,
                             .track = *verdict.track,
                             .camera = camera_,
                             .frame_period_s = 1,
                             .coverage_width_px = coverage_width_px_},
                            map, limits_);
  ++(verdict.decision.reason == Reason::kRecorded ? counts_.recorded : counts_.not_needed);
  return verdict;
}

ResolvedCalibration ResolveStillCamera(const Device& device, const IntrinsicsArgs& args) {
  try {
    // Live view's focal length in pixels says nothing of the photographs.
    return ResolveCalibration(device, {.calibration_path = args.calibration_path, .force = args.force}, 0, 0,
                              "still");
  } catch (const Error& error) {
    throw Error(
        "{}; the photographs' intrinsics are needed besides live view's: ulf calibrate {} --mode still",
        error.what(), device.Info().uri);
  }
}

Image AsSeenBy(const CameraModel& camera, const Image& photograph, const CameraModel& photograph_camera) {
  // Reduced first, so that the resampling below skips no pixels.
  const double share = std::min(1.0, camera.MeanFocalPx() / photograph_camera.MeanFocalPx());
  const CameraModel reduced =
      photograph_camera.ScaledTo(static_cast<int>(std::lround(share * photograph_camera.width)),
                                 static_cast<int>(std::lround(share * photograph_camera.height)));
  cv::Mat small;
  cv::resize(photograph.pixels, small, {reduced.width, reduced.height}, 0, 0, cv::INTER_AREA);
  cv::Mat map(camera.height, camera.width, CV_32FC2, cv::Scalar(-1e6, -1e6));
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u)
      if (const auto ray = camera.RayFromImg({u + 0.5, v + 0.5}))
        if (const auto img = reduced.ImgFromCam(*ray))
          map.at<cv::Vec2f>(v, u) = {static_cast<float>(img->x() - 0.5), static_cast<float>(img->y() - 0.5)};
  Image seen = photograph;
  cv::remap(small, seen.pixels, map, {}, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return seen;
}

}  // namespace ulf
