#include "acquisition/link/link_check.h"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "acquisition/aravis/aravis_usb.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/host_time.h"

namespace ulf::acquisition {
namespace {

std::optional<double> TransportValue(const DeviceStatistics& statistics, const std::string& name) {
  for (const auto& [known, value] : statistics.transport)
    if (known == name) return value;
  return std::nullopt;
}

struct Streamed {
  LinkTrial trial;
  DeviceInfo camera;
  DeviceStatistics statistics;
};

// From the first frame on; none where a stop was asked for.
std::optional<Streamed> Stream(const std::string& uri, const std::string& settings, double seconds,
                               const LinkCheckOptions& options) {
  DeviceUri with = DeviceUri::Parse(uri);
  if (const auto equals = settings.find('='); equals != std::string::npos)
    with.Set(settings.substr(0, equals), settings.substr(equals + 1));
  if (with.scheme == "replay")
    throw UsageError("{}: is no camera; a link is checked with one that streams, such as aravis:192.0.2.7",
                     uri);
  const std::unique_ptr<Device> device = OpenDevice(with.Text());
  Streamed streamed;
  streamed.camera = device->Info();
  device->Start();
  using Clock = std::chrono::steady_clock;
  const auto started = Clock::now();
  std::optional<Clock::time_point> first;
  std::uint64_t frames = 0;
  while (SecondsSince(first.value_or(started)) < (first ? seconds : options.first_frame_s) &&
         !IsOver(device->State())) {
    if (options.stop && options.stop()) return std::nullopt;
    if (!device->Next(std::chrono::milliseconds(100))) continue;
    if (!first) first = Clock::now();
    ++frames;
  }
  LinkTrial& trial = streamed.trial;
  trial.settings = settings;
  trial.seconds = first ? SecondsSince(*first) : 0;
  streamed.statistics = device->Statistics();
  device->Stop();
  const DeviceStatistics& counted = streamed.statistics;
  trial.whole = counted.delivered + counted.dropped;
  trial.incomplete = counted.incomplete;
  trial.missing = counted.missing;
  trial.fps = trial.seconds > 0
                  ? static_cast<double>(trial.whole + trial.incomplete + trial.missing) / trial.seconds
                  : 0;
  trial.asked_fps = with.Number("fps").value_or(0);
  trial.resent_packets = TransportValue(counted, "packets resent").value_or(0);
  return streamed;
}

void DescribeNetwork(const Streamed& streamed, LinkReport& report) {
  const auto link = NetworkLinkTo(streamed.camera.address);
  if (!link) return;
  const int packet_size = static_cast<int>(TransportValue(streamed.statistics, "packet size").value_or(0));
  constexpr int kEthernetMtu = 1500, kJumboMtu = 9000;
  const std::string speed = link->bytes_per_s ? fmt::format("{:.0f} Mbit/s", 8e-6 * *link->bytes_per_s)
                                              : "speed not told by the system";
  report.facts.push_back(
      {"link",
       fmt::format("{} to {}: {}, MTU {}", link->interface, streamed.camera.address, speed, link->mtu),
       link->mtu > 0 && link->mtu <= kEthernetMtu
           ? fmt::format("jumbo frames cost less processor time: 'ip link set {} mtu {}' as root, "
                         "where the camera and every switch between pass them",
                         link->interface, kJumboMtu)
           : ""});
  const bool negotiated = TransportValue(streamed.statistics, "packet size negotiated").value_or(0) > 0;
  report.facts.push_back({"packets",
                          fmt::format("{} bytes, {}", packet_size,
                                      negotiated ? "negotiated with test packets" : "as the camera has it"),
                          ""});
  const double asked = TransportValue(streamed.statistics, "socket buffer asked for (bytes)").value_or(0);
  const double granted = TransportValue(streamed.statistics, "socket buffer (bytes)").value_or(asked);
  report.facts.push_back(
      {"receive buffer", fmt::format("{:.1f} MB of {:.1f} asked for", 1e-6 * granted, 1e-6 * asked),
       granted < asked ? fmt::format("'sysctl net.core.rmem_max={:.0f}' as root gives the rest", asked)
                       : ""});
  const bool resends = TransportValue(streamed.statistics, "resend on").value_or(0) > 0;
  report.facts.push_back({"resending", resends ? "on" : "off, or not supported by the camera",
                          resends ? "" : "every lost packet costs its frame"});
  if (link->bytes_per_s && report.payload_bytes > 0 && packet_size > 0)
    report.most_fps = MostGigeFps(*link->bytes_per_s, report.payload_bytes, packet_size);
}

void DescribeUsb(const Streamed& streamed, LinkReport& report) {
  const auto place = UsbCameraPlaceOf(streamed.camera.maker, streamed.camera.serial);
  if (place) {
    report.facts.push_back(
        {"port", fmt::format("{} at {} Mbit/s", place->port, place->megabits), SlowUsbText(*place)});
    if (report.payload_bytes > 0 && place->megabits > 0)
      report.most_fps = UsbBytesPerSecond(place->megabits) / report.payload_bytes;
  }
  const std::optional<int> memory_mb = UsbMemoryMb();
  if (!memory_mb) return;
  report.facts.push_back({"USB memory", fmt::format("{} MB for all programs together", *memory_mb),
                          *memory_mb > 0
                              ? "where several cameras stream: 'echo 1000 > "
                                "/sys/module/usbcore/parameters/usbfs_memory_mb' as root (udev/README.md)"
                              : ""});
}

// Others on the same wire share it.
void DescribeNeighbours(const DeviceInfo& camera, LinkReport& report) {
  if (camera.address.empty()) return;
  const auto own = NetworkLinkTo(camera.address);
  std::size_t others = 0;
  for (const DeviceInfo& other : ListDevices()) {
    if (other.serial == camera.serial || other.address.empty()) continue;
    const auto link = NetworkLinkTo(other.address);
    others += own && link && link->interface == own->interface;
  }
  if (others > 0)
    report.facts.push_back({"beside it",
                            fmt::format("{} on {}", Counted(others, "other camera"), own->interface),
                            "cameras that stream at once share the link: check them together"});
}

}  // namespace

double MostGigeFps(double link_bytes_per_s, double payload_bytes, int packet_size) {
  constexpr double kHeaders = 20 + 8 + 8;        // IP, UDP, GVSP: of the packet's own size
  constexpr double kAroundIt = 14 + 4 + 8 + 12;  // Ethernet's header and checksum, preamble, gap
  const double data = packet_size - kHeaders;
  if (!(data > 0) || !(payload_bytes > 0)) return 0;
  const double packets = std::ceil(payload_bytes / data) + 2;  // leader and trailer
  return link_bytes_per_s / (payload_bytes + packets * (kHeaders + kAroundIt));
}

LinkReport CheckLink(const std::string& uri, const LinkCheckOptions& options) {
  LinkReport report;
  const auto try_with = [&](const std::string& settings, double seconds) -> std::optional<Streamed> {
    if (options.say)
      options.say(
          fmt::format("streaming for {:g} s{}", seconds, settings.empty() ? "" : " with " + settings));
    auto streamed = Stream(uri, settings, seconds, options);
    if (streamed) report.trials.push_back(streamed->trial);
    return streamed;
  };
  // What holds by chance for a while is no remedy: it must hold for longer. True: nothing else is to be tried.
  const auto is_remedy = [&](const std::string& settings) {
    for (const double times : {1.0, options.confirmed_times}) {
      const auto streamed = try_with(settings, times * options.seconds);
      if (!streamed) return true;
      if (!streamed->trial.Held()) return false;
    }
    report.remedy = settings;
    return true;
  };
  const auto streamed = try_with("", options.seconds);
  if (!streamed) return report;
  report.camera = streamed->camera;
  report.payload_bytes = TransportValue(streamed->statistics, "payload (bytes)").value_or(0);
  if (report.payload_bytes <= 0 && streamed->statistics.delivered > 0)
    report.payload_bytes =
        static_cast<double>(streamed->statistics.bytes) / static_cast<double>(streamed->statistics.delivered);
  DescribeNetwork(*streamed, report);
  if (streamed->camera.bus == "USB3Vision") DescribeUsb(*streamed, report);
  DescribeNeighbours(streamed->camera, report);
  if (streamed->trial.Held()) return report;
  // A path that does not pass large packets loses them all; one that is full loses whatever their size.
  const double packet_size = TransportValue(streamed->statistics, "packet size").value_or(0);
  if (streamed->trial.whole == 0)
    for (const int size : options.packet_sizes)
      if (size < packet_size && is_remedy(fmt::format("packet_size={}", size))) return report;
  // What came through whole or not: a sender that waits for its link sends what that carries.
  double fps = options.rate_share * streamed->trial.fps;
  for (int i = 0; i < options.most_rates && fps > 0; ++i, fps *= options.rate_share)
    if (is_remedy(fmt::format("fps={:.4g}", fps))) return report;
  return report;
}

}  // namespace ulf::acquisition
