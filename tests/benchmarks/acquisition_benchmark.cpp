// GigE Vision on loopback: what our device costs over a bare loop of the library that it is built on, in the
// same run. One camera in a process of its own, whose pictures are copied from memory; both contestants take
// short turns at it with the same picture size, packet size, socket and number of frames that may wait, and
// each turn of one stands beside the next turn of the other. Target: a median ratio of 0.95.
//
//   Throughput   frames a second with the camera at full speed, and the ratio ours / bare: median, least and
//                greatest of the turns; frames that did not arrive whole; CPU milliseconds of this process a
//                frame (the camera's are not in it)
//   Latency      at 30 frames a second, from the device's timestamp (which the camera takes before it makes
//                the picture) to the reader: median and 99th percentile
#include <arv.h>
#include <benchmark/benchmark.h>
#include <fmt/core.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <thread>
#include <vector>

#include "acquisition/gige_vision/gige_vision_probe.h"
#include "acquisition/opening/open_device.h"
#include "core/base/error.h"
#include "tests/benchmarks/figures.h"
#include "tests/support/floors.h"
#include "tests/support/own_namespaces.h"

namespace ulf {
namespace {

constexpr char kAddress[] = "127.0.0.1";
constexpr int kSensor = 2048, kPictures = 4, kPacketBytes = 7800, kTurns = 15, kSlack = 16;
constexpr double kTurnS = 0.8, kLatencyFps = 30;
constexpr double kFullSpeed = 1000;  // the most that the camera lets itself be told
constexpr std::size_t kLatencyFrames = 200;

// ---- the camera's process -------------------------------------------------------------------------------

struct Camera {
  ArvFakeCamera* fake = nullptr;
  std::vector<std::vector<guint8>> pictures;
};

// Frames begin at multiples of the camera's period only. At 1000 a second one that takes 1.01 ms would be
// followed after 2: a little time would turn into half the rate. At full speed the period is cut short.
void ForgetThePeriod(ArvFakeCamera* camera) {
  guint32 period_us = 0;
  arv_fake_camera_read_register(camera, ARV_FAKE_CAMERA_REGISTER_ACQUISITION_FRAME_PERIOD_US, &period_us);
  if (period_us <= 1e6 / kFullSpeed)
    arv_fake_camera_write_register(camera, ARV_FAKE_CAMERA_REGISTER_ACQUISITION_FRAME_PERIOD_US, 10);
}

void Fill(ArvBuffer* buffer, void* data, guint32, guint32, ArvPixelFormat) {
  const auto& camera = *static_cast<const Camera*>(data);
  ForgetThePeriod(camera.fake);
  const auto& picture = camera.pictures[arv_buffer_get_frame_id(buffer) % camera.pictures.size()];
  std::size_t unused = 0;
  auto* out = static_cast<guint8*>(const_cast<void*>(arv_buffer_get_data(buffer, &unused)));
  const auto width = static_cast<std::size_t>(arv_buffer_get_image_width(buffer));
  const auto height = static_cast<std::size_t>(arv_buffer_get_image_height(buffer));
  std::memcpy(out, picture.data(), width * height);
}

[[noreturn]] void BeCamera() {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  ArvGvFakeCamera* served = arv_gv_fake_camera_new(kAddress, "BENCH");
  if (!served || !arv_gv_fake_camera_is_running(served)) _exit(1);
  Camera camera{arv_gv_fake_camera_get_fake_camera(served),
                std::vector(kPictures, std::vector<guint8>(std::size_t{kSensor} * kSensor))};
  for (std::size_t i = 0; i < camera.pictures.size(); ++i)
    for (std::size_t k = 0; k < camera.pictures[i].size(); ++k)
      camera.pictures[i][k] = static_cast<guint8>(k * 7 + i * 31);
  arv_fake_camera_set_fill_pattern(camera.fake, Fill, &camera);
  for (;;) pause();
}

// ---- the contestants ------------------------------------------------------------------------------------

struct Size {
  int width, height;
};

struct Turn {
  double fps = 0, cpu_ms = 0;
  int broken = 0;
  std::vector<double> latencies_ms;
};

// Counts the frames that `next` brings: +1 whole, 0 none, -1 broken; its second argument takes the timestamp.
template <typename Next>
Turn Measure(Next&& next, std::size_t frames_wanted) {
  Turn turn;
  double device_time_s = 0;
  for (int settled = 0; settled < 10;) settled += next(device_time_s) > 0;  // the first meet small buffers
  const double cpu_before = CpuSeconds();
  const auto begin = Clock::now();
  std::size_t frames = 0;
  while (frames_wanted > 0 ? frames < frames_wanted : SecondsSince(begin) < kTurnS) {
    const int came = next(device_time_s);
    if (came > 0) {
      ++frames;
      if (frames_wanted > 0) turn.latencies_ms.push_back(1e3 * (EpochSeconds() - device_time_s));
    }
    turn.broken += came < 0;
  }
  turn.fps = static_cast<double>(frames) / SecondsSince(begin);
  turn.cpu_ms = 1e3 * (CpuSeconds() - cpu_before) / static_cast<double>(std::max<std::size_t>(1, frames));
  return turn;
}

Turn Ours(const Size& size, double fps, std::size_t frames_wanted) {
  const char* more = std::getenv("ULF_BENCHMARK_OPTIONS");  // to try some, as "buffers=24&priority=high&"
  const auto device = OpenDevice(
      fmt::format("aravis:{}?{}format=Mono8&roi={}x{}+0+0&packet_size={}&fps={:g}&buffers={}&queue={}",
                  kAddress, more ? more : "", size.width, size.height, kPacketBytes, fps, kSlack, kSlack));
  device->Start();
  Turn turn = Measure(
      [&](double& device_time_s) {
        const auto frame = device->Next(std::chrono::milliseconds(1000));
        if (!frame) return 0;
        device_time_s = frame->device_time_s;
        benchmark::DoNotOptimize(frame->image.pixels.data);
        return frame->status == FrameStatus::kComplete ? 1 : -1;
      },
      frames_wanted);
  device->Stop();
  turn.broken += static_cast<int>(device->Statistics().dropped);
  return turn;
}

// The shortest program that takes every frame of such a stream.
Turn Bare(const Size& size, double fps, std::size_t frames_wanted) {
  GError* error = nullptr;
  ArvCamera* camera = arv_camera_new(kAddress, &error);
  if (!camera) throw Error("the benchmark's camera cannot be opened: {}", error->message);
  arv_camera_set_pixel_format(camera, ARV_PIXEL_FORMAT_MONO_8, nullptr);
  arv_camera_set_region(camera, 0, 0, size.width, size.height, nullptr);
  arv_camera_set_frame_rate(camera, fps, nullptr);
  arv_camera_gv_set_packet_size(camera, kPacketBytes, nullptr);
  arv_camera_gv_set_stream_options(camera, ARV_GV_STREAM_OPTION_PACKET_SOCKET_DISABLED);
  ArvStream* stream = arv_camera_create_stream(camera, nullptr, nullptr, &error);
  if (!stream) throw Error("the benchmark's camera does not stream: {}", error->message);
  const std::size_t bytes = static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
  g_object_set(stream, "socket-buffer", ARV_GV_STREAM_SOCKET_BUFFER_FIXED, "socket-buffer-size",
               static_cast<gint>(std::max<std::size_t>(2 * bytes, 2 << 20)), nullptr);
  for (int i = 0; i < kSlack; ++i) arv_stream_push_buffer(stream, arv_buffer_new_allocate(bytes));
  arv_camera_start_acquisition(camera, nullptr);
  const Turn turn = Measure(
      [&](double& device_time_s) {
        ArvBuffer* buffer = arv_stream_timeout_pop_buffer(stream, 1'000'000);
        if (!buffer) return 0;
        const bool whole = arv_buffer_get_status(buffer) == ARV_BUFFER_STATUS_SUCCESS;
        device_time_s = 1e-9 * static_cast<double>(arv_buffer_get_timestamp(buffer));
        benchmark::DoNotOptimize(arv_buffer_get_image_data(buffer, nullptr));
        arv_stream_push_buffer(stream, buffer);
        return whole ? 1 : -1;
      },
      frames_wanted);
  arv_camera_stop_acquisition(camera, nullptr);
  g_object_unref(stream);
  g_object_unref(camera);
  return turn;
}

// ---- the figures ----------------------------------------------------------------------------------------

Size SizeOf(const benchmark::State& state) {
  return {static_cast<int>(state.range(0)), static_cast<int>(state.range(1))};
}

void Throughput(benchmark::State& state) {
  const Size size = SizeOf(state);
  std::vector<double> ours_fps, bare_fps, ratios, ours_cpu, bare_cpu;
  int ours_broken = 0, bare_broken = 0;
  for (auto _ : state) {
    // Whoever begins changes, so that a machine that grows busier favours nobody.
    const bool ours_first = ours_fps.size() % 2 == 0;
    Turn ours, bare;
    if (ours_first) ours = Ours(size, kFullSpeed, 0);
    bare = Bare(size, kFullSpeed, 0);
    if (!ours_first) ours = Ours(size, kFullSpeed, 0);
    ours_fps.push_back(ours.fps);
    bare_fps.push_back(bare.fps);
    ratios.push_back(ours.fps / bare.fps);
    ours_cpu.push_back(ours.cpu_ms);
    bare_cpu.push_back(bare.cpu_ms);
    ours_broken += ours.broken;
    bare_broken += bare.broken;
    state.SetIterationTime(1 / ours.fps);
  }
  state.counters["ratio"] = Quantile(ratios, 0.5);
  state.counters["ratio_least"] = Quantile(ratios, 0);
  state.counters["ratio_most"] = Quantile(ratios, 1);
  state.counters["ours_fps"] = Quantile(ours_fps, 0.5);
  state.counters["bare_fps"] = Quantile(bare_fps, 0.5);
  state.counters["ours_cpu_ms"] = Quantile(ours_cpu, 0.5);
  state.counters["bare_cpu_ms"] = Quantile(bare_cpu, 0.5);
  state.counters["ours_broken"] = ours_broken;
  state.counters["bare_broken"] = bare_broken;
}
BENCHMARK(Throughput)
    ->Args({640, 480})
    ->Args({1280, 1024})
    ->Args({2048, 2048})
    ->Iterations(kTurns)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

void Latency(benchmark::State& state) {
  const Size size = SizeOf(state);
  Turn ours, bare;
  for (auto _ : state) {
    ours = Ours(size, kLatencyFps, kLatencyFrames);
    bare = Bare(size, kLatencyFps, kLatencyFrames);
    state.SetIterationTime(1e-3 * Quantile(ours.latencies_ms, 0.5));
  }
  state.counters["ours_median_ms"] = Quantile(ours.latencies_ms, 0.5);
  state.counters["ours_p99_ms"] = Quantile(ours.latencies_ms, 0.99);
  state.counters["bare_median_ms"] = Quantile(bare.latencies_ms, 0.5);
  state.counters["bare_p99_ms"] = Quantile(bare.latencies_ms, 0.99);
  state.counters["ours_cpu_ms"] = ours.cpu_ms;
  state.counters["broken"] = ours.broken;
}
BENCHMARK(Latency)
    ->Args({640, 480})
    ->Args({1280, 1024})
    ->Args({2048, 2048})
    ->Iterations(1)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace ulf

int main(int argc, char** argv) {
  if (const auto why_not = ulf::test::EnterLoopbackNamespace()) {
    fmt::print(stderr, "nothing is measured: {}\n", *why_not);
    return 1;
  }
  const pid_t camera = fork();  // before the library has threads
  if (camera == 0) ulf::BeCamera();
  const auto begin = ulf::Clock::now();
  while (!ulf::QueryGigeCamera(ulf::kAddress)) {
    if (ulf::SecondsSince(begin) > 20) {
      fmt::print(stderr, "the benchmark's camera does not answer\n");
      return 1;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  std::vector<ulf::Target> targets;
  for (const char* size : {"640/480", "1280/1024", "2048/2048"})
    targets.push_back(
        {fmt::format("Throughput/{}", size), "ratio", 0.95, "frames a second, ours / bare loop"});
  const int status = ulf::RunBenchmarks(argc, argv, targets);
  kill(camera, SIGKILL);
  waitpid(camera, nullptr, 0);
  return status;
}
