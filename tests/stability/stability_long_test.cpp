// What only many seeds, real captures or many frames can show: starts that are right every time, poses never
// wrong without saying so, and nothing that grows with time.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <opencv2/core.hpp>

#include "acquisition/calibration/calibration_io.h"
#include "acquisition/opening/open_device.h"
#include "tests/stability/situations.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf {
namespace {

using test::MedianDepth;
using test::PosePair;
using test::TexturedRoom;
using test::WorstOf;

struct Sequence {
  int first_tracked = -1;
  std::vector<PosePair> poses;
};

std::optional<Rigid3> NearestIn(const std::vector<TimedPose>& truth, double time_s) {
  const auto near = std::min_element(truth.begin(), truth.end(), [&](const TimedPose& a, const TimedPose& b) {
    return std::abs(a.time_s - time_s) < std::abs(b.time_s - time_s);
  });
  if (near == truth.end() || std::abs(near->time_s - time_s) > 1.0 / 60) return std::nullopt;
  return near->cam_from_world;
}

Sequence Follow(const std::string& uri, const std::optional<CameraModel>& camera,
                const std::vector<TimedPose>& truth, int frames, unsigned seed) {
  const auto device = OpenDevice(uri);
  device->Start();
  Tracker tracker(camera ? *camera : *device->Camera(), {.deterministic = true, .seed = seed});
  Sequence sequence;
  for (int k = 0; k < frames; ++k) {
    const auto frame = device->Next(std::chrono::milliseconds(5000));
    if (!frame) break;
    const Track track = tracker.Step(*frame);
    if (!track.cam_from_world) continue;
    if (sequence.first_tracked < 0) sequence.first_tracked = k;
    const auto known = truth.empty() ? frame->known_cam_from_world : NearestIn(truth, frame->device_time_s);
    if (known)
      sequence.poses.push_back({k, track.map_id, *track.cam_from_world, *known, MedianDepth(tracker)});
  }
  return sequence;
}

constexpr double kWrong = 0.03;  // of the distance
constexpr unsigned kSeeds = 10;

// The first frames on their own: a start that is wrong in scale or plane shows before later ones mend it.
void ExpectRight(const Sequence& sequence, int start_by, int least_poses, const std::string& label) {
  SCOPED_TRACE(label + ", started at " + std::to_string(sequence.first_tracked));
  ASSERT_GE(sequence.first_tracked, 0);
  EXPECT_LE(sequence.first_tracked, start_by);
  ASSERT_GE(static_cast<int>(sequence.poses.size()), least_poses);
  constexpr int kStart = 100;
  std::vector<PosePair> start;
  for (const PosePair& pose : sequence.poses)
    if (pose.frame < sequence.first_tracked + kStart) start.push_back(pose);
  ASSERT_GE(start.size(), 7u);
  EXPECT_LT(WorstOf(start, 0).center, kWrong);
  const auto worst = WorstOf(sequence.poses, 0);
  EXPECT_LT(worst.center, kWrong) << "frame " << worst.frame;
  EXPECT_LT(worst.turn_deg, 2.5);
  std::printf("%s: started at %d, worst of the first hundred frames %.4f, of all %zu %.4f (%.2f degrees)\n",
              label.c_str(), sequence.first_tracked, WorstOf(start, 0).center, sequence.poses.size(),
              worst.center, worst.turn_deg);
}

// The reference has a pose for every twelfth frame.
TEST(StabilityLong, KitchenStartsSoonAndIsNeverWrong) {
  ULF_NEED_TEST_DATA(folder, "handheld_kitchen");
  const auto truth = ReadTum(folder / "colmap_reference.txt");
  const CameraModel camera = ReadCalibration(folder / "intrinsics.txt");
  for (unsigned seed = 1; seed <= kSeeds; ++seed)
    ExpectRight(Follow("replay:" + folder.string() + "?glob=*.color.jpg", camera, truth, 250, seed), 30, 17,
                "kitchen, seed " + std::to_string(seed));
}

TEST(StabilityLong, ScanStartsAtOnceAndIsNeverWrong) {
  ULF_NEED_TEST_DATA(folder, "scan_synthetic");
  const auto truth = ReadTum(folder / "groundtruth.txt");
  const CameraModel camera = ReadCalibration(folder / "intrinsics.txt");
  for (unsigned seed = 1; seed <= kSeeds; ++seed)
    ExpectRight(Follow("replay:" + folder.string() + "?glob=*.jpg", camera, truth, 100, seed), 30, 70,
                "scan, seed " + std::to_string(seed));
}

TEST(StabilityLong, SimulatedStudioIsNeverWrong) {
  for (unsigned seed = 1; seed <= kSeeds; ++seed)
    ExpectRight(Follow("sim:studio?seed=" + std::to_string(seed), {}, {}, 250, seed), 40, 190,
                "studio, seed " + std::to_string(seed));
}

std::string BytesOf(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

// With the mapper, a glance away and the way back.
TEST(StabilityLong, TheSameRunTwiceGivesTheSameBytes) {
  const test::ScratchFolder folder;
  std::vector<std::string> live, final;
  for (const char* name : {"a", "b"}) {
    const std::string live_file = (folder / (std::string(name) + ".live")).string();
    const std::string final_file = (folder / (std::string(name) + ".final")).string();
    const auto run = test::RunUlf("track 'sim:studio?seed=4&fps=15' --frames 400 --deterministic -o " +
                                  live_file + " --final " + final_file);
    ASSERT_EQ(run.exit_code, 0) << run.errors;
    live.push_back(BytesOf(live_file));
    final.push_back(BytesOf(final_file));
  }
  EXPECT_GT(live[0].size(), 4000u);
  EXPECT_EQ(live[0], live[1]);
  EXPECT_EQ(final[0], final[1]);
  EXPECT_NE(live[0], final[0]);
}

double ResidentMiB() {
  std::ifstream statm("/proc/self/statm");
  long total = 0, resident = 0;
  statm >> total >> resident;
  return static_cast<double>(resident) * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1 << 20);
}

double MedianOf(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<long>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

// A hand that goes to and fro before the same subject: pictures from a cache, each time with new noise.
TEST(StabilityLong, AnHourNeitherGrowsNorSlowsDown) {
  constexpr int kFrames = 15 * 3600, kPictures = 300, kNoises = 31, kTenth = kFrames / 10;
  const CameraModel camera = TexturedRoom::Camera().ScaledTo(320, 240);
  const TexturedRoom room({.noise = 0});
  std::vector<Frame> pictures;
  for (int k = 0; k < kPictures; ++k)
    pictures.push_back(room.Take(TexturedRoom::HandAt(k), static_cast<std::uint64_t>(k), camera));
  cv::RNG random(7);
  std::vector<cv::Mat> noises;
  for (int i = 0; i < kNoises; ++i) {
    noises.emplace_back(camera.height, camera.width, CV_8S);
    random.fill(noises.back(), cv::RNG::NORMAL, 0, 2);
  }
  Tracker tracker(camera, {.deterministic = true, .features = 600});
  std::vector<double> first_cpu_s, last_cpu_s;
  std::vector<TrackerStatistics> sizes;
  std::vector<double> resident_mib;
  int tracked = 0;
  for (int k = 0; k < kFrames; ++k) {
    const int phase = k % (2 * kPictures - 2);
    Frame frame = pictures[static_cast<std::size_t>(phase < kPictures ? phase : 2 * kPictures - 2 - phase)];
    cv::Mat noisy;
    cv::add(frame.image.pixels, noises[random.next() % kNoises], noisy, {}, CV_8U);
    frame.image.pixels = noisy;
    frame.id = static_cast<std::uint64_t>(k);
    frame.device_time_s = k / 15.0;
    const Track track = tracker.Step(frame);
    tracked += track.cam_from_world.has_value();
    // The first tenth proper is still learning the subject.
    if (k >= kTenth && k < 2 * kTenth) first_cpu_s.push_back(track.cpu_s);
    if (k >= kFrames - kTenth) last_cpu_s.push_back(track.cpu_s);
    if ((k + 1) % kTenth) continue;
    sizes.push_back(tracker.Statistics());
    resident_mib.push_back(ResidentMiB());
    std::printf("frame %d: %d keyframes, %d points, %.1f MiB resident\n", k + 1, sizes.back().keyframes,
                sizes.back().map_points, resident_mib.back());
  }
  const double ratio = MedianOf(last_cpu_s) / MedianOf(first_cpu_s);
  std::printf("CPU a frame: %.2f ms in the second tenth, %.2f in the last: ratio %.2f; %d of %d tracked\n",
              1000 * MedianOf(first_cpu_s), 1000 * MedianOf(last_cpu_s), ratio, tracked, kFrames);
  EXPECT_GE(tracked, kFrames - 60);
  EXPECT_LT(ratio, 1.25);
  EXPECT_LE(sizes.back().keyframes, 1.5 * sizes[1].keyframes);
  EXPECT_LE(sizes.back().map_points, 1.5 * sizes[1].map_points);
  // 43,200 frames; 1 KiB each would be too much over hours.
  EXPECT_LT(resident_mib.back() - resident_mib[1], 40);
}

}  // namespace
}  // namespace ulf
