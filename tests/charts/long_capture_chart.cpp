// A capture of two thousand views in an hour: what it takes of memory, processor and disk as it grows.
#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "core/base/host_time.h"
#include "core/light_field/light_field_io.h"
#include "coverage/session/capture_session.h"
#include "tests/charts/makers.h"
#include "tests/support/floors.h"
#include "tests/support/planar_device.h"
#include "tests/support/test_paths.h"
#include "tracking/sources/pose_source.h"

namespace ulf::test {
namespace {

namespace fs = std::filesystem;

constexpr double kHour_s = 3600;

double ResidentMb() {
  std::ifstream file("/proc/self/statm");
  double pages = 0, resident = 0;
  file >> pages >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

// As `du` counts: blocks that are taken.
double DiskMb(const fs::path& dir) {
  double bytes = 0;
  for (const auto& entry : fs::recursive_directory_iterator(dir))
    if (entry.is_regular_file()) bytes += 4096 * std::ceil(static_cast<double>(entry.file_size()) / 4096);
  return bytes / 1e6;
}

// Rows over a cap of a hundred degrees, to and fro, a frame at each viewpoint.
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

Chart LongCaptureChart(const ChartEffort& effort) {
  const int asked = effort.Of(200, 2000), windows = 20;
  const ScratchFolder scratch;
  const std::vector<PlanarShot> shots = Rows(asked);
  PlanarDeviceOptions camera;
  camera.camera = CameraModel::Pinhole(320, 240, 300);
  camera.fps = static_cast<double>(shots.size()) / kHour_s;
  PlanarDevice device(shots, camera);
  CaptureOptions options;
  options.subject = Subject{Eigen::Vector3d::Zero(), 0.15};
  options.threshold_px = 0.5;  // every viewpoint is a view
  ChartPanel memory{"resident memory", {"views"}, {"[MB]", false, false, false, true}, {}, false};
  ChartPanel time{"time for a frame", {"views"}, {"[ms]", false, false, false, true}, {}, false};
  ChartPanel disk{"on disk", {"views"}, {"[MB]", false, false, false, true}, {}, false};
  std::vector<double> frames_ms;
  auto before = std::chrono::steady_clock::now();
  std::size_t next = 0;
  CaptureHooks hooks;
  hooks.after_frame = [&](const SharedCaptureState& now) {
    const std::size_t views = now->view_ids.size();
    frames_ms.push_back(1000 * SecondsSince(before));
    if (views >= next) {
      next += static_cast<std::size_t>(asked / windows);
      const Spread at = Spread::Exactly(static_cast<double>(views));
      memory.points.push_back({"resident", "", at, Spread::Exactly(ResidentMb())});
      const double used_mb = static_cast<double>(mallinfo2().uordblks + mallinfo2().hblkhd) / 1e6;
      memory.points.push_back({"in use", "", at, Spread::Exactly(used_mb)});
      disk.points.push_back({"light field", "", at, Spread::Exactly(DiskMb(scratch / "lf"))});
      std::error_code missing;
      const double journal_mb =
          static_cast<double>(fs::file_size(scratch / "lf" / "journal.jsonl", missing)) / 1e6;
      disk.points.push_back({"journal", "", at, Spread::Exactly(missing ? 0 : journal_mb)});
      const auto quarters = [](std::vector<double>& ms) {
        std::sort(ms.begin(), ms.end());
        const auto of = [&](double share) {
          return ms[static_cast<std::size_t>(share * static_cast<double>(ms.size() - 1))];
        };
        const Spread spread = ms.empty() ? Spread::Of({}) : Spread{of(0.5), of(0.05), of(0.95)};
        ms.clear();
        return spread;
      };
      time.points.push_back({"frame", "", at, quarters(frames_ms)});
    }
    before = std::chrono::steady_clock::now();
  };
  CaptureHeader header;
  header.camera = camera.camera;
  const auto poses = MakeKnownPoseSource(camera.camera, options.subject);
  device.Start();
  const CaptureSummary summary = RunCapture(device, camera.camera, *poses,
                                            LightFieldWriter::Create(scratch / "lf", header), options, hooks);
  Chart chart;
  chart.title = fmt::format("A capture of {} views in an hour of the camera's time", summary.recorded);
  chart.about = fmt::format(
      "A textured plane at {}x{}, {:.1f} frames a second of the camera's time, as fast as they are "
      "processed; poses known, "
      "every frame becomes a view; no geometry, no display. Bars of the times: 5 % and 95 % of the frames of "
      "a twentieth "
      "of the capture, making the picture of the plane included. {} pauses for the disk, {} views lost.",
      camera.camera.width, camera.camera.height, camera.fps, summary.pauses, summary.unwritten);
  chart.panels = {memory, time, disk};
  return chart;
}

}  // namespace ulf::test
