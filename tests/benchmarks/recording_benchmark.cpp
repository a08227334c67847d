// How fast frames and views come to the disk, against dd in the same folder and run, and how soon and at what
// cost a frame reaches the tracker. Targets: 0.6 of dd for frames, and for masters through the spool.
//
//   ratio            bytes written a second / what `dd conv=fsync` of as many bytes does, in turns, median of
//                    the turns' ratios. dd writes one file and syncs once; we write one a frame, and sync
//                    every file, its folder and the journal.
//   dd_direct_MBps   `dd oflag=direct conv=fsync`: what the disk does without the page cache (for comparison)
//   tiff_MBps, png_MBps   pixels a second through the encoder alone, one thread
//   pictures_MBps    the photographs of images/ that follow the masters, pixels a second, all threads
//   png_share        bytes of such a file / of its pixels
//
// The folder is ULF_BENCHMARK_DIR, else the system's temporary one: a tmpfs says nothing about a disk.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <thread>

#include "acquisition/device/device.h"
#include "acquisition/device/frame_recording.h"
#include "acquisition/opening/open_device.h"
#include "core/base/error.h"
#include "core/image/files/tiff_file.h"
#include "core/light_field/folder/light_field_writer.h"
#include "coverage/session/record/view_spool.h"
#include "tests/measure/figures.h"
#include "tests/support/child_process.h"
#include "tests/support/floors.h"
#include "tests/support/own_namespaces.h"
#include "tracking/tracker/tracker.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

fs::path Folder() {
  const char* chosen = std::getenv("ULF_BENCHMARK_DIR");
  return (chosen ? fs::path(chosen) : fs::temp_directory_path()) / "ulf_recording_benchmark";
}

// A new empty folder; gone at the end.
class Scratch {
 public:
  Scratch() { fs::remove_all(Folder()), fs::create_directories(Folder()); }
  ~Scratch() { fs::remove_all(Folder()); }
};

// MB/s of dd with as many bytes, synced at its end.
double Dd(std::uint64_t bytes, const char* flags = "") {
  const fs::path file = Folder() / "dd.bin";
  const std::uint64_t megabytes = std::max<std::uint64_t>(1, bytes >> 20);
  const std::string command = fmt::format("dd if=/dev/zero of={} bs=1M count={} conv=fsync {} 2>/dev/null",
                                          file.string(), megabytes, flags);
  const auto start = Clock::now();
  if (std::system(command.c_str()) != 0) throw Error("dd failed in {}", Folder().string());
  const double rate = 1e-6 * static_cast<double>(megabytes << 20) / SecondsSince(start);
  fs::remove(file);
  return rate;
}

// Smooth shapes with a sensor's noise: neither as easy nor as hard to compress as it gets.
cv::Mat Picture(int width, int height, int type) {
  cv::RNG random(11);
  cv::Mat small(height / 32, width / 32, CV_MAKETYPE(CV_16U, CV_MAT_CN(type))), large, noise;
  random.fill(small, cv::RNG::UNIFORM, 4000, 60000);
  cv::resize(small, large, {width, height}, 0, 0, cv::INTER_CUBIC);
  noise.create(large.size(), CV_MAKETYPE(CV_16S, large.channels()));
  random.fill(noise, cv::RNG::NORMAL, 0, 300);
  cv::add(large, noise, large, cv::noArray(), large.type());
  if (CV_MAT_DEPTH(type) == CV_8U) large.convertTo(large, CV_8U, 1.0 / 257);
  return large;
}

Frame FrameOf(const cv::Mat& pixels, std::uint64_t id) {
  Frame frame;
  frame.image.pixels = pixels;
  frame.id = id;
  frame.device_time_s = static_cast<double>(id) / 30;
  if (pixels.depth() == CV_16U) {
    frame.image.transfer = Transfer::kLinear;
    if (pixels.channels() == 1) frame.image.mosaic = Mosaic::kRggb;
  }
  return frame;
}

double Megabytes(const cv::Mat& pixels) {
  return 1e-6 * static_cast<double>(pixels.total() * pixels.elemSize());
}

// Pixels a second, one thread.
template <typename Encode>
double EncodeRate(const cv::Mat& pixels, Encode&& encode) {
  const auto start = Clock::now();
  int rounds = 0;
  for (; rounds < 3 || SecondsSince(start) < 0.3; ++rounds) encode();
  return rounds * Megabytes(pixels) / SecondsSince(start);
}

double TiffRate(const cv::Mat& pixels) {
  std::vector<char> staged(4 << 20);
  return EncodeRate(pixels, [&] {
    const FileContent content = TiffContent(pixels);
    for (std::uint64_t done = 0; done < content.size; done += staged.size())
      content.copy(done,
                   std::span(staged).first(std::min<std::uint64_t>(staged.size(), content.size - done)));
    benchmark::DoNotOptimize(staged.data());
  });
}

