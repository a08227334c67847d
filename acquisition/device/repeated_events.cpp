#include "acquisition/device/repeated_events.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <ctime>
#include <utility>

namespace ulf::acquisition {
namespace {

std::string WithoutNumbers(const std::string& text) {
  std::string pattern;
  for (const char c : text)
    if (!std::isdigit(static_cast<unsigned char>(c))) pattern += c;
  return pattern;
}

std::string TimeOfDay(double epoch_s) {
  const auto time = static_cast<std::time_t>(epoch_s);
  std::tm local{};
  localtime_r(&time, &local);
  return fmt::format("{:02}:{:02}", local.tm_hour, local.tm_min);
}

}  // namespace

std::string RepeatedEvents::Line(const Repeated& repeated) const {
  const double silence_s = repeated.silence_s + repeated.open_s;
  return fmt::format(
      "{} ({} times since {})",
      silence_s > 0 ? fmt::format("no frame for {:.0f} s", std::max(1.0, silence_s)) : repeated.text,
      repeated.count, TimeOfDay(repeated.first_s));
}

void RepeatedEvents::Note(const DeviceEvent& event, std::vector<std::string>& lines) {
  const bool repeats = event.kind == DeviceEventKind::kStalled || event.kind == DeviceEventKind::kNotice;
  if (!repeats) return lines.push_back(event.text);
  const bool ends_stall = event.kind == DeviceEventKind::kNotice && event.silence_s > 0;
  if (ends_stall) {
    // Belongs to the stall that it ends, and is said with the first one alone.
    const auto stall =
        std::ranges::find_if(known_, [](const Repeated& repeated) { return repeated.open_s > 0; });
    if (stall == known_.end()) return lines.push_back(event.text);
    stall->silence_s += event.silence_s;
    stall->open_s = 0;
    if (stall->count == 1) lines.push_back(event.text);
    return;
  }
  const std::string pattern =
      event.kind == DeviceEventKind::kStalled ? WithoutNumbers(event.text) : event.text;
  const auto known = std::ranges::find(known_, pattern, &Repeated::pattern);
  if (known == known_.end()) {
    known_.push_back({.pattern = pattern,
                      .text = event.text,
                      .first_s = event.host_time_s,
                      .last_s = event.host_time_s,
                      .open_s = event.silence_s,
                      .said_s = event.host_time_s,
                      .wait_s = options_.every_s});
    return lines.push_back(event.text);
  }
  known->text = event.text;
  known->last_s = event.host_time_s;
  known->silence_s += known->open_s;  // it ended unseen
  known->open_s = event.silence_s;
  ++known->count;
}

std::vector<std::string> RepeatedEvents::Update(const std::vector<DeviceEvent>& events, double now_s) {
  std::vector<std::string> lines;
  for (const DeviceEvent& event : events) Note(event, lines);
  for (Repeated& repeated : known_) {
    if (repeated.count == repeated.said || now_s - repeated.said_s < repeated.wait_s) continue;
    lines.push_back(Line(repeated));
    repeated.said = repeated.count;
    repeated.said_s = now_s;
    repeated.wait_s = std::min(2 * repeated.wait_s, options_.longest_s);
  }
  std::erase_if(known_, [&](const Repeated& repeated) {
    return repeated.count == repeated.said && now_s - repeated.last_s > options_.forget_s;
  });
  return lines;
}

std::vector<std::string> RepeatedEvents::Finish() {
  std::vector<std::string> lines;
  for (Repeated& repeated : known_)
    if (repeated.count > std::exchange(repeated.said, repeated.count)) lines.push_back(Line(repeated));
  return lines;
}

}  // namespace ulf::acquisition
