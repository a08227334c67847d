#include "acquisition/link/link_facts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/counted.h"

namespace ulf::acquisition {
namespace {

constexpr int kEthernetMtu = 1500, kJumboMtu = 9000;
constexpr double kPacketHeaders = 20 + 8 + 8;  // IP, UDP, GVSP: of the packet's own size
// Lost frames are a fault of the link from this many on, and this share: one at the start is none. Guessed.
constexpr std::uint64_t kLeastLost = 3;
constexpr double kLeastLostShare = 0.005;
// A limit below this share of what the settings ask for holds the camera back. Guessed.
constexpr double kSameRate = 0.98;
// The rate that is advised, as a share of what the link's figures allow. Guessed.
constexpr double kSafeShare = 0.95;

double MegabytesPerS(double bytes_per_s) { return 1e-6 * bytes_per_s; }

// This share of the rate that is set, or that the exposure time allows, is as good as all of it. Guessed.
constexpr double kAsSet = 0.9;

// Describes what the camera was set to send.
struct Sent {
  double payload_bytes = 0, packet_size = 0;
  std::optional<double> fps = {};  // not more than its exposure time allows
  std::optional<double> set_fps = {};
  double BytesPerS() const { return fps ? payload_bytes * *fps : 0; }
};

std::string SpeedText(const NetworkLink& link) {
  return link.bytes_per_s ? fmt::format("{:.0f} Mbit/s", 8e-6 * *link.bytes_per_s)
                          : "speed not told by the system";
}

std::string JumboAdvice(const NetworkLink& link) {
  return fmt::format(
      "'ip link set {} mtu {}' as root, where the camera and every switch between pass jumbo frames",
      link.interface, kJumboMtu);
}

LinkFact NetworkFact(const DeviceInfo& camera, const NetworkLink& link) {
  const bool small = link.mtu > 0 && link.mtu <= kEthernetMtu;
  return {"link",
          fmt::format("{} to {}: {}, MTU {}", link.interface, camera.address, SpeedText(link), link.mtu),
          small ? "jumbo frames cost less processor time: " + JumboAdvice(link) : ""};
}

LinkFact PacketFact(const NetworkLink& link, const Sent& sent, bool negotiated) {
  LinkFact fact{"packets", fmt::format("{:.0f} bytes, {}", sent.packet_size,
                                       negotiated ? "negotiated with test packets" : "as the camera has it")};
  if (link.mtu <= 0 || sent.packet_size <= link.mtu) return fact;
  fact.value += fmt::format(", more than the MTU of {} passes", link.mtu);
  fact.advice = fmt::format("packet_size={} in the URI; or {}", link.mtu, JumboAdvice(link));
  fact.in_order = false;
  return fact;
}

LinkFact BufferFact(const LinkPath& path, const Sent& sent, double asked, double granted) {
  LinkFact fact{"receive buffer",
                fmt::format("{:.1f} MB of {:.1f} asked for", MegabytesPerS(granted), MegabytesPerS(asked))};
  if (path.most_buffer)
    fact.value += fmt::format(", the system allows {:.1f}", MegabytesPerS(*path.most_buffer));
  if (granted >= asked) return fact;
  fact.advice = fmt::format("'sysctl net.core.rmem_max={:.0f}' as root gives the rest", asked);
  fact.in_order = granted >= sent.payload_bytes;  // a frame must find room, however late it is read
  return fact;
}

// Returns the rate that is asked for against what the link carries. `most_fps`: by the link's own figures.
LinkFact RateFact(const Sent& sent, double most_fps, const std::string& wider) {
  LinkFact fact{kRateFact, fmt::format("at most {:.1f} frames a second of {:.1f} MB", most_fps,
                                       MegabytesPerS(sent.payload_bytes))};
  if (!sent.fps) return fact;
  fact.value += fmt::format(", the camera is set to {:.1f}", *sent.set_fps);
  if (*sent.fps < kAsSet * *sent.set_fps)
    fact.value += fmt::format(", of which its exposure time allows {:.1f}", *sent.fps);
  if (*sent.fps <= most_fps) return fact;
  fact.advice =
      fmt::format("fps={:.4g} in the URI, or a smaller window (roi){}", kSafeShare * most_fps, wider);
  fact.in_order = false;
  return fact;
}

void DescribeNetwork(const DeviceInfo& camera, const LinkPath& path, const DeviceStatistics& counted,
                     const Sent& sent, LinkFacts& described) {
  const NetworkLink& link = *path.network;
  const auto value = [&](TransportFigure figure) { return FigureIn(counted.transport, figure); };
  described.facts.push_back(NetworkFact(camera, link));
  if (sent.packet_size > 0)
    described.facts.push_back(
        PacketFact(link, sent, value(TransportFigure::kPacketSizeNegotiated).value_or(0) > 0));
  if (const auto asked = value(TransportFigure::kSocketBufferAsked))
    described.facts.push_back(
        BufferFact(path, sent, *asked, value(TransportFigure::kSocketBuffer).value_or(*asked)));
  if (const auto on = value(TransportFigure::kResends))
    described.facts.push_back({"resending", *on > 0 ? "on" : "off, or not supported by the camera",
                               *on > 0 ? "" : "every lost packet costs its frame"});
  if (!link.bytes_per_s || sent.payload_bytes <= 0 || sent.packet_size <= 0) return;
  described.most_fps = MostGigeFps(*link.bytes_per_s, sent.payload_bytes, static_cast<int>(sent.packet_size));
  // Jumbo frames are the remedy only where they are enough.
  const bool jumbo_is_enough = sent.fps && sent.packet_size <= kEthernetMtu &&
                               *sent.fps <= MostGigeFps(*link.bytes_per_s, sent.payload_bytes, kJumboMtu);
  described.facts.push_back(
      RateFact(sent, *described.most_fps, jumbo_is_enough ? "; or " + JumboAdvice(link) : ""));
}

// Others that share a camera's way to the computer. Whether they stream is not known: what they could take is
// counted.
LinkFact NeighboursFact(const std::vector<UsbNeighbour>& neighbours, const Sent& sent) {
  LinkFact fact{"beside it", ""};
  double hub_bytes_per_s = 0, others_bytes_per_s = 0;
  for (const UsbNeighbour& each : neighbours) {
    fact.value += fmt::format(
        "{}{} (port {}, {} Mbit/s) {}", fact.value.empty() ? "" : "; ", each.name, each.port, each.megabits,
        each.hub.empty() ? "at the same controller" : "behind the same hub " + each.hub);
    if (each.hub.empty()) continue;
    const double carries = UsbBytesPerSecond(each.hub_megabits);
    hub_bytes_per_s = hub_bytes_per_s > 0 ? std::min(hub_bytes_per_s, carries) : carries;
    others_bytes_per_s += UsbBytesPerSecond(each.megabits);
  }
  fact.advice = "what streams at once shares the controller: check such cameras together";
  if (!(hub_bytes_per_s > 0)) return fact;
  fact.value += fmt::format(". The hub carries about {:.0f} MB/s for all", MegabytesPerS(hub_bytes_per_s));
  if (sent.fps) fact.value += fmt::format(", this camera is set to {:.1f}", MegabytesPerS(sent.BytesPerS()));
  fact.value += fmt::format(", the others can take {:.0f}", MegabytesPerS(others_bytes_per_s));
  if (sent.BytesPerS() + others_bytes_per_s > hub_bytes_per_s)
    fact.advice = fmt::format(
        "where they stream at once: a port of the computer for each, or {:.0f} MB/s for all cameras together "
        "(fps or throughput_limit in the URI)",
        MegabytesPerS(hub_bytes_per_s));
  return fact;
}

void DescribeUsb(const LinkPath& path, const Sent& sent, LinkFacts& described) {
  if (path.usb) {
    const std::string slow = SlowUsbText(*path.usb);
    described.facts.push_back(
        {"port", fmt::format("{} at {} Mbit/s", path.usb->port, path.usb->megabits), slow});
    if (sent.payload_bytes > 0 && path.usb->megabits > 0) {
      described.most_fps = UsbBytesPerSecond(path.usb->megabits) / sent.payload_bytes;
      described.facts.push_back(RateFact(sent, *described.most_fps, slow.empty() ? "" : "; or a USB 3 port"));
      described.facts[described.facts.size() - 2].in_order = slow.empty() || described.facts.back().in_order;
    }
  }
  if (!path.usb_neighbours.empty()) described.facts.push_back(NeighboursFact(path.usb_neighbours, sent));
  if (path.usb_memory_mb)
    described.facts.push_back(
        {"USB memory", fmt::format("{} MB for all programs together", *path.usb_memory_mb),
         *path.usb_memory_mb > 0 ? "where several cameras stream: 'echo 1000 > "
                                   "/sys/module/usbcore/parameters/usbfs_memory_mb' as root (udev/README.md)"
                                 : ""});
}

// A camera that holds itself back (DeviceLinkThroughputLimit) loses nothing, and sends less than it is set
// to.
void DescribeLimit(double limit, const Sent& sent, LinkFacts& described) {
  LinkFact fact{"camera's limit",
                fmt::format("{:.1f} MB/s (DeviceLinkThroughputLimit)", MegabytesPerS(limit))};
  if (sent.payload_bytes > 0)
    fact.value += fmt::format(", {:.1f} frames a second", limit / sent.payload_bytes);
  if (limit < kSameRate * sent.BytesPerS()) {
    // With the room that headers take, and not more than the link has.
    double wanted = ThroughputLimitFor(sent.BytesPerS());
    if (described.most_fps)
      wanted = std::min(wanted, ThroughputLimitFor(*described.most_fps * sent.payload_bytes));
    if (wanted > limit) {
      fact.value += fmt::format(" of the {:.1f} that it is set to", *sent.fps);
      fact.advice = fmt::format("throughput_limit={:.0f} in the URI", wanted);
      fact.in_order = false;
    }
  }
  described.facts.push_back(std::move(fact));
}

}  // namespace

LinkPath LinkPathTo(const DeviceInfo& camera) {
  LinkPath path;
  if (!camera.address.empty()) {
    path.network = NetworkLinkTo(camera.address);
    path.most_buffer = MostSocketBuffer();
  }
  if (camera.bus == "USB3Vision") {
    path.usb = UsbCameraPlaceOf(camera.maker, camera.serial);
    path.usb_memory_mb = UsbMemoryMb();
    if (path.usb) path.usb_neighbours = UsbNeighboursOf(path.usb->port);
  }
  return path;
}

LinkFacts DescribeLink(const DeviceInfo& camera, const LinkPath& path, const DeviceStatistics& counted) {
  LinkFacts described;
  described.payload_bytes = FigureIn(counted.transport, TransportFigure::kPayloadBytes).value_or(0);
  if (described.payload_bytes <= 0 && counted.delivered > 0)
    described.payload_bytes = static_cast<double>(counted.bytes) / static_cast<double>(counted.delivered);
  described.set_fps = FigureIn(counted.transport, TransportFigure::kSetFps);
  described.exposure_s = 1e-6 * FigureIn(counted.transport, TransportFigure::kExposureUs).value_or(0);
  Sent sent{.payload_bytes = described.payload_bytes,
            .packet_size = FigureIn(counted.transport, TransportFigure::kPacketSize).value_or(0),
            .fps = described.set_fps,
            .set_fps = described.set_fps};
  if (sent.fps && described.exposure_s > 0) sent.fps = std::min(*sent.fps, 1 / described.exposure_s);
  if (path.network) DescribeNetwork(camera, path, counted, sent, described);
  if (camera.bus == "USB3Vision") DescribeUsb(path, sent, described);
  if (const auto limit = FigureIn(counted.transport, TransportFigure::kThroughputLimit))
    DescribeLimit(*limit, sent, described);
  return described;
}

std::optional<LinkFact> LostSoFar(const DeviceInfo& camera, const DeviceStatistics& counted) {
  const std::uint64_t lost = counted.incomplete + counted.missing;
  const std::uint64_t all = lost + counted.delivered + counted.dropped;
  if (all == 0 || (camera.address.empty() && camera.bus != "USB3Vision")) return std::nullopt;
  LinkFact fact{"frames", fmt::format("{} of {} did not arrive whole", lost, Counted(all, "frame"))};
  if (lost >= kLeastLost && static_cast<double>(lost) >= kLeastLostShare * static_cast<double>(all)) {
    fact.advice =
        fmt::format("ulf devices --check '{}' finds the setting with which none is lost", camera.uri);
    fact.in_order = false;
  }
  return fact;
}

std::string CameraLimitText(double fps, const LinkFacts& facts) {
  // Shares of what the link carries, and of what the exposure allows before the sensor is read out. Guessed.
  constexpr double kLinkHasRoom = 0.8, kReadOutAfterwards = 0.5;
  if (const double allowed = facts.exposure_s > 0 ? 1 / facts.exposure_s : 0;
      allowed > 0 && fps >= kReadOutAfterwards * allowed && (!facts.set_fps || allowed < *facts.set_fps))
    return fmt::format(
        "its exposure time of {:.4g} ms allows at most {:.4g} frames a second: a shorter one (exposure_us) "
        "allows more",
        1e3 * facts.exposure_s, allowed);
  if (facts.set_fps && fps >= kAsSet * *facts.set_fps)
    return fmt::format("its exposure time or its own maximum allows {:.4g} frames a second", *facts.set_fps);
  if (facts.most_fps && fps < kLinkHasRoom * *facts.most_fps)
    return fmt::format("it sent {:.4g} frames a second where the link carries {:.4g}", fps, *facts.most_fps);
  // Between its frames the link has nothing to do.
  if (facts.set_fps && !facts.most_fps && facts.busy_share < kLinkHasRoom)
    return fmt::format("it sent {:.4g} of the {:.4g} frames a second that it is set to, and none was lost",
                       fps, *facts.set_fps);
  return "";
}

double GigePackets(double payload_bytes, double packet_size) {
  const double data = packet_size - kPacketHeaders;
  return data > 0 ? std::ceil(payload_bytes / data) : 0;
}

double MostGigeFps(double link_bytes_per_s, double payload_bytes, int packet_size) {
  constexpr double kAroundIt = 14 + 4 + 8 + 12;  // Ethernet's header and checksum, preamble, gap
  const double packets = GigePackets(payload_bytes, packet_size);
  if (!(packets > 0)) return 0;
  return link_bytes_per_s /
         (payload_bytes + (packets + 2) * (kPacketHeaders + kAroundIt));  // leader and trailer
}

double ThroughputLimitFor(double pixels_per_s) {
  constexpr double kHeaderRoom = 1.1;  // guessed: small packets have some five hundredths of headers
  return std::ceil(kHeaderRoom * pixels_per_s);
}

}  // namespace ulf::acquisition