// A disk's rate changes from second to second: ours and dd's in turn, and the median of what they come to.
constexpr int kRounds = 7;
constexpr std::uint64_t kBytes = 400 << 20;

struct Rounds {
  std::vector<double> ours, dd, dd_direct, ratios;
  void Add(double rate) {
    ours.push_back(rate);
    dd.push_back(Dd(kBytes));
    dd_direct.push_back(Dd(kBytes, "oflag=direct"));
    ratios.push_back(ours.back() / dd.back());
  }
  void Tell(benchmark::State& state) const {
    state.counters["MBps"] = Median(ours);
    state.counters["dd_MBps"] = Median(dd);
    state.counters["dd_direct_MBps"] = Median(dd_direct);
    state.counters["ratio"] = Median(ratios);
    state.counters["ratio_least"] = Quantile(ratios, 0);
    state.counters["ratio_most"] = Quantile(ratios, 1);
  }
};

// Every frame of a camera: ulf record, capture --keep-frames.
void RecordFrames(benchmark::State& state, int width, int height, int type) {
  const cv::Mat picture = Picture(width, height, type);
  const int count = static_cast<int>(1e-6 * kBytes / Megabytes(picture));
  for ([[maybe_unused]] auto _ : state) {
    Rounds rounds;
    double seconds = 0;
    for (int round = 0; round < kRounds; ++round) {
      const Scratch scratch;
      const auto start = Clock::now();
      FrameRecorder recorder(Folder() / "frames", {});
      for (int i = 0; i < count; ++i)
        while (!recorder.TryAdd(FrameOf(picture, static_cast<std::uint64_t>(i))))
          std::this_thread::sleep_for(std::chrono::milliseconds(1));  // only here: all shall be written
      const FrameRecorderSummary summary = recorder.Finish();
      const double round_s = SecondsSince(start);
      seconds += round_s;
      rounds.Add(1e-6 * static_cast<double>(summary.bytes) / round_s);
    }
    state.SetIterationTime(seconds / kRounds);
    rounds.Tell(state);
    state.counters["fps"] = Median(rounds.ours) / Megabytes(picture);
    state.counters["tiff_MBps"] = TiffRate(picture);
  }
}

