#include "tests/support/imagined_capture.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <ctime>

#include "acquisition/simulator/simulated_camera.h"
#include "coverage/bound/sphere_outline.h"
#include "tests/support/floors.h"

namespace ulf::test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kDegree = M_PI / 180;
constexpr int kWidth = 640, kHeight = 480;

// The world as a tracker might make it: its own axes, its own unit.
struct TrackedWorld {
  Eigen::Quaterniond rotation{Eigen::AngleAxisd(2.1, Vector3d(0.3, -0.7, 0.6).normalized())};
  Vector3d shift{0.4, -1.1, 2.3};
  double scale = 0.37;

  Vector3d operator*(const Vector3d& in_world) const { return rotation * (scale * in_world) + shift; }
  Rigid3 Pose(const Rigid3& cam_from_world) const {
    const Eigen::Quaterniond turned = cam_from_world.rotation * rotation.conjugate();
    return {turned, -(turned * (*this * cam_from_world.OriginInSource()))};
  }
};

// How far the image moves at the subject's distance: the median over a grid of pixels.
double MotionPx(const CameraModel& camera, const Subject& subject, const Rigid3& before, const Rigid3& now) {
  const double distance = (before * subject.center_in_world).norm();
  std::vector<double> motions;
  for (int i = 1; i <= 3; ++i)
    for (int j = 1; j <= 3; ++j) {
      const Vector2d img(0.25 * i * camera.width, 0.25 * j * camera.height);
      const auto ray = camera.RayFromImg(img);
      const auto moved = ray ? camera.ImgFromCam(now * (before.Inverse() * (distance * *ray))) : std::nullopt;
      if (moved) motions.push_back((*moved - img).norm());
    }
  if (motions.empty()) return 1e9;
  std::nth_element(motions.begin(), motions.begin() + static_cast<std::ptrdiff_t>(motions.size() / 2),
                   motions.end());
  return motions[motions.size() / 2];
}

// Of this thread's own: other programs' work is not guidance's.
double CpuMilliseconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

// Initialising until there is a baseline; lost while the subject is far from the middle.
class ImaginedTracker {
 public:
  TrackState Step(const Rigid3& cam_from_world, const Vector3d& subject_in_world, double time_s) {
    const Vector3d center = cam_from_world.OriginInSource();
    const Vector3d aim = (cam_from_world * subject_in_world).normalized();
    if (!first_) first_ = center;
    if (state_ == TrackState::kInitializing) {
      const double baseline = (center - *first_).norm() / (center - subject_in_world).norm();
      if (baseline > 3 * kDegree && time_s > 1) state_ = TrackState::kTracking;
      return state_;
    }
    if (aim.z() < std::cos(30 * kDegree)) {
      state_ = TrackState::kLost;
      back_s_ = time_s;
    } else if (state_ == TrackState::kLost && aim.z() > std::cos(15 * kDegree)) {  // well in view
      if (time_s - back_s_ > 0.4) state_ = TrackState::kTracking;
    }
    return state_;
  }

 private:
  TrackState state_ = TrackState::kInitializing;
  std::optional<Vector3d> first_;
  double back_s_ = 0;
};

}  // namespace

double ImaginedResult::LeastViews(const Cap& cap) const {
  return cap.SolidAngle() / (1.5 * std::sqrt(3.0) * disc_radius * disc_radius);
}

