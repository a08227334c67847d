#include "tests/support/staged_capture.h"

#include <algorithm>
#include <array>
#include <map>
#include <random>
#include <utility>

#include "coverage/session/preflight.h"
#include "tests/support/floors.h"
#include "tracking/tracker/track.h"

namespace ulf::test {
namespace {

using Eigen::Vector3d;

SimulationOptions Simulation(const StageOptions& options) {
  SimulationOptions simulation;
  simulation.width = options.width;
  simulation.height = options.height;
  simulation.looks_away = false;
  simulation.noise = false;
  return simulation;
}

// One of each size for all stages of a program.
const SimulatedCamera& SharedCamera(const StageOptions& options) {
  static std::map<std::pair<int, int>, SimulatedCamera> cameras;
  const auto [camera, is_new] = cameras.try_emplace({options.width, options.height}, Simulation(options));
  return camera->second;
}

// Ray casting takes time, and stages stand in few places.
cv::Mat PictureFrom(const SimulatedCamera& camera, const Rigid3& cam_from_world) {
  using Pose = std::array<double, 9>;
  static std::map<Pose, cv::Mat> pictures;
  const Vector3d& t = cam_from_world.translation;
  const Eigen::Quaterniond& q = cam_from_world.rotation;
  cv::Mat& picture =
      pictures[{static_cast<double>(camera.camera().width), static_cast<double>(camera.camera().height),
                t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()}];
  if (picture.empty()) picture = camera.CleanSrgb(cam_from_world);
  return picture.clone();
}

}  // namespace

StagedCapture::StagedCapture(const StageOptions& options)
    : options_(options),
      simulated_(SharedCamera(options)),
      subject_(simulated_.scene().subject()),
      frame_(simulated_.scene().FirstDirection(), simulated_.scene().UpInWorld()),
      grey_(options.height, options.width, CV_8UC3, cv::Scalar::all(kGrey)) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 600; ++i) {
    const Vector3d direction = Vector3d(normal(random), normal(random), normal(random)).normalized();
    points_.push_back(subject().center_in_world + subject().radius * (0.5 + 2 * (i % 3)) * direction);
  }
}

Rigid3 StagedCapture::CameraAt(double azimuth_deg, double elevation_deg, double distance,
                               const Eigen::Vector2d& aside) const {
  const Vector3d center = subject().center_in_world;
  const Vector3d at =
      center + distance * frame_.Direction(azimuth_deg * M_PI / 180, elevation_deg * M_PI / 180);
  const Rigid3 aimed = LookAt(at, center, frame_.Up());
  return LookAt(at, center + aimed.DirectionInSource({aside.x(), aside.y(), 0}), frame_.Up());
}

std::shared_ptr<CaptureState> StagedCapture::At(const Rigid3& cam_from_world) const {
  auto state = std::make_shared<CaptureState>();
  state->frames = 100 + recorded_.size();
  state->device_time_s = 0.1 * static_cast<double>(state->frames);
  state->frames_per_s = 30;
  state->camera = camera();
  state->recorded_camera = camera();
  state->live.transfer = Transfer::kSrgb;
  state->live.pixels = options_.rendered ? PictureFrom(simulated_, cam_from_world) : grey_;
  state->tracking = TrackState::kTracking;
  state->cam_from_world = cam_from_world;
  for (const Vector3d& point : points_) {
    const auto img = camera().ImgFromCam(cam_from_world * point);
    if (img && camera().Contains(*img)) state->points.push_back({point, *img, (cam_from_world * point).z()});
  }
  state->subject = subject();
  state->coverage = std::make_shared<CoverageMap>(map_ ? *map_ : NewMap());
  state->view_ids = ids_;
  state->newest_view = newest_;
  if (options_.cap && map_) state->covered = map_->CoveredShare();
  state->decision.reason = Reason::kCovered;
  state->disk_left_bytes = 212'000'000'000;
  state->exposure_locked = true;
  state->preflight = Preflight({.calibrated = true,
                                .calibration_source = "the device sim:studio",
                                .held = {.exposure = true, .white_balance = true, .focus = {}},
                                .prediction = {},
                                .bytes_per_view = 2'000'000,
                                .disk_left_bytes = state->disk_left_bytes,
                                .pose_error_px = 0.2});
  return state;
}

std::shared_ptr<CaptureState> StagedCapture::Record(const Rigid3& cam_from_world) {
  if (!map_) map_ = std::make_shared<CoverageMap>(NewMap());
  map_->Add(CriterionView::From(camera(), cam_from_world, 640));
  ids_.push_back(++last_id_);
  auto state = At(cam_from_world);
  state->recorded_view = ids_.back();
  Frame frame;
  frame.image = state->live;
  newest_ = std::make_shared<RecordedFrame>(RecordedFrame{ids_.back(), frame, camera(), cam_from_world});
  state->newest_view = newest_;
  state->decision.reason = Reason::kRecorded;
  recorded_.push_back(state);
  return state;
}

void StagedCapture::RecordRows(double from_azimuth_deg, double to_azimuth_deg, double from_elevation_deg,
                               double to_elevation_deg, double step_deg, double distance) {
  for (double elevation = from_elevation_deg; elevation <= to_elevation_deg; elevation += step_deg)
    for (double azimuth = from_azimuth_deg; azimuth <= to_azimuth_deg; azimuth += step_deg)
      Record(CameraAt(azimuth, elevation, distance));
}

CoverageMap StagedCapture::NewMap() const {
  return CoverageMap(
      subject_, {.cap = options_.cap, .up_in_world = frame_.Up(), .threshold_px = options_.threshold_px});
}

void StagedCapture::TakeBack(int id) {
  const auto found = std::find(ids_.begin(), ids_.end(), id);
  std::vector<CriterionView> views = map_->views();
  views.erase(views.begin() + (found - ids_.begin()));
  ids_.erase(found);
  map_ = std::make_shared<CoverageMap>(map_->subject(), map_->options(), views);
}

void StagedCapture::PlaceSubject(const Subject& subject) {
  subject_ = subject;
  map_ = std::make_shared<CoverageMap>(subject, map_->options(), map_->views());
}

std::shared_ptr<CaptureState> StagedCapture::Lost() const {
  auto state = At(CameraAt(0, 0));
  state->tracking = TrackState::kLost;
  Track track;
  track.state = TrackState::kLost;
  state->tracking_words = InWords(track, FrameSource::kCamera);
  state->cam_from_world.reset();
  state->points.clear();
  state->decision.reason = Reason::kTracking;
  return state;
}

}  // namespace ulf::test
