#include "tests/charts/tracking_runs.h"

#include <atomic>
#include <cmath>
#include <limits>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <thread>

#include "acquisition/calibration/calibration_io.h"
#include "acquisition/calibration/intrinsics.h"
#include "acquisition/device.h"
#include "acquisition/error.h"
#include "tests/support/test_paths.h"
#include "tracking/quantile.h"
#include "tracking/thread_clock.h"
#include "tracking/trajectory.h"

namespace ulf::test {
namespace {

constexpr int kOrbEvery = 10;  // frames

// A recording with its camera and its true poses.
struct Opened {
  std::unique_ptr<Device> device;
  CameraModel camera;
  std::vector<TimedPose> truth;  // empty: frames bring their own
};

Opened OpenRecording(const std::string& recording, unsigned seed) {
  Opened opened;
  if (recording == "simulator") {
    opened.device = OpenDevice(fmt::format("sim:studio?row_deg=4&seed={}", seed));
    opened.camera = ResolveIntrinsics(*opened.device, {}, 640, 480);
    return opened;
  }
  const auto folder = TestData(recording);
  if (!folder) throw Error("{}: not in the test data; set ULF_TEST_DATA", recording);
  const bool colmap = std::filesystem::exists(*folder / "colmap_reference.txt");
  opened.device = OpenDevice("replay:" + folder->string() + (colmap ? "?glob=*.color.jpg" : "?glob=*.jpg"));
  opened.camera = ReadCalibration(*folder / "intrinsics.txt");
  opened.truth = ReadTum(*folder / (colmap ? "colmap_reference.txt" : "groundtruth.txt"));
  return opened;
}

std::optional<Frame> NextOf(Device& device) {
  while (!IsOver(device.State()))
    if (auto frame = device.Next(std::chrono::milliseconds(1000))) return frame;
  return std::nullopt;
}

double OrbSeconds(const cv::Ptr<cv::ORB>& orb, const cv::Mat& pixels) {
  cv::Mat gray;
  if (pixels.channels() == 1)
    gray = pixels;
  else
    cv::cvtColor(pixels, gray, cv::COLOR_BGR2GRAY);
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;
  const double start = ThreadCpuSeconds();
  orb->detectAndCompute(gray, cv::noArray(), keypoints, descriptors);
  return ThreadCpuSeconds() - start;
}

}  // namespace

bool HasRecording(const std::string& recording) {
  return recording == "simulator" || TestData(recording).has_value();
}

TrackedRun TrackRun(const std::string& recording, const TrackerOptions& options, int frames) {
  Opened opened = OpenRecording(recording, options.seed);
  opened.device->Start();
  Tracker tracker(opened.camera, options);
  const cv::Ptr<cv::ORB> orb = cv::ORB::create(1000);
  std::vector<TimedPose> live, after;
  std::vector<std::pair<double, Anchored>> anchors;
  std::vector<double> cpu_s, orb_s;
  for (int i = 0; i < frames; ++i) {
    const auto frame = NextOf(*opened.device);
    if (!frame) break;
    if (frame->known_cam_from_world && recording == "simulator")
      opened.truth.push_back({frame->device_time_s, *frame->known_cam_from_world});
    if (i % kOrbEvery == 0) orb_s.push_back(OrbSeconds(orb, frame->image.pixels));
    const Track track = tracker.Step(*frame);
    if (!track.cam_from_world) continue;
    cpu_s.push_back(track.cpu_s);
    live.push_back({frame->device_time_s, *track.cam_from_world});
    anchors.emplace_back(frame->device_time_s, *track.anchor);
  }
  tracker.Finish();
  for (const auto& [time_s, anchor] : anchors) after.push_back({time_s, tracker.PoseOf(anchor)});
  const auto error_mm = [&](const std::vector<TimedPose>& poses) {
    const auto error = CompareTrajectories(poses, opened.truth, 1.0 / 60);
    return error ? 1000 * error->ate_rmse : std::numeric_limits<double>::infinity();
  };
  const TrackerStatistics map = tracker.Statistics();
  return {1000 * Median(cpu_s), Median(cpu_s) / Median(orb_s), error_mm(live), error_mm(after), map.keyframes,
          map.map_points};
}

std::vector<TrackedRun> TrackRuns(const std::vector<TrackedCase>& cases) {
  std::vector<TrackedRun> runs(cases.size());
  std::atomic<std::size_t> next = 0;
  const auto work = [&] {
    for (std::size_t i = next++; i < cases.size(); i = next++)
      runs[i] = TrackRun(cases[i].recording, cases[i].options, cases[i].frames);
  };
  std::vector<std::thread> threads;
  for (unsigned i = 0; i < std::max(1u, std::thread::hardware_concurrency()); ++i) threads.emplace_back(work);
  for (std::thread& thread : threads) thread.join();
  return runs;
}

}  // namespace ulf::test
