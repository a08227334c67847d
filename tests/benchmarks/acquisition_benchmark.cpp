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

#include <csignal>
#include <cstdlib>
#include <cstring>
#include <thread>
#include <vector>

#include "acquisition/gige_vision/gige_vision_probe.h"
#include "tests/benchmarks/aravis_turns.h"
#include "tests/measure/figures.h"
#include "tests/support/floors.h"
#include "tests/support/own_namespaces.h"

namespace ulf {
namespace {

constexpr char kAddress[] = "127.0.0.1";
constexpr int kSensor = 2048, kPictures = 4, kPacketBytes = 7800;
constexpr double kLatencyFps = 30;
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

Turn Ours(const Size& size, double fps, std::size_t frames_wanted = 0) {
  const char* more = std::getenv("ULF_BENCHMARK_OPTIONS");  // to try some, as "buffers=24&priority=high&"
  return OurTurn(
      fmt::format("aravis:{}?{}format=Mono8&roi={}x{}+0+0&packet_size={}&fps={:g}&buffers={}&queue={}",
                  kAddress, more ? more : "", size.width, size.height, kPacketBytes, fps, kSlack, kSlack),
      frames_wanted);
}

Turn Bare(const Size& size, double fps, std::size_t frames_wanted = 0) {
  return BareTurn({kAddress, size, fps, kPacketBytes}, frames_wanted);
}

// ---- the figures ----------------------------------------------------------------------------------------

void Throughput(benchmark::State& state) {
  const Size size = SizeOf(state);
  TellThroughput(
      state, [=] { return Ours(size, kFullSpeed); }, [=] { return Bare(size, kFullSpeed); });
}
BENCHMARK(Throughput)
    ->Args({640, 480})
    ->Args({1280, 1024})
    ->Args({2048, 2048})
    ->Iterations(1)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

void Latency(benchmark::State& state) {
  const Size size = SizeOf(state);
  Turn ours, bare;
  for ([[maybe_unused]] auto _ : state) {
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
