// How fast frames and views come to the disk, against dd in the same folder and run, and how soon and at what
// cost a frame reaches the tracker.
//
//   ratio        bytes written a second / what `dd conv=fsync` of as many bytes does, medians of five
//   encode_MBps  pixels a second through the encoder alone, one thread
//
// The folder is ULF_BENCHMARK_DIR, else the system's temporary one: a tmpfs says nothing about a disk.
#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <thread>

#include "acquisition/device.h"
#include "acquisition/error.h"
#include "acquisition/frame_recording.h"
#include "coverage/view_spool.h"
#include "tests/support/child_process.h"
#include "tests/support/loopback_namespace.h"
#include "tracking/tracker.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

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
double Dd(std::uint64_t bytes) {
  const fs::path file = Folder() / "dd.bin";
  const std::string command = fmt::format("dd if=/dev/zero of={} bs=1M count={} conv=fsync 2>/dev/null",
                                          file.string(), std::max<std::uint64_t>(1, bytes >> 20));
  const auto start = Clock::now();
  if (std::system(command.c_str()) != 0) throw Error("dd failed in {}", Folder().string());
  const double rate = 1e-6 * static_cast<double>(bytes) / SecondsSince(start);
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

double EncodeRate(const cv::Mat& pixels, const char* kind, const std::vector<int>& options) {
  std::vector<unsigned char> bytes;
  const auto start = Clock::now();
  int rounds = 0;
  for (; rounds < 3 || SecondsSince(start) < 0.3; ++rounds) cv::imencode(kind, pixels, bytes, options);
  return rounds * Megabytes(pixels) / SecondsSince(start);
}

// A disk's rate changes from second to second: rounds of ours and dd's in turn, medians of both.
constexpr int kRounds = 5;

double Quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values.empty() ? 0
                        : values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

// Every frame of a camera: ulf record, capture --keep-frames.
void RecordFrames(benchmark::State& state, int width, int height, int type) {
  const cv::Mat picture = Picture(width, height, type);
  const int count = static_cast<int>(400 / Megabytes(picture));
  for (auto _ : state) {
    std::vector<double> rates, dd;
    double seconds = 0;
    for (int round = 0; round < kRounds; ++round) {
      const Scratch scratch;
      dd.push_back(Dd(400 << 20));
      const auto start = Clock::now();
      FrameRecorder recorder(Folder() / "frames", {});
      for (int i = 0; i < count; ++i)
        while (!recorder.TryAdd(FrameOf(picture, static_cast<std::uint64_t>(i))))
          std::this_thread::sleep_for(std::chrono::milliseconds(1));  // only here: all shall be written
      const FrameRecorderSummary summary = recorder.Finish();
      rates.push_back(1e-6 * static_cast<double>(summary.bytes) / SecondsSince(start));
      seconds += SecondsSince(start);
    }
    state.SetIterationTime(seconds / kRounds);
    state.counters["MBps"] = Quantile(rates, 0.5);
    state.counters["dd_MBps"] = Quantile(dd, 0.5);
    state.counters["ratio"] = Quantile(rates, 0.5) / Quantile(dd, 0.5);
    state.counters["fps"] = Quantile(rates, 0.5) / Megabytes(picture);
    state.counters["encode_MBps"] = EncodeRate(picture, ".tif", {cv::IMWRITE_TIFF_COMPRESSION, 1});
  }
}

// Recorded views: photograph, master and journal line, each synced.
void RecordViews(benchmark::State& state, int width, int height, int type) {
  const cv::Mat picture = Picture(width, height, type);
  constexpr int kViews = 24;
  for (auto _ : state) {
    const Scratch scratch;
    CaptureHeader header;
    header.camera = CameraModel::Pinhole(width, height, width);
    LightFieldWriter writer = LightFieldWriter::Create(Folder() / "lf", header);
    writer.KeepMosaics(true);
    const auto start = Clock::now();
    ViewSpool spool(std::move(writer), 16, true);
    for (int i = 0; i < kViews; ++i)
      while (!spool.TryAddView(FrameOf(picture, static_cast<std::uint64_t>(i)), {}))
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    const LightFieldWriter done = spool.Finish();
    const double seconds = SecondsSince(start);
    state.SetIterationTime(seconds);
    std::uint64_t masters = 0, images = 0;
    for (const View& view : done.Contents().views) {
      images += fs::file_size(Folder() / "lf" / view.image_path);
      if (!view.master_path.empty()) masters += fs::file_size(Folder() / "lf" / view.master_path);
    }
    std::vector<double> rates;
    for (int round = 0; round < kRounds; ++round) rates.push_back(Dd(masters + images));
    const double dd = Quantile(rates, 0.5);
    state.counters["master_MBps"] = 1e-6 * static_cast<double>(masters) / seconds;
    state.counters["all_MBps"] = 1e-6 * static_cast<double>(masters + images) / seconds;
    state.counters["dd_MBps"] = dd;
    state.counters["ratio"] = 1e-6 * static_cast<double>(masters + images) / seconds / dd;
    state.counters["views_per_s"] = kViews / seconds;
    state.counters["png_encode_MBps"] = EncodeRate(Srgb8({picture}), ".png", {});
    state.counters["tiff_encode_MBps"] = EncodeRate(picture, ".tif", {cv::IMWRITE_TIFF_COMPRESSION, 1});
  }
}

double CpuSeconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

// From the camera's own time of a frame (start of exposure) to the moment the tracker gets it, and to the
// moment it knows the pose; a camera in another process, over GigE Vision on loopback. Its clock is this
// computer's.
void LatencyToTracker(benchmark::State& state, int width, int height, double fps) {
  if (const auto why_not = test::EnterLoopbackNamespace()) {
    state.SkipWithError(why_not->c_str());
    return;
  }
  for (auto _ : state) {
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
      const auto now_s = [] {
        return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
      };
      const double arrived_s = now_s();
      if (!tracker)
        tracker.emplace(
            CameraModel::Pinhole(frame->image.width(), frame->image.height(), frame->image.width()),
            TrackerOptions{});
      tracker->Step(*frame);
      if (++frames == kWarm) cpu_from_s = CpuSeconds();
      if (frames <= kWarm) continue;
      arrival_ms.push_back(1e3 * (arrived_s - frame->device_time_s));
      pose_ms.push_back(1e3 * (now_s() - frame->device_time_s));
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

BENCHMARK_MAIN();
