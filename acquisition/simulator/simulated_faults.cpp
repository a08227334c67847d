#include "acquisition/simulator/simulated_faults.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <functional>

#include "core/base/error.h"

namespace ulf::acquisition {
namespace {

[[noreturn]] void Refuse(const std::string& name, const std::string& text, const std::string& wanted) {
  throw Refusal(fmt::format("fault {}", name), "", fmt::format("'{}' must be {}", text, wanted), "");
}

double NumberFrom(const std::string& name, const std::string& text, double low, double high) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !(value >= low && value <= high))
    Refuse(name, text, fmt::format("a number from {:g} to {:g}", low, high));
  return value;
}

double ShareFrom(const std::string& name, const std::string& text) { return NumberFrom(name, text, 0, 1); }

std::pair<double, double> PairFrom(const std::string& name, const std::string& text, const char* wanted,
                                   double most_first, double most_second) {
  const std::size_t colon = text.find(':');
  if (colon == std::string::npos) Refuse(name, text, wanted);
  return {NumberFrom(name, text.substr(0, colon), 0, most_first),
          NumberFrom(name, text.substr(colon + 1), 0, most_second)};
}

FaultSpan SpanFrom(const std::string& name, const std::string& text) {
  constexpr double kDay = 86400;
  const auto [at_s, for_s] = PairFrom(name, text, "AT:SECONDS, for example 5:2", kDay, kDay);
  return {at_s, for_s};
}

using Faults = SimulatedFaults;
using Setter = std::function<void(Faults&, const std::string& name, const std::string& text)>;
const std::vector<std::pair<std::string, Setter>>& Setters() {
  using S = const std::string&;
  static const std::vector<std::pair<std::string, Setter>> setters = {
      {"lost", [](Faults& f, S n, S t) { f.link.lost = ShareFrom(n, t); }},
      {"doubled", [](Faults& f, S n, S t) { f.link.doubled = ShareFrom(n, t); }},
      {"swapped", [](Faults& f, S n, S t) { f.link.swapped = ShareFrom(n, t); }},
      {"resend",
       [](Faults& f, S n, S t) {
         if (t != "0" && t != "1") Refuse(n, t, "0 or 1");
         f.resends = t == "1";
       }},
      {"late",
       [](Faults& f, S n, S t) {
         const auto [ms, share] = PairFrom(n, t, "MILLISECONDS:SHARE, for example 80:0.1", 10000, 1);
         f.link.late_by = std::chrono::milliseconds(std::lround(ms));
         f.link.late = share;
       }},
      {"incomplete", [](Faults& f, S n, S t) { f.incomplete = ShareFrom(n, t); }},
      {"freeze", [](Faults& f, S n, S t) { f.freezes.push_back(SpanFrom(n, t)); }},
      {"ptp_lost", [](Faults& f, S n, S t) { f.masters_lost.push_back(SpanFrom(n, t)); }},
      {"disconnect", [](Faults& f, S n, S t) { f.disconnects.push_back(SpanFrom(n, t)); }},
      {"drift", [](Faults& f, S n, S t) { f.drift_stops_per_minute = NumberFrom(n, t, -60, 60); }},
      {"flicker",
       [](Faults& f, S n, S t) {
         const auto [hz, depth] = PairFrom(n, t, "HERTZ:SHARE, for example 100:0.4", 1000, 1);
         f.flicker = {hz, depth};
       }},
      {"defocus", [](Faults& f, S n, S t) { f.defocus_px = NumberFrom(n, t, 0, 50); }},
      {"hunting",
       [](Faults& f, S n, S t) {
         const auto [radius_px, period_s] = PairFrom(n, t, "PIXELS:SECONDS, for example 4:1.6", 50, 60);
         if (!(period_s >= 0.2)) Refuse(n, t, "PIXELS:SECONDS with 0.2 seconds at least");
         f.hunting = {radius_px, period_s};
       }},
      {"lens", [](Faults& f, S n, S t) { f.focal_ratio = NumberFrom(n, t, 0.5, 2); }},
      {"dust", [](Faults& f, S n, S t) { f.dust_spots = static_cast<int>(NumberFrom(n, t, 0, 1000)); }},
      {"auto_exposure",
       [](Faults& f, S n, S t) {
         if (t != "told" && t != "untold") Refuse(n, t, "told or untold");
         f.auto_exposure = t == "told" ? AutoExposure::kTold : AutoExposure::kUntold;
       }},
      {"bluer", [](Faults& f, S n, S t) { f.bluer_stops_per_minute = NumberFrom(n, t, -60, 60); }},
  };
  return setters;
}

}  // namespace

void SimulatedFaults::Add(const std::string& text) {
  const std::size_t equals = text.find('=');
  const std::string name = text.substr(0, equals);
  for (const auto& [known, setter] : Setters())
    if (known == name && equals != std::string::npos) return setter(*this, name, text.substr(equals + 1));
  throw Refusal("", text, fmt::format("'{}' is not a fault", text),
                fmt::format("write name=value with one of: {}", fmt::join(SimulatedFaultNames(), ", ")));
}

bool SimulatedFaults::NeedRelay() const {
  return link.lost > 0 || link.doubled > 0 || link.swapped > 0 || link.late > 0 || !freezes.empty() ||
         !disconnects.empty();
}

std::array<double, 3> SimulatedFaults::Light(double t_s) const {
  const double all = std::exp2(drift_stops_per_minute * t_s / 60),
               blue = std::exp2(bluer_stops_per_minute * t_s / 60);
  return {all / blue, all, all * blue};
}

std::vector<std::string> SimulatedFaultNames() {
  std::vector<std::string> names;
  for (const auto& [name, setter] : Setters()) names.push_back(name);
  return names;
}

}  // namespace ulf::acquisition