// Recorded views. With a master: from the first view to the last one's journal line, all masters on disk; the
// photographs that follow are timed apart. Without: photograph and journal line.
void RecordViews(benchmark::State& state, int width, int height, int type) {
  const cv::Mat picture = Picture(width, height, type);
  const cv::Mat shown = Srgb8(FrameOf(picture, 0).image);
  const bool with_master = type != CV_8UC1;
  const int views = static_cast<int>(1e-6 * kBytes / Megabytes(picture)) / (with_master ? 1 : 4);
  for ([[maybe_unused]] auto _ : state) {
    Rounds rounds;
    std::vector<double> pictures_MBps, views_per_s;
    double seconds = 0, png_share = 0;
    for (int round = 0; round < (with_master ? 5 : 3); ++round) {
      const Scratch scratch;
      CaptureHeader header;
      header.camera = CameraModel::Pinhole(width, height, width);
      LightFieldWriter writer = LightFieldWriter::Create(Folder() / "lf", header);
      writer.KeepMosaics(true);
      const auto start = Clock::now();
      ViewSpool spool(std::move(writer), 16, true);
      for (int i = 0; i < views; ++i)
        while (!spool.TryAddView(FrameOf(picture, static_cast<std::uint64_t>(i)), {}))
          std::this_thread::sleep_for(std::chrono::milliseconds(1));
      while (spool.ViewsWaiting() > 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
      const double recorded_s = SecondsSince(start);
      const std::size_t following = spool.PicturesWaiting();
      const LightFieldWriter done = spool.Finish();
      const double following_s = SecondsSince(start) - recorded_s;
      std::uint64_t bytes = 0, images = 0;
      for (const View& view : done.Contents().views) {
        images += fs::file_size(Folder() / "lf" / view.image_path);
        bytes += fs::file_size(Folder() / "lf" / (with_master ? view.master_path : view.image_path));
      }
      seconds += recorded_s;
      rounds.Add(1e-6 * static_cast<double>(bytes) / recorded_s);
      views_per_s.push_back(views / recorded_s);
      if (with_master)
        pictures_MBps.push_back(static_cast<double>(following) * Megabytes(shown) / following_s);
      png_share = 1e-6 * static_cast<double>(images) / (views * Megabytes(shown));
    }
    state.SetIterationTime(seconds / static_cast<double>(rounds.ours.size()));
    rounds.Tell(state);
    state.counters["views_per_s"] = Median(views_per_s);
    state.counters["pictures_MBps"] = Median(pictures_MBps);
    state.counters["png_share"] = png_share;
    std::vector<unsigned char> png;
    state.counters["png_MBps"] = EncodeRate(shown, [&] { cv::imencode(".png", shown, png); });
    state.counters["tiff_MBps"] = TiffRate(picture);
  }
}

// From the camera's own time of a frame (start of exposure) to the moment the tracker gets it, and to the
// moment it knows the pose; a camera in another process, over GigE Vision on loopback. Its clock is this
// computer's.
void LatencyToTracker(benchmark::State& state, int width, int height, double fps) {
  if (const auto why_not = test::EnterLoopbackNamespace()) {
    state.SkipWithError(why_not->c_str());
    return;
  }
  for ([[maybe_unused]] auto _ : state) {
    test::ChildProcess camera({ULF_BINARY, "simulate", "studio", "--fps", fmt::format("{:g}", fps), "--loop",
                               "40", "--options",
                               fmt::format("width={}&height={}&exposure_us=1000", width, height)});
    camera.ReadUntil("serving", 60);
    const auto device = OpenDevice("aravis:127.0.0.1?format=Mono8");
    device->Start();
    std::optional<Tracker> tracker;
    std::vector<double> arrival_ms, pose_ms;
    double cpu_from_s = 0;
    const auto start = Clock::now();
    constexpr int kWarm = 60, kFrames = 900;
    int frames = 0;
    while (frames < kWarm + kFrames && SecondsSince(start) < 120) {
      const auto frame = device->Next(std::chrono::milliseconds(200));
      if (!frame || frame->status != FrameStatus::kComplete) continue;
      const double arrived_s = EpochSeconds();
      if (!tracker)
        tracker.emplace(
            CameraModel::Pinhole(frame->image.width(), frame->image.height(), frame->image.width()),
            TrackerOptions{});
      tracker->Step(*frame);
      if (++frames == kWarm) cpu_from_s = CpuSeconds();
      if (frames <= kWarm) continue;
      arrival_ms.push_back(1e3 * (arrived_s - frame->device_time_s));
      pose_ms.push_back(1e3 * (EpochSeconds() - frame->device_time_s));
    }
    state.SetIterationTime(SecondsSince(start));
    state.counters["to_tracker_ms_median"] = Quantile(arrival_ms, 0.5);
    state.counters["to_tracker_ms_p99"] = Quantile(arrival_ms, 0.99);
    state.counters["to_pose_ms_median"] = Quantile(pose_ms, 0.5);
    state.counters["to_pose_ms_p99"] = Quantile(pose_ms, 0.99);
    state.counters["cpu_ms_per_frame"] =
        1e3 * (CpuSeconds() - cpu_from_s) / std::max<double>(1, static_cast<double>(arrival_ms.size()));
    device->Stop();
    const DeviceStatistics statistics = device->Statistics();
    state.counters["dropped"] =
        static_cast<double>(statistics.dropped + statistics.missing + statistics.incomplete);
  }
}

// Latency first: it moves the process to a network of its own, which wants a process without other threads.
BENCHMARK_CAPTURE(LatencyToTracker, mono8_640x480_at_30, 640, 480, 30.0)->Iterations(1)->UseManualTime();
BENCHMARK_CAPTURE(RecordFrames, mono8_1280x1024, 1280, 1024, CV_8UC1)->Iterations(1)->UseManualTime();
BENCHMARK_CAPTURE(RecordFrames, mosaic16_2048x2048, 2048, 2048, CV_16UC1)->Iterations(1)->UseManualTime();
BENCHMARK_CAPTURE(RecordFrames, bgr8_2048x2048, 2048, 2048, CV_8UC3)->Iterations(1)->UseManualTime();
BENCHMARK_CAPTURE(RecordViews, mosaic16_2048x2048, 2048, 2048, CV_16UC1)->Iterations(1)->UseManualTime();
BENCHMARK_CAPTURE(RecordViews, mono8_1280x1024, 1280, 1024, CV_8UC1)->Iterations(1)->UseManualTime();

}  // namespace
}  // namespace ulf

int main(int argc, char** argv) {
  std::vector<ulf::Target> targets;
  for (const char* run :
       {"RecordFrames/mono8_1280x1024", "RecordFrames/mosaic16_2048x2048", "RecordFrames/bgr8_2048x2048"})
    targets.push_back({run, "ratio", 0.6, "bytes of frames a second / dd"});
  targets.push_back({"RecordViews/mosaic16_2048x2048", "ratio", 0.6, "bytes of masters a second / dd"});
  return ulf::RunBenchmarks(argc, argv, targets);
}
