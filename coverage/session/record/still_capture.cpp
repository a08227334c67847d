#include "coverage/session/record/still_capture.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"
#include "core/base/quantile.h"
#include "core/base/shell_word.h"

namespace ulf::coverage {

namespace {

// Guessed.
constexpr double kStillRemembered_s = 20;       // of live poses: photographs may be long in coming
constexpr double kStillLiveViewGoesOn_s = 0.5;  // so long after a photograph its lag is measured
constexpr double kStillLongestLag_s = 5;        // no shutter takes longer
// Over which the hand's speed is measured: single arrival times of live view are irregular.
constexpr std::size_t kStillSpeedFrames = 8;

constexpr double kSearchStep_s = 0.002;  // between the places that are looked at
// A place this far from the nearest in time must be farther off by more than.
constexpr double kSearchTellsApart_s = 0.05;
constexpr double kSearchPoseError = 0.002;  // radians: a photograph's pose against live frames', guessed

// Returns how far apart two poses are, as an angle at a subject `distance` away.
double PoseAngle(const Rigid3& a, const Rigid3& b, double distance) {
  return std::hypot(RotationAngle(a.rotation * b.rotation.conjugate()),
                    (a.OriginInSource() - b.OriginInSource()).norm() / distance);
}

}  // namespace

std::optional<double> TimeOnTrajectory(std::span<const LivePose> trajectory, const Rigid3& cam_from_world,
                                       double distance) {
  struct Sample {
    double time_s, angle;
  };
  std::vector<Sample> samples;
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    const LivePose &a = trajectory[i - 1], &b = trajectory[i];
    const int steps = std::clamp(static_cast<int>((b.time_s - a.time_s) / kSearchStep_s), 1, 1000);
    for (int k = i == 1 ? 0 : 1; k <= steps; ++k) {
      const double share = static_cast<double>(k) / steps;
      samples.push_back(
          {a.time_s + share * (b.time_s - a.time_s),
           PoseAngle(Interpolated(a.cam_from_world, b.cam_from_world, share), cam_from_world, distance)});
    }
  }
  if (samples.empty()) return std::nullopt;
  const auto nearest = std::ranges::min_element(samples, {}, &Sample::angle);
  if (nearest == samples.begin() || nearest + 1 == samples.end()) return std::nullopt;
  for (const Sample& sample : samples)
    if (std::abs(sample.time_s - nearest->time_s) > kSearchTellsApart_s &&
        sample.angle < nearest->angle + kSearchPoseError)
      return std::nullopt;
  return nearest->time_s;
}

StillCapture::StillCapture(acquisition::Device& device, const CameraModel& camera,
                           const tracking::PoseSource& poses, int coverage_width_px)
    : device_(device), camera_(camera), poses_(poses), coverage_width_px_(coverage_width_px) {}

void StillCapture::Follow(const Frame& live, const tracking::Track& track) {
  if (!track.cam_from_world) return;
  live_.push_back({live.device_time_s, *track.cam_from_world,
                   track.speed_px * camera_.width / std::max(1, live.image.width())});
  while (live.device_time_s - live_.front().time_s > kStillRemembered_s) live_.pop_front();
  MeasureLags();
}

// Live view stops during a photograph: a lag is measured when live view has gone on for a while.
void StillCapture::MeasureLags() {
  while (!unmeasured_.empty() &&
         live_.back().time_s > unmeasured_.front().judged_s + kStillLiveViewGoesOn_s) {
    const Unmeasured still = unmeasured_.front();
    unmeasured_.pop_front();
    std::vector<LivePose> since;
    for (const LivePose& pose : live_)
      if (pose.time_s > still.requested_s - kStillLiveViewGoesOn_s &&
          pose.time_s < still.requested_s + kStillLongestLag_s)
        since.push_back(pose);
    const auto taken_s = TimeOnTrajectory(since, still.cam_from_world, still.distance);
    if (!taken_s) continue;
    lags_s_.push_back(*taken_s - still.requested_s);
    counts_.lags = lags_s_.size();
    counts_.lag_s = Median(lags_s_);
  }
}

