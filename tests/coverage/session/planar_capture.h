// Captures of a textured plane (planar_device.h), whose poses are known: what the tests of the session share.
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "coverage/session/capture_session.h"
#include "tests/support/floors.h"
#include "tests/support/planar_device.h"
#include "tracking/sources/pose_sources.h"

namespace ulf::test {

using Eigen::Vector3d;

inline double Radians(double degrees) { return degrees * M_PI / 180; }

inline const Subject kSubject{Vector3d::Zero(), 0.15};
inline const CameraModel kCamera = CameraModel::Pinhole(320, 240, 300);  // 600 px in the coverage image
inline const Vector3d kUp = Vector3d::UnitY();

// In front of the plane z = 0, looking at its middle.
inline Rigid3 PoseAt(double azimuth_deg, double elevation_deg, double distance = 1) {
  const double azimuth = Radians(azimuth_deg), elevation = Radians(elevation_deg);
  const Vector3d direction(std::cos(elevation) * std::sin(azimuth), std::sin(elevation),
                           std::cos(elevation) * std::cos(azimuth));
  return LookAt(distance * direction, Vector3d::Zero(), kUp);
}

inline Rigid3 Turned(const Rigid3& cam_from_world, double yaw_deg) {
  const Rigid3 turned_from_cam{Eigen::Quaterniond(Eigen::AngleAxisd(Radians(yaw_deg), Vector3d::UnitY())),
                               {0, 0, 0}};
  return turned_from_cam * cam_from_world;
}

// A hand that sweeps in rows, in steps smaller than a disc.
inline std::vector<PlanarShot> Sweep(double width_deg, double height_deg, double step_deg) {
  std::vector<PlanarShot> shots{{PoseAt(0, 0)}};
  double side = 1;
  for (double elevation = -height_deg / 2; elevation <= height_deg / 2; elevation += step_deg, side = -side)
    for (double azimuth = -width_deg / 2; azimuth <= width_deg / 2; azimuth += step_deg)
      shots.push_back({PoseAt(side * azimuth, elevation)});
  return shots;
}

struct Captured {
  CaptureSummary summary;
  LightField light_field;
};

inline CaptureOptions Options() {
  CaptureOptions options;
  options.subject = kSubject;
  options.deterministic = true;
  return options;
}

inline LightFieldWriter NewWriter(const std::filesystem::path& dir, const CameraModel& camera = kCamera) {
  CaptureHeader header;
  header.camera = camera;
  header.device_uri = "planar:";
  header.threshold_px = 7;
  return LightFieldWriter::Create(dir, header);
}

inline Captured Capture(const std::filesystem::path& dir, std::vector<PlanarShot> shots,
                        const CaptureOptions& options = Options(),
                        const PlanarDeviceOptions& device_options = {}, const CaptureHooks& hooks = {}) {
  PlanarDevice device(std::move(shots), device_options);
  const auto poses = MakeKnownPoseSource(device_options.camera, options.subject);
  device.Start();
  Captured captured;
  captured.summary =
      RunCapture(device, device_options.camera, *poses,
                 std::filesystem::exists(dir / "journal.jsonl") ? LightFieldWriter::Resume(dir)
                                                                : NewWriter(dir, device_options.camera),
                 options, hooks);
  captured.light_field = ReadLightField(dir);
  return captured;
}

inline std::map<std::string, std::uint64_t> Counted(const CaptureSummary& summary) {
  std::map<std::string, std::uint64_t> counted;
  for (const Reason reason : kReasons)
    if (const auto count = summary.reasons[static_cast<std::size_t>(reason)]) counted[Name(reason)] = count;
  return counted;
}

using Counts = std::map<std::string, std::uint64_t>;

// A tracker whose map is adjusted after the fact, with points on the plane.
class DriftingSource : public PoseSource {
 public:
  explicit DriftingSource(const Rigid3& late_from_live) : live_from_late_(late_from_live.Inverse()) {}
  Track Step(const Frame& frame) override {
    Track track;
    track.state = TrackState::kTracking;
    track.cam_from_world = frame.known_cam_from_world;
    track.anchor = Anchored{3, *frame.known_cam_from_world};
    track.quality = 1;
    track.map_revision = revision_;
    last_ = *frame.known_cam_from_world;
    return track;
  }
  std::optional<Track> Locate(const Frame& /*photograph*/, const CameraModel& /*camera*/,
                              const std::optional<Rigid3>& /*near*/) const override {
    return std::nullopt;
  }
  Rigid3 PoseOf(const Anchored& anchor) const override {
    return adjusted_ ? anchor.cam_from_keyframe * live_from_late_ : anchor.cam_from_keyframe;
  }
  std::vector<VisiblePoint> VisiblePoints() const override {
    std::vector<VisiblePoint> points;
    for (double x = -0.9; x < 1; x += 0.1)
      for (double y = -0.9; y < 1; y += 0.1) {
        const Vector3d in_cam = last_ * Vector3d(x, y, 0);
        const auto img = kCamera.ImgFromCam(in_cam);
        if (img && kCamera.Contains(*img)) points.push_back({{x, y, 0}, *img, in_cam.z()});
      }
    return points;
  }
  std::vector<ScenePoint> Points() const override { return {{{0.1, 0.2, 0.3}, {1, 2, 3}}}; }
  bool SeedMap(std::span<const SeedView>, const SeedProgress&) override { return false; }
  void Finish() override { adjusted_ = true; }
  void Adjust(bool tells) {
    adjusted_ = true;
    revision_ += tells;
  }

 private:
  Rigid3 live_from_late_, last_;
  bool adjusted_ = false;
  int revision_ = 0;
};

}  // namespace ulf::test
