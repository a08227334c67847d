#include "acquisition/device_report.h"

#include <nlohmann/json.hpp>

namespace ulf {
namespace {

double PerSecond(double count, double seconds) { return seconds > 0 ? count / seconds : 0; }

}  // namespace

std::string ToText(const DeviceStatistics& statistics) {
  std::string text = fmt::format("{} frames delivered", statistics.delivered);
  if (statistics.seconds > 0)
    text += fmt::format(" in {:.1f} s ({:.1f} a second, {:.1f} MB/s)", statistics.seconds,
                        PerSecond(static_cast<double>(statistics.delivered), statistics.seconds),
                        1e-6 * PerSecond(static_cast<double>(statistics.bytes), statistics.seconds));
  text += fmt::format("; {} incomplete, {} dropped because we were slow, {} missing", statistics.incomplete,
                      statistics.dropped, statistics.missing);
  if (statistics.out_of_order > 0) text += fmt::format(", {} out of order", statistics.out_of_order);
  if (statistics.late > 0) text += fmt::format(", {} late", statistics.late);
  if (statistics.reconnects > 0) text += fmt::format("; reconnected {} times", statistics.reconnects);
  if (statistics.clock_offset_s) text += fmt::format("; clock offset {:.6f} s", *statistics.clock_offset_s);
  if (statistics.clock_jitter_s) text += fmt::format(", jitter {:.3f} ms", 1e3 * *statistics.clock_jitter_s);
  std::string transport;
  for (const auto& [name, value] : statistics.transport)
    transport += fmt::format("{}{} {:g}", transport.empty() ? "\ntransport      " : ", ", name, value);
  return text + transport;
}

nlohmann::ordered_json ToJson(const DeviceStatistics& statistics) {
  const auto number = [](const std::optional<double>& value) {
    return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
  };
  nlohmann::ordered_json json{
      {"delivered", statistics.delivered},
      {"incomplete", statistics.incomplete},
      {"dropped", statistics.dropped},
      {"missing", statistics.missing},
      {"out_of_order", statistics.out_of_order},
      {"late", statistics.late},
      {"reconnects", statistics.reconnects},
      {"seconds", statistics.seconds},
      {"bytes", statistics.bytes},
      {"fps", PerSecond(static_cast<double>(statistics.delivered), statistics.seconds)},
      {"bytes_per_s", PerSecond(static_cast<double>(statistics.bytes), statistics.seconds)},
      {"clock_offset_s", number(statistics.clock_offset_s)},
      {"clock_jitter_s", number(statistics.clock_jitter_s)}};
  json["transport"] = nlohmann::ordered_json::object();
  for (const auto& [name, value] : statistics.transport) json["transport"][name] = value;
  return json;
}

}  // namespace ulf
