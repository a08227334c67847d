#include "tests/support/growth/capture_growth.h"

#include <cmath>

#include "core/light_field/folder/light_field_writer.h"
#include "tests/support/floors.h"
#include "tests/support/planar_device.h"
#include "tracking/sources/poses_spec.h"

namespace ulf::test {
namespace {

// Rows over the cap, to and fro.
std::vector<PlanarShot> Rows(int views) {
  const int columns = static_cast<int>(std::ceil(std::sqrt(views)));
  const double step = (100 * M_PI / 180) / columns;
  std::vector<PlanarShot> shots;
  for (int i = 0; i < views; ++i) {
    const int row = i / columns, along = i % columns;
    const double azimuth = step * ((row % 2 ? columns - 1 - along : along) - 0.5 * columns);
    const double elevation = step * (row - 0.5 * columns);
    const Eigen::Vector3d eye(std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
                              std::cos(azimuth) * std::cos(elevation));
    shots.push_back({LookAt(eye, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitY())});
  }
  return shots;
}

}  // namespace

LongCapture CaptureManyViews(const std::filesystem::path& light_field, int views, int rows) {
  LongCapture result{CameraModel::Pinhole(320, 240, 300), {}, {}};
  PlanarDevice device(Rows(views), {.camera = result.camera});
  CaptureOptions options;
  options.subject = Subject{Eigen::Vector3d::Zero(), 0.15};
  options.threshold_px = 2.1;  // hardly more than a view's bound with itself: every viewpoint is a view
  GrowthLog log(light_field);
  CaptureHooks hooks;
  hooks.keep_frame = [&](const Frame&) { log.FrameComes(); };
  hooks.after_frame = [&](const SharedCaptureState& state) {
    log.FrameIsDone(*state);
    if (log.frames_in_row() == static_cast<std::size_t>(views / rows)) log.EndRow();
  };
  CaptureHeader header;
  header.camera = result.camera;
  const auto poses = MakeKnownPoseSource(result.camera, options.subject);
  device.Start();
  result.summary = RunCapture(device, result.camera, *poses, LightFieldWriter::Create(light_field, header),
                              options, hooks);
  result.rows = log.rows();
  return result;
}

}  // namespace ulf::test
