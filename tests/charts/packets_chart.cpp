// GigE Vision over a link that loses packets: packet size and sending again against frames that are lost.
#include <algorithm>
#include <chrono>
#include <memory>

#include "acquisition/device/device.h"
#include "acquisition/opening/open_device.h"
#include "core/base/error.h"
#include "tests/measure/runner.h"
#include "tests/measure/table.h"
#include "tests/support/child_process.h"
#include "tests/support/floors.h"
#include "tests/support/own_namespaces.h"

namespace ulf::test {
namespace {

using Clock = std::chrono::steady_clock;
constexpr char kAddress[] = "127.0.0.1";
constexpr int kWidth = 1280, kHeight = 1024, kFps = 60;

double Since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

// The camera behind its link, in a process of its own.
std::unique_ptr<ChildProcess> StartCamera(double lost_share, bool resends, unsigned seed) {
  std::vector<std::string> command{
      ULF_BINARY,
      "simulate",
      "studio",
      "--interface",
      kAddress,
      "--loop",
      "4",
      "--options",
      fmt::format("width={}&height={}&format=mono8&fps={}&seed={}", kWidth, kHeight, kFps, seed),
      "--fault",
      fmt::format("lost={}", lost_share)};
  if (!resends) command.insert(command.end(), {"--fault", "resend=0"});
  auto camera = std::make_unique<ChildProcess>(command);
  if (camera->ReadUntil("serving", 30).find("serving") == std::string::npos)
    throw Error("the simulated camera does not start; try: ulf simulate studio --interface {}", kAddress);
  return camera;
}

struct Received {
  double whole_fps = 0, lost_pct = 0;
};

Received Receive(int packet_bytes, double seconds) {
  const auto device = OpenDevice(fmt::format("aravis:{}?packet_size={}&queue=16", kAddress, packet_bytes));
  device->Start();
  for (int settled = 0; settled < 5;) settled += device->Next(std::chrono::milliseconds(1000)).has_value();
  const DeviceStatistics before = device->Statistics();
  const auto begin = Clock::now();
  double whole = 0;
  while (Since(begin) < seconds)
    if (const auto frame = device->Next(std::chrono::milliseconds(500)))
      whole += frame->status == FrameStatus::kComplete;
  const double took = Since(begin);
  const DeviceStatistics after = device->Statistics();
  device->Stop();
  const double lost =
      static_cast<double>(after.incomplete + after.missing - before.incomplete - before.missing);
  return {whole / took, 100 * lost / std::max(1.0, lost + whole)};
}

Chart MeasurePackets(const Effort& effort) {
  if (const auto why_not = EnterLoopbackNamespace()) throw NotHere(*why_not);
  Table table;
  for (const double lost_share : effort.Of(std::vector{0.001}, {0.001, 0.01})) {
    const std::string title = fmt::format("{:g} % of the packets lost", 100 * lost_share);
    table.Panel(title, Log("time for a whole frame [ms]"), Log("frames lost [%]"));
    for (const bool resends : {true, false})
      for (const unsigned seed : effort.Seeds(3)) {
        const auto camera = StartCamera(lost_share, resends, seed);
        for (const int bytes : effort.Of(std::vector{7800}, {576, 1500, 3000, 7800})) {
          const Received received = Receive(bytes, effort.Of(0.7, 2.0));
          table.Add(title, resends ? "lost packets are sent again" : "not sent again", std::to_string(bytes),
                    1000 / std::max(0.1, received.whole_fps), std::max(0.1, received.lost_pct),
                    resends && bytes == 7800);
        }
      }
  }
  return {.panels = table.panels()};
}

CHART(packets, MeasurePackets, "GigE Vision: packet size and sending again over a link that loses packets",
      R"(The simulated camera on loopback at 1280x1024, 60 frames a second asked for, behind a relay that
  loses a share of the packets; 2 s each, three seeds. 0.1 % is shown for all that is less. Names: bytes of
  a packet; ringed: what is taken on loopback.)");

}  // namespace
}  // namespace ulf::test
