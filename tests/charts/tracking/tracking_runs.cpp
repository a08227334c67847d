#include "tests/charts/tracking/tracking_runs.h"

#include <atomic>
#include <cmath>
#include <limits>
#include <map>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <thread>
#include <tuple>

#include "acquisition/calibration/calibration_io.h"
#include "acquisition/calibration/intrinsics.h"
#include "acquisition/device/device.h"
#include "acquisition/opening/open_device.h"
#include "core/base/error.h"
#include "core/base/host_time.h"
#include "core/base/quantile.h"
#include "core/geometry/trajectory.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::test {
namespace {

constexpr int kOrbEvery = 10;  // frames

// A recording in memory, with its camera and its true poses.
struct Recording {
  CameraModel camera;
  std::vector<Frame> frames;
  std::vector<TimedPose> truth;
};

std::vector<Frame> FirstFrames(Device& device, int count) {
  std::vector<Frame> frames;
  device.Start();
  while (static_cast<int>(frames.size()) < count && !IsOver(device.State()))
    if (auto frame = device.Next(std::chrono::milliseconds(1000))) frames.push_back(std::move(*frame));
  return frames;
}

Recording ReadRecording(const std::string& name, unsigned seed, int frames, int width) {
  Recording recording;
  if (IsSimulated(name)) {
    const int height = width * 3 / 4;
    const auto device = OpenDevice(fmt::format("{}&seed={}&width={}&height={}", name, seed, width, height));
    recording.camera = ResolveIntrinsics(*device, {}, width, height);
    recording.frames = FirstFrames(*device, frames);
    for (const Frame& frame : recording.frames)
      recording.truth.push_back({frame.device_time_s, *frame.known_cam_from_world});
    return recording;
  }
  const auto folder = TestData(name);
  if (!folder) throw Error("{}: not in the test data; set ULF_TEST_DATA", name);
  const bool colmap = std::filesystem::exists(*folder / "colmap_reference.txt");
  recording.camera = ReadCalibration(*folder / "intrinsics.txt");
  recording.frames = FirstFrames(
      *OpenDevice("replay:" + folder->string() + (colmap ? "?glob=*.color.jpg" : "?glob=*.jpg")), frames);
  recording.truth = ReadTum(*folder / (colmap ? "colmap_reference.txt" : "groundtruth.txt"));
  return recording;
}

// Of a picture that is at most 640 pixels wide: the same unit whatever is done to the pictures.
double OrbSeconds(const cv::Ptr<cv::ORB>& orb, const cv::Mat& picture) {
  constexpr int kWidest = 640;
  cv::Mat gray, pixels = picture;
  if (picture.cols > kWidest)
    cv::resize(picture, pixels, {kWidest, picture.rows * kWidest / picture.cols}, 0, 0, cv::INTER_AREA);
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

Frame Changed(Frame frame, const PictureChange& change, std::uint64_t seed) {
  cv::Mat& pixels = frame.image.pixels;
  if (change.enlarged != 1 || change.blur_px > 0 || change.noise > 0)
    frame.image = {.pixels = GrayForTracking(frame.image), .transfer = Transfer::kSrgb};
  if (change.enlarged != 1) {
    cv::Mat larger;
    cv::resize(pixels, larger, {}, change.enlarged, change.enlarged, cv::INTER_CUBIC);
    pixels = larger;
  }
  if (change.blur_px > 0) {
    cv::Mat blurred;
    cv::GaussianBlur(pixels, blurred, {}, change.blur_px);
    pixels = blurred;
  }
  if (change.noise > 0) {
    cv::Mat noise(pixels.size(), CV_16S), sum;
    cv::RNG(seed).fill(noise, cv::RNG::NORMAL, 0, change.noise);
    cv::add(pixels, noise, sum, {}, CV_8U);
    pixels = sum;
  }
  return frame;
}

TrackedRun TrackRun(const Recording& recording, const TrackedCase& one) {
  const PictureChange& change = one.change;
  const auto changed_px = [&](int px) { return static_cast<int>(std::lround(px * change.enlarged)); };
  CameraModel given =
      recording.camera.ScaledTo(changed_px(recording.camera.width), changed_px(recording.camera.height));
  given.fx *= one.focal_factor;
  given.fy *= one.focal_factor;
  Tracker tracker(given, one.options);
  const cv::Ptr<cv::ORB> orb = cv::ORB::create(1000);
  std::vector<std::pair<double, Track>> tracks;
  std::vector<double> cpu_s, orb_s;
  std::size_t seen = 0;
  double all_s = 0, tracked_s = 0;
  for (auto i = static_cast<std::size_t>(one.first); i < recording.frames.size();
       i += static_cast<std::size_t>(one.every), ++seen) {
    const Frame frame = Changed(recording.frames[i], change, i + 1);
    if (seen % kOrbEvery == 0) orb_s.push_back(OrbSeconds(orb, frame.image.pixels));
    const double before_s = ThreadCpuSeconds();
    const Track track = tracker.Step(frame);
    all_s += ThreadCpuSeconds() - before_s;
    tracked_s += track.cpu_s;
    if (!track.cam_from_world) continue;
    cpu_s.push_back(track.cpu_s);
    tracks.emplace_back(frame.device_time_s, track);
  }
  const double before_s = ThreadCpuSeconds();
  tracker.Finish();
  all_s += ThreadCpuSeconds() - before_s;
  // Poses of a map that was given up, or that is apart, lie in another world.
  std::vector<TimedPose> live, after;
  for (const auto& [time_s, track] : tracks) {
    if (track.map_id == tracks.back().second.map_id) live.push_back({time_s, *track.cam_from_world});
    if (tracker.MapNow(track) == tracker.MapNow(tracks.back().second))
      after.push_back({time_s, *tracker.PoseNow(track)});
  }
  const auto error_mm = [&](const std::vector<TimedPose>& poses) {
    const auto error = CompareTrajectories(poses, recording.truth, 1.0 / 60);
    return error ? 1000 * error->ate_rmse : std::numeric_limits<double>::infinity();
  };
  const TrackerStatistics map = tracker.Statistics();
  return {Median(cpu_s) / Median(orb_s),
          (all_s - tracked_s) / static_cast<double>(seen) / Median(orb_s),
          static_cast<double>(tracks.size()) / static_cast<double>(seen),
          error_mm(live),
          error_mm(after),
          static_cast<double>(map.keyframes),
          static_cast<double>(map.map_points)};
}

}  // namespace

bool HasRecording(const std::string& recording) {
  return IsSimulated(recording) || TestData(recording).has_value();
}

int StartOf(int run, int every) { return 12 * run % every; }

bool IsSimulated(const std::string& recording) { return recording.starts_with("sim:"); }

std::string NameOf(const std::string& recording) { return recording == kStudio ? "simulator" : recording; }

std::vector<TrackedCase> Repeated(const TrackedCase& one, const Effort& effort) {
  std::vector<TrackedCase> cases(effort.Of(1u, 3u), one);
  for (std::size_t run = 0; run < cases.size(); ++run) {
    cases[run].first = StartOf(static_cast<int>(run), one.every);
    if (IsSimulated(one.recording))
      cases[run].options.seed = kFirstSeed + static_cast<unsigned>(run);
    else if (one.every == 1)
      cases[run].options.features += run == 0 ? 0 : run == 1 ? -10 : 10;
  }
  return cases;
}

void AddRuns(const std::vector<TrackedCase>& cases, const std::vector<TrackedRun>& runs,
             double TrackedRun::*cost, double TrackedRun::*error, Table& table) {
  for (std::size_t i = 0; i < cases.size(); ++i)
    table.Add(cases[i].panel, cases[i].series, cases[i].name, runs[i].*cost, runs[i].*error,
              cases[i].is_default);
}

std::vector<TrackedRun> TrackRuns(const std::vector<TrackedCase>& cases) {
  using Key = std::tuple<std::string, unsigned, int, int>;
  const auto key_of = [](const TrackedCase& one) {
    const bool drawn = IsSimulated(one.recording);
    return Key{one.recording, drawn ? one.options.seed : 0, one.frames, drawn ? one.width : 0};
  };
  std::map<Key, Recording> recordings;
  for (const TrackedCase& one : cases)
    if (const Key key = key_of(one); !recordings.contains(key))
      recordings.emplace(key, ReadRecording(one.recording, one.options.seed, one.frames, one.width));

  std::vector<TrackedRun> runs(cases.size());
  std::atomic<std::size_t> next = 0;
  const auto work = [&] {
    for (std::size_t i = next++; i < cases.size(); i = next++)
      runs[i] = TrackRun(recordings.at(key_of(cases[i])), cases[i]);
  };
  std::vector<std::thread> threads;
  for (unsigned i = 0; i < std::max(1u, std::thread::hardware_concurrency()); ++i) threads.emplace_back(work);
  for (std::thread& thread : threads) thread.join();
  return runs;
}

}  // namespace ulf::test
