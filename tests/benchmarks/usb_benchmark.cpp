// USB3 Vision over an emulated USB device: what our device costs over a bare loop of the library that it is
// built on, in the same run. The camera is in a process of its own, whose pictures are copied from memory;
// both contestants take short turns at it with the same picture size and number of frames that may wait. The
// rate itself says how fast the emulation is, not how fast USB is. Target: a median ratio of 0.95.
//
//   UsbThroughput   frames a second with the camera at full speed, and the ratio ours / bare: median, least
//                   and greatest of the turns; frames that did not arrive whole; CPU milliseconds of this
//                   process a frame (the camera's are not in it)
#include <benchmark/benchmark.h>
#include <fmt/core.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "tests/benchmarks/aravis_turns.h"
#include "tests/measure/figures.h"
#include "tests/support/floors.h"
#include "tests/support/own_namespaces.h"
#include "tests/support/usb/u3v_camera.h"

namespace ulf {
namespace {

constexpr int kPictures = 4;
constexpr double kFullSpeed = 10'000;
constexpr char kIsClient[] = "ULF_USB_BENCHMARK_CLIENT";

void UsbThroughput(benchmark::State& state) {
  const Size size = SizeOf(state);
  TellThroughput(
      state,
      [=] {
        return OurTurn(fmt::format("aravis:U1?format=Mono8&roi={}x{}+0+0&fps={:g}&buffers={}&queue={}",
                                   size.width, size.height, kFullSpeed, kSlack, kSlack));
      },
      [=] {
        return BareTurn({nullptr, size, kFullSpeed});
      });
}
BENCHMARK(UsbThroughput)
    ->Args({640, 480})
    ->Args({1280, 1024})
    ->Iterations(1)
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
