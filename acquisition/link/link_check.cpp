#include "acquisition/link/link_check.h"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "acquisition/opening/open_device.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/host_time.h"

namespace ulf::acquisition {
namespace {

constexpr double kRateShare = 0.8;  // of the rate that came, whole or not, what is tried next; guessed

struct Streamed {
  LinkTrial trial;
  DeviceInfo camera;
  DeviceStatistics statistics;
  double transfer_s = 0;  // from the first packet of a frame to the last, the shortest; 0: no frame came
};

// From the first frame on; none where a stop was asked for. What lacks packets before the first whole frame
// is no loss of the link's: the library's receive buffer grows only when packets come.
std::optional<Streamed> Stream(const std::string& uri, const std::string& settings, double seconds,
                               const LinkCheckOptions& options) {
  DeviceUri with = DeviceUri::Parse(uri);
  for (const auto& [option, value] : DeviceUri::Parse(with.scheme + ":?" + settings).options)
    with.Set(option, value);
  if (with.scheme == "replay")
    throw Refused(uri, "is no camera", "a link is checked with one that streams, such as aravis:192.0.2.7");
  const std::unique_ptr<Device> device = OpenDevice(with.Text());
  Streamed streamed;
  streamed.camera = device->Info();
  device->Start();
  using Clock = std::chrono::steady_clock;
  const auto started = Clock::now();
  std::optional<Clock::time_point> first;
  std::uint64_t incomplete_before = 0;
  while (SecondsSince(first.value_or(started)) < (first ? seconds : options.first_frame_s) &&
         !IsOver(device->State())) {
    if (options.stop && options.stop()) return std::nullopt;
    const auto frame = device->Next(std::chrono::milliseconds(100));
    if (!frame) continue;
    const double since_s = EpochSeconds() - frame->host_time_s;
    if (since_s > 0 && (streamed.transfer_s <= 0 || since_s < streamed.transfer_s))
      streamed.transfer_s = since_s;
    if (first) continue;
    first = Clock::now();
    incomplete_before = device->Statistics().incomplete;
  }
  LinkTrial& trial = streamed.trial;
  trial.settings = settings;
  trial.seconds = first ? SecondsSince(*first) : 0;
  streamed.statistics = device->Statistics();
  device->Stop();
  const DeviceStatistics& counted = streamed.statistics;
  trial.whole = counted.delivered + counted.dropped;
  trial.incomplete = counted.incomplete - incomplete_before;
  trial.missing = counted.missing;
  trial.fps = trial.seconds > 0
                  ? static_cast<double>(trial.whole + trial.incomplete + trial.missing) / trial.seconds
                  : 0;
  trial.asked_fps = with.Number("fps").value_or(0);
  trial.set_fps = FigureIn(counted.transport, TransportFigure::kSetFps).value_or(0);
  trial.resent_packets = FigureIn(counted.transport, TransportFigure::kPacketsResent).value_or(0);
  return streamed;
}

// Other devices on the same wire share it.
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
  // What holds by chance for a while is no remedy: it must hold for longer. True: nothing else is to be
  // tried.
  bool refused = false;  // the last one tried: the camera does not take it
  const auto is_remedy = [&](const std::string& settings) {
    refused = false;
    for (const double times : {1.0, options.confirmed_times}) {
      std::optional<Streamed> streamed;
      try {
        streamed = try_with(settings, times * options.seconds);
      } catch (const Refusal&) {
        refused = true;
        return false;
      }
      if (!streamed) return true;
      if (!streamed->trial.Held()) return false;
    }
    report.remedy = settings;
    return true;
  };
  const auto streamed = try_with("", options.seconds);
  if (!streamed) return report;
  report.camera = streamed->camera;
  const LinkPath path = LinkPathTo(report.camera);
  LinkFacts described = DescribeLink(report.camera, path, streamed->statistics);
  report.facts = std::move(described.facts);
  report.payload_bytes = described.payload_bytes;
  report.most_fps = described.most_fps;
  DescribeNeighbours(report.camera, report);
  const LinkTrial& first = streamed->trial;
  if (!report.camera.address.empty()) described.busy_share = streamed->transfer_s * first.fps;
  if (first.BelowWhatIsSet()) report.camera_limit = CameraLimitText(first.fps, described);
  if (first.Held()) return report;
  // What the facts say is wrong is not dismissed for one lost frame, which a busy computer makes, too.
  const auto is_known_remedy = [&](const std::string& settings) {
    return is_remedy(settings) || is_remedy(settings);
  };
  const auto value = [&](TransportFigure figure) {
    return FigureIn(streamed->statistics.transport, figure).value_or(0);
  };
  const double packet_size = value(TransportFigure::kPacketSize);
  // A frame must find room, however late it is read; beyond what the system allows the fact names the
  // command.
  const double room = 2 * report.payload_bytes, granted = value(TransportFigure::kSocketBuffer);
  if (first.LostFrames() && 0 < granted && granted < room && room <= path.most_buffer.value_or(0))
    if (is_known_remedy(fmt::format("socket_buffer={:.0f}", room))) return report;
  // A path that does not pass large packets loses them all; one that is full loses whatever their size.
  if (first.whole == 0)
    for (const int size : options.packet_sizes)
      if (size < packet_size && is_remedy(fmt::format("packet_size={}", size))) return report;
  // A camera that limits itself loses nothing.
  const double wanted = ThroughputLimitFor(first.asked_fps * report.payload_bytes);
  if (const double limit = value(TransportFigure::kThroughputLimit);
      !first.LostFrames() && 0 < limit && limit < wanted)
    if (is_known_remedy(fmt::format("throughput_limit={:.0f}", wanted))) return report;
  // A switch that is fast enough may still not hold a whole frame: spread over the frame's period its packets
  // pass.
  const double packets = first.LostFrames() ? GigePackets(report.payload_bytes, packet_size) : 0;
  const auto spread = [&](double fps) {
    constexpr double kOfThePeriod = 0.8;  // the rest is for the packets themselves. Guessed.
    return fmt::format("packet_delay_ns={:.0f}", std::floor(1e9 * kOfThePeriod / (fps * packets)));
  };
  if (packets > 0 && first.fps > 0 && is_remedy(spread(std::max(first.asked_fps, first.fps)))) return report;
  // A camera that is slower than its link sends what it can; what came held.
  if (!first.LostFrames()) report.camera_limit = CameraLimitText(first.fps, described);
  if (!report.camera_limit.empty() &&
      is_remedy(fmt::format("fps={:.4g}", std::min(first.fps, described.set_fps.value_or(first.fps)))))
    return report;
  // What came through whole or not: a sender that waits for its link sends what that carries.
  double fps = kRateShare * first.fps;
  for (int i = 0; i < options.most_rates && fps > 0; ++i, fps *= kRateShare) {
    const std::string slower = fmt::format("fps={:.4g}", fps);
    if (refused && !report.camera_limit.empty()) return report;
    if (!is_remedy(packets > 0 ? slower + "&" + spread(fps) : slower)) continue;
    // One setting is better than two.
    if (packets > 0 && report.remedy) {
      const std::optional<std::string> both = std::exchange(report.remedy, std::nullopt);
      is_remedy(slower);
      if (!report.remedy) report.remedy = both;
    }
    return report;
  }
  return report;
}

}  // namespace ulf::acquisition
