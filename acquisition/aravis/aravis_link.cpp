#include "acquisition/aravis/aravis_link.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "acquisition/aravis/aravis_setting.h"

namespace ulf::acquisition {
namespace {

// Bytes of a packet between programs on this computer. With its headers it fits in 8 KiB, the block that the
// kernel allocates; a larger packet takes 16 KiB of the receive buffer. Measured: at 9000 bytes one stream in
// ten began with a loss.
constexpr int kLocalPacketSize = 7800;

// Finds the largest packets that arrive, by test packets, which not every camera sends. Where none arrives,
// the library keeps the size without an error. Starting from a size that every network passes, a larger
// size therefore means that test packets arrived.
bool NegotiatePacketSize(ArvCamera* camera) {
  constexpr gint64 kSafePacketSize = 576;  // every IPv4 network passes it
  gint64 low = 0, high = 0;
  FailureOf(arv_camera_get_integer_bounds, camera, "GevSCPSPacketSize", &low, &high);
  const auto read = [&] { return TryCall(arv_camera_gv_get_packet_size, camera).value_or(0); };
  const auto write = [&](gint64 size) {
    FailureOf(arv_camera_gv_set_packet_size, camera, static_cast<gint>(size));
  };
  const guint own = read();
  write(std::max(kSafePacketSize, low));
  const guint smallest = read();
  FailureOf(arv_camera_gv_auto_packet_size, camera);
  const bool found = read() > smallest;
  if (!found) write(own);
  arv_camera_gv_set_packet_size_adjustment(camera, ARV_GV_PACKET_SIZE_ADJUSTMENT_NEVER);
  return found;
}

void WritePackets(ArvCamera* camera, const std::string& address, const std::string& who,
                  const AravisOptions& options, AravisLink& link, std::vector<std::string>& notes) {
  // Packet sockets bypass the guard (stream_guard.h), and receive nothing on some hosts.
  arv_camera_gv_set_stream_options(camera, ARV_GV_STREAM_OPTION_PACKET_SOCKET_DISABLED);
  std::optional<int> packet_size = options.packet_size;
  if (!packet_size && address.starts_with("127.")) packet_size = kLocalPacketSize;
  const auto own = [&] {
    return static_cast<int>(TryCall(arv_camera_gv_get_packet_size, camera).value_or(0));
  };
  if (packet_size) {
    arv_camera_gv_set_packet_size_adjustment(camera, ARV_GV_PACKET_SIZE_ADJUSTMENT_NEVER);
    std::optional<std::string> failure;
    if (own() != *packet_size) failure = FailureOf(arv_camera_gv_set_packet_size, camera, *packet_size);
    if (options.packet_size && failure)
      throw Refused(who,
                    fmt::format("packet_size={}: the camera keeps {}: {}", *packet_size, own(), *failure),
                    "leave packet_size out");
  } else {
    link.packet_size_negotiated = NegotiatePacketSize(camera);
  }
  link.packet_size = own();
  if (!packet_size && !link.packet_size_negotiated)
    notes.push_back(
        fmt::format("sent no test packet that arrived: its packets keep their size of {} bytes; if frames "
                    "are lost, give packet_size=1400",
                    link.packet_size));
  if (packet_size && link.packet_size != *packet_size)
    notes.push_back(fmt::format("changed packet_size={} to {}", *packet_size, link.packet_size));
  // The register is optional.
  const gint64 delay_ns = options.packet_delay_ns.value_or(0);
  const bool taken = TryCall(arv_camera_gv_get_packet_delay, camera) == delay_ns ||
                     !FailureOf(arv_camera_gv_set_packet_delay, camera, delay_ns);
  link.packet_delay_ns = TryCall(arv_camera_gv_get_packet_delay, camera).value_or(0);
  if (options.packet_delay_ns && (!taken || std::abs(link.packet_delay_ns - delay_ns) > delay_ns / 10))
    notes.push_back(fmt::format("changed packet_delay_ns={} to {}", delay_ns, link.packet_delay_ns));
}

AravisNumber LimitOf(const AravisSession& session, const FeatureNames& names) {
  return {session, names.throughput_limit, names.throughput_bytes};
}

void WriteThroughputLimit(const AravisSession& session, const std::string& who, const FeatureNames& names,
                          double limit) {
  if (names.throughput_limit.empty())
    throw Refused(who, "the camera does not limit its own throughput", "leave throughput_limit out");
  if (names.throughput_bytes == 0)
    throw Refused(
        who, fmt::format("the camera counts {} in a unit that ulf does not know", names.throughput_limit),
        "leave throughput_limit out and set it by 'ulf features'");
  // Before the limit: some cameras have none while the switch is off.
  const std::string asked = fmt::format("throughput_limit={:.0f}", limit);
  if (!names.throughput_mode.empty()) RequireSetting(session, who, asked, names.throughput_mode, "On");
  const AravisNumber number = LimitOf(session, names);
  if (number.Reads(limit)) return;
  if (const std::string why = number.WhyFixed(); !why.empty())
    throw Refused(who,
                  fmt::format("{}: {} {} at {:.0f} bytes a second", asked, number.Feature(), why,
                              number.Read().value_or(0)),
                  "leave throughput_limit out");
  const auto [low, high] = number.Bounds(who);
  if (limit < low || limit > high)
    throw Refused(
        who,
        fmt::format("throughput_limit={:.0f} is out of the camera's range, {:.0f} to {:.0f} bytes a second",
                    limit, low, high));
  const double step = number.Step();
  number.Write(who, step > 0 ? std::min(high, low + std::ceil((limit - low) / step) * step) : limit);
}

std::optional<double> ThroughputLimitOf(const AravisSession& session, const FeatureNames& names) {
  if (names.throughput_limit.empty() || names.throughput_bytes == 0) return std::nullopt;
  if (!names.throughput_mode.empty() &&
      Text(TryCall(arv_camera_get_string, session.Camera(), names.throughput_mode.c_str())
               .value_or(nullptr)) != "On")
    return std::nullopt;
  const std::optional<double> limit = LimitOf(session, names).Read();
  return limit && *limit > 0 ? limit : std::nullopt;
}

}  // namespace

AravisLink WriteAravisLink(const AravisSession& session, const std::string& who, const AravisOptions& options,
                           const FeatureNames& names, std::vector<std::string>& notes) {
  AravisLink link;
  if (const std::string address = session.GigeAddress(); !address.empty())
    WritePackets(session.Camera(), address, who, options, link, notes);
  if (options.throughput_limit) WriteThroughputLimit(session, who, names, *options.throughput_limit);
  link.throughput_limit = ThroughputLimitOf(session, names);
  return link;
}

}  // namespace ulf::acquisition
