#include "commands/reports/device_report.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/base/counted.h"

namespace ulf::commands {
namespace {

double PerSecond(double count, double seconds) { return seconds > 0 ? count / seconds : 0; }

std::string Number(double value) {
  return value == std::round(value) ? fmt::format("{:.0f}", value) : fmt::format("{:.3g}", value);
}

// Lists the counters that are not zero; --json has all of them.
std::string TransportText(const acquisition::DeviceStatistics& statistics) {
  constexpr std::size_t kLineWidth = 93;  // after the indent
  constexpr const char* kIndent = "\n               ";
  std::string text, line;
  for (const auto& [figure, value] : statistics.transport) {
    if (value == 0) continue;
    const std::string item = fmt::format("{} {}", Name(figure), Number(value));
    if (text.empty() && line.empty())
      text = "\ntransport      ";
    else if (line.size() + item.size() > kLineWidth) {
      text += line + "," + kIndent;
      line.clear();
    }
    line += (line.empty() ? "" : ", ") + item;
  }
  return text + line;
}

}  // namespace

std::string ToText(const acquisition::DeviceStatistics& statistics) {
  std::string text = Counted(statistics.delivered, "frame") + " delivered";
  if (statistics.seconds > 0)
    text += fmt::format(" in {:.1f} s ({:.1f} a second, {:.1f} MB/s)", statistics.seconds,
                        PerSecond(static_cast<double>(statistics.delivered), statistics.seconds),
                        1e-6 * PerSecond(static_cast<double>(statistics.bytes), statistics.seconds));
  text += fmt::format("; {} incomplete, {} dropped (processing too slow), {} missing", statistics.incomplete,
                      statistics.dropped, statistics.missing);
  if (statistics.out_of_order > 0) text += fmt::format(", {} out of order", statistics.out_of_order);
  if (statistics.late > 0) text += fmt::format(", {} late", statistics.late);
  if (statistics.reconnects > 0) text += "; reconnected " + Counted(statistics.reconnects, "time");
  if (statistics.clock_offset_s)
    text += fmt::format("\nclock          {:.6f} s behind this computer's", *statistics.clock_offset_s);
  if (statistics.clock_jitter_s) text += fmt::format(", jitter {:.3f} ms", 1e3 * *statistics.clock_jitter_s);
  return text + TransportText(statistics);
}

nlohmann::ordered_json ToJson(const acquisition::DeviceStatistics& statistics) {
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
  for (const auto& [figure, value] : statistics.transport) json["transport"][Name(figure)] = value;
  return json;
}

}  // namespace ulf::commands