// If the device was given a lag, its time contains it.
double StillCapture::ExpectedTime(const Frame& still) const {
  const bool contains_lag = !still.requested_s || still.device_time_s != *still.requested_s;
  return contains_lag ? still.device_time_s : *still.requested_s + counts_.lag_s.value_or(0);
}

void StillCapture::RequestStill() {
  if (device_.RequestStill() == acquisition::StillRequest::kAsked) ++counts_.asked;
}

std::optional<Rigid3> StillCapture::LivePoseAt(double time_s) const {
  const auto nearest = std::ranges::min_element(
      live_, {}, [&](const LivePose& pose) { return std::abs(pose.time_s - time_s); });
  return nearest == live_.end() ? std::nullopt : std::optional(nearest->cam_from_world);
}

double StillCapture::SpeedPxPerS() const {
  if (live_.size() < 2) return 0;
  const std::size_t first = live_.size() - std::min(live_.size(), kStillSpeedFrames);
  double moved_px = 0;
  for (std::size_t i = first + 1; i < live_.size(); ++i) moved_px += live_[i].speed_px;
  const double seconds = live_.back().time_s - live_[first].time_s;
  return seconds > 0 ? moved_px / seconds : 0;
}

bool StillCapture::HasExpectedSize(const Frame& still) const {
  return still.image.width() == camera_.width && still.image.height() == camera_.height;
}

std::optional<tracking::Track> StillCapture::Find(const Frame& still) const {
  if (still.status != FrameStatus::kComplete || !HasExpectedSize(still)) return std::nullopt;
  return poses_.Locate(still, camera_, LivePoseAt(ExpectedTime(still)));
}

StillVerdict StillCapture::Judge(const Frame& still, const CoverageMap* map) const {
  StillVerdict verdict;
  verdict.track = Find(still);
  if (!verdict.track) return verdict;
  if (map) verdict.distance = (*verdict.track->cam_from_world * map->subject().center_in_world).norm();
  // The live image moved at this speed during the exposure.
  verdict.track->speed_px = SpeedPxPerS();
  verdict.decision = Decide({.frame = still,
                             .track = *verdict.track,
                             .camera = camera_,
                             .frame_period_s = 1,
                             .coverage_width_px = coverage_width_px_},
                            map);
  return verdict;
}

void StillCapture::NoteArrived(const Frame& still, bool is_found) {
  ++counts_.arrived;
  counts_.without_pose += !is_found;
  if (said_size_ || still.status != FrameStatus::kComplete || HasExpectedSize(still)) return;
  said_size_ = true;
  spdlog::warn(
      "a photograph is {}x{}, the calibration's still mode is for {}x{}: such photographs are kept in "
      "unposed/; set the camera's image size back, or calibrate with {} still",
      still.image.width(), still.image.height(), camera_.width, camera_.height, Parameter("mode"));
}

void StillCapture::Note(const Frame& still, const StillVerdict& verdict) {
  NoteArrived(still, verdict.track.has_value());
  if (!verdict.track) return;
  ++(verdict.decision.reason == Reason::kRecorded ? counts_.recorded : counts_.not_needed);
  if (still.requested_s && verdict.distance && !live_.empty())
    unmeasured_.push_back({*still.requested_s, std::max(live_.back().time_s, *still.requested_s),
                           *verdict.track->cam_from_world, *verdict.distance});
}

acquisition::ResolvedCalibration ResolveStillCamera(const acquisition::Device& device,
                                                    const acquisition::IntrinsicsArgs& args) {
  try {
    // A focal length in pixels of live view does not apply to photographs.
    return acquisition::ResolveCalibration(
        device, {.calibration_path = args.calibration_path, .force = args.force}, 0, 0, "still");
  } catch (const Error& error) {
    throw Error("{}; photographs need intrinsics of their own, besides those of live view{}", error.what(),
                IsTaken(device.Source())
                    ? " (a file of ulf calibrate --mode still)"
                    : fmt::format(": ulf calibrate {} --mode still", ShellWord(device.Info().uri)));
  }
}

Image AsSeenBy(const CameraModel& camera, const Image& photograph, const CameraModel& photograph_camera) {
  // Reduces first, so that the resampling below skips no pixels.
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

}  // namespace ulf::coverage
