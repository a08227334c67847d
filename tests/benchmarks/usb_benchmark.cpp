// USB3 Vision over an emulated USB device: what our device costs over a bare loop of the library that it is
// built on, in the same run. The camera is in a process of its own, whose pictures are copied from memory;
// both contestants take short turns at it with the same picture size and number of frames that may wait. The
// rate itself says how fast the emulation is, not how fast USB is. Target: a median ratio of 0.95.
//
//   UsbThroughput   frames a second with the camera at full speed, and the ratio ours / bare: median, least
//                   and greatest of the turns; frames that did not arrive whole; CPU milliseconds of this
//                   process a frame (the camera's are not in it)
#include <arv.h>
#include <benchmark/benchmark.h>
#include <fmt/core.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "acquisition/opening/open_device.h"
#include "core/base/error.h"
#include "tests/benchmarks/figures.h"
#include "tests/support/floors.h"
#include "tests/support/own_namespaces.h"
#include "tests/support/usb/u3v_camera.h"

namespace ulf {
namespace {

constexpr int kPictures = 4, kTurns = 15, kSlack = 16;
constexpr double kTurnS = 0.8, kFullSpeed = 10'000;
constexpr char kIsClient[] = "ULF_USB_BENCHMARK_CLIENT";

struct Size {
  int width, height;
};

struct Turn {
  double fps = 0, cpu_ms = 0;
  int broken = 0;
};

// Counts the frames that `next` brings: +1 whole, 0 none, -1 broken.
template <typename Next>
Turn Measure(Next&& next) {
  Turn turn;
  for (int settled = 0; settled < 10;) settled += next() > 0;
  const double cpu_before = CpuSeconds();
  const auto begin = Clock::now();
  std::size_t frames = 0;
  while (SecondsSince(begin) < kTurnS) {
    const int came = next();
    frames += came > 0;
    turn.broken += came < 0;
  }
  turn.fps = static_cast<double>(frames) / SecondsSince(begin);
  turn.cpu_ms = 1e3 * (CpuSeconds() - cpu_before) / static_cast<double>(std::max<std::size_t>(1, frames));
  return turn;
}

Turn Ours(const Size& size) {
  const auto device =
      OpenDevice(fmt::format("aravis:U1?format=Mono8&roi={}x{}+0+0&fps={:g}&buffers={}&queue={}", size.width,
                             size.height, kFullSpeed, kSlack, kSlack));
  device->Start();
  Turn turn = Measure([&] {
    const auto frame = device->Next(std::chrono::milliseconds(1000));
    if (!frame) return 0;
    benchmark::DoNotOptimize(frame->image.pixels.data);
    return frame->status == FrameStatus::kComplete ? 1 : -1;
  });
  device->Stop();
  turn.broken += static_cast<int>(device->Statistics().dropped);
  return turn;
}

// The shortest program that takes every frame of such a stream.
Turn Bare(const Size& size) {
  GError* error = nullptr;
  arv_update_device_list();
  ArvCamera* camera = arv_camera_new(arv_get_device_id(0), &error);
  if (!camera) throw Error("the benchmark's camera cannot be opened: {}", error->message);
  arv_camera_set_pixel_format(camera, ARV_PIXEL_FORMAT_MONO_8, nullptr);
  arv_camera_set_region(camera, 0, 0, size.width, size.height, nullptr);
  arv_camera_set_frame_rate(camera, kFullSpeed, nullptr);
  ArvStream* stream = arv_camera_create_stream(camera, nullptr, nullptr, &error);
  if (!stream) throw Error("the benchmark's camera does not stream: {}", error->message);
  const std::size_t bytes = static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
  for (int i = 0; i < kSlack; ++i) arv_stream_push_buffer(stream, arv_buffer_new_allocate(bytes));
  arv_camera_start_acquisition(camera, nullptr);
  const Turn turn = Measure([&] {
    ArvBuffer* buffer = arv_stream_timeout_pop_buffer(stream, 1'000'000);
    if (!buffer) return 0;
    const bool whole = arv_buffer_get_status(buffer) == ARV_BUFFER_STATUS_SUCCESS;
    benchmark::DoNotOptimize(arv_buffer_get_image_data(buffer, nullptr));
    arv_stream_push_buffer(stream, buffer);
    return whole ? 1 : -1;
  });
  arv_camera_stop_acquisition(camera, nullptr);
  g_object_unref(stream);
  g_object_unref(camera);
  return turn;
}

void UsbThroughput(benchmark::State& state) {
  const Size size{static_cast<int>(state.range(0)), static_cast<int>(state.range(1))};
  std::vector<double> ours_fps, bare_fps, ratios, ours_cpu, bare_cpu;
  int ours_broken = 0, bare_broken = 0;
  for (auto _ : state) {
    // Whoever begins changes, so that a machine that grows busier favours nobody.
    const bool ours_first = ours_fps.size() % 2 == 0;
    Turn ours, bare;
    if (ours_first) ours = Ours(size);
    bare = Bare(size);
    if (!ours_first) ours = Ours(size);
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
BENCHMARK(UsbThroughput)
    ->Args({640, 480})
    ->Args({1280, 1024})
    ->Iterations(kTurns)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

// Is the camera until the measuring process, started from here, has ended; returns its exit code.
int BeCamera(char** arguments) {
  std::vector<test::Bytes> pictures;
  for (int i = 0; i < kPictures; ++i)
    pictures.push_back(
        test::EmulatedU3vCamera::Ramp({static_cast<std::uint64_t>(31 * i), 1280, 1024, 0, 0, 0x01080001}));
  const test::EmulatedU3vCamera camera(
      {.keeps_pace = false, .render = [&](const test::U3vFrame& frame) {
         const test::Bytes& picture = pictures[frame.id % kPictures];
         return test::Bytes(
             picture.begin(),
             picture.begin() + static_cast<std::ptrdiff_t>(test::EmulatedU3vCamera::ImageBytes(frame)));
       }});
  setenv(kIsClient, "1", 1);
  const pid_t client = fork();
  if (client == 0) {
    execv("/proc/self/exe", arguments);
    _exit(127);
  }
  int status = 0;
  waitpid(client, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}

}  // namespace
}  // namespace ulf

int main(int count, char** arguments) {
  if (ulf::test::NoUsbEmulation()) {  // once more, under the libraries that it needs
    setenv("LD_PRELOAD", ULF_USBFS_PRELOAD ":libumockdev-preload.so.0", 1);
    execv("/proc/self/exe", arguments);
    return 1;
  }
  if (!std::getenv(ulf::kIsClient)) {
    const auto no_namespace = ulf::test::EnterLoopbackNamespace();  // or cameras of the place answer, too
    static_cast<void>(no_namespace);
    return ulf::BeCamera(arguments);
  }
  std::vector<ulf::Target> targets;
  for (const char* size : {"640/480", "1280/1024"})
    targets.push_back(
        {fmt::format("UsbThroughput/{}", size), "ratio", 0.95, "frames a second, ours / bare loop"});
  return ulf::RunBenchmarks(count, arguments, targets);
}