ImaginedResult RunImagined(const ImaginedCapture& capture) {
  constexpr int kStableFrames = 10;
  const TrackedWorld tracked_world;
  const CameraModel camera = SimulatedIntrinsics(kWidth, kHeight);
  const Vector3d subject_in_world(0.1, -0.2, 0.07), up = Vector3d::UnitZ();
  const Vector3d first_direction = Vector3d(0.2, -0.8, 0.5).normalized();
  const Rigid3 start = LookAt(subject_in_world + first_direction, subject_in_world, up);
  SimulatedOperator person(capture.person, {.cam_from_world = start, .up_in_world = up, .distance = 1});
  ImaginedTracker tracker;
  Guide guide;
  std::unique_ptr<CoverageMap> map;
  std::shared_ptr<const CoverageMap> shown;
  Frame frame;
  frame.image.pixels = cv::Mat(8, 8, CV_8UC3, cv::Scalar(120, 120, 120));
  frame.exposure_s = capture.exposure_s;

  ImaginedResult result;
  result.up = tracked_world.rotation * up;
  int stable = 0;
  std::size_t frames_since_tracked = 0, lost = 0;
  std::optional<Rigid3> before;
  std::optional<Vector3d> dot;
  std::vector<double> ms;
  for (std::uint64_t index = 0;; ++index) {
    const double time_s = static_cast<double>(index) / capture.fps;
    if (time_s > capture.max_seconds) break;
    const Rigid3 truth = person.CamFromWorld(time_s);
    auto state = std::make_shared<CaptureState>();
    state->frames = index + 1;
    state->device_time_s = time_s;
    state->camera = camera;
    state->tracking = tracker.Step(truth, subject_in_world, time_s);
    Track track;
    track.state = state->tracking;
    track.quality = 1;
    if (track.state == TrackState::kTracking) track.cam_from_world = tracked_world.Pose(truth);
    frames_since_tracked += track.state != TrackState::kInitializing;
    lost += track.state == TrackState::kLost;
    stable = track.cam_from_world ? stable + 1 : 0;
    if (!map && stable >= kStableFrames) {
      const Subject subject{tracked_world * subject_in_world,
                            SubjectOnAxis(camera, *track.cam_from_world,
                                          (*track.cam_from_world * (tracked_world * subject_in_world)).z(),
                                          capture.subject_size)
                                .radius};
      result.subject = subject;
      map = std::make_unique<CoverageMap>(
          subject, CoverageMapOptions{.cap = capture.cap, .threshold_px = capture.threshold_px});
      shown = std::make_shared<CoverageMap>(*map);
    }
    std::optional<CriterionView> view;
    if (map && track.cam_from_world) {
      if (before) track.speed_px = MotionPx(camera, map->subject(), *before, *track.cam_from_world);
      view = CriterionView::From(camera, *track.cam_from_world, kWidth);
      const Vector3d now = (view->center_in_world - map->subject().center_in_world).normalized();
      if (dot) result.way += std::acos(std::clamp(dot->dot(now), -1.0, 1.0));
      dot = now;
    }
    before = track.cam_from_world;
    state->cam_from_world = track.cam_from_world;
    state->decision = Decide(
        {.frame = frame, .track = track, .camera = camera, .frame_period_s = 1 / capture.fps}, map.get());
    if (state->decision.reason == Reason::kRecorded) {
      map->Add(*view);
      shown = std::make_shared<CoverageMap>(*map);
    }
    if (map) state->subject = map->subject();
    state->coverage = shown;
    const double asked_ms = CpuMilliseconds();
    state->guidance = guide.Update(map.get(), view, time_s);
    ms.push_back(CpuMilliseconds() - asked_ms);
    if (!capture.person.follows_guidance) state->guidance = {};
    result.seconds = time_s;
    if (map && capture.cap && map->CoveredShare() >= capture.until_share) break;
    person.See(time_s, *state);
  }
  if (!map) return result;
  result.recorded = map->views();
  result.views = map->views().size();
  result.covered = capture.cap ? map->CoveredShare() : 0;
  result.disc_radius = map->spacing() * map->options().cells_per_disc_radius;
  result.lost_share =
      static_cast<double>(lost) / static_cast<double>(std::max<std::size_t>(1, frames_since_tracked));
  result.ms_guidance_most = *std::max_element(ms.begin(), ms.end());
  std::nth_element(ms.begin(), ms.begin() + static_cast<std::ptrdiff_t>(ms.size() / 2), ms.end());
  result.ms_guidance_median = ms[ms.size() / 2];
  return result;
}

}  // namespace ulf::test
