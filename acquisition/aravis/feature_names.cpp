#include "acquisition/aravis/feature_names.h"

#include <algorithm>
#include <initializer_list>
#include <utility>

namespace ulf::acquisition {
namespace {

using Alternatives = std::initializer_list<const char*>;
using Kinds = std::initializer_list<FeatureType>;
using Units = std::initializer_list<std::pair<const char*, double>>;

constexpr auto kInteger = FeatureType::kInteger, kReal = FeatureType::kFloat,
               kChoice = FeatureType::kEnumeration;

// Returns the first of the names that is of one of the kinds and suits; available ones come first.
template <typename Suits>
std::string FirstOfKinds(const NamedFeatures& camera, Kinds kinds, Alternatives names, Suits&& suits) {
  for (const bool available : {true, false})
    for (const char* name : names)
      if (std::find(kinds.begin(), kinds.end(), camera.kind_of(name)) != kinds.end() &&
          camera.is_available(name) == available && suits(name))
        return name;
  return "";
}
std::string FirstOfKinds(const NamedFeatures& camera, Kinds kinds, Alternatives names) {
  return FirstOfKinds(camera, kinds, names, [](const char*) { return true; });
}

// Returns the first of the names that the feature has among its choices.
std::string FirstChoice(const NamedFeatures& camera, const std::string& feature, Alternatives names) {
  if (feature.empty()) return "";
  const std::vector<std::string> choices = camera.choices_of(feature);
  for (const char* name : names)
    if (std::find(choices.begin(), choices.end(), name) != choices.end()) return name;
  return "";
}

std::optional<double> Find(Units units, const std::string& unit) {
  for (const auto& [name, size] : units)
    if (unit == name) return size;
  return std::nullopt;
}

void FindExposure(const NamedFeatures& camera, FeatureNames& found) {
  const auto is_time = [&](const char* name) { return MicrosecondsIn(camera.unit_of(name)).has_value(); };
  // Decimals first: where a camera has both, the whole number counts in a unit of its own.
  found.exposure = FirstOfKinds(camera, {kReal}, {"ExposureTime", "ExposureTimeAbs"}, is_time);
  if (found.exposure.empty())
    found.exposure =
        FirstOfKinds(camera, {kInteger},
                     {"ExposureTime", "ExposureTimeAbs", "AcquisitionExpTime", "ExposureTimeRaw"}, is_time);
  if (!found.exposure.empty()) found.exposure_us = MicrosecondsIn(camera.unit_of(found.exposure)).value_or(1);
}

// A gain without a unit is by the convention (SFNC 2) a factor, but decibels and steps of a converter are
// found without one, too. Those begin at 0 or below, which no factor does.
void FindGain(const NamedFeatures& camera, FeatureNames& found) {
  const auto is_decibels = [&](const char* name) { return IsDecibel(camera.unit_of(name)); };
  const auto is_factor = [&](const char* name) {
    return camera.unit_of(name).empty() && camera.least_of(name).value_or(0) > 0;
  };
  found.gain = FirstOfKinds(camera, {kReal, kInteger}, {"Gain", "GainAbs", "GainRaw"}, is_decibels);
  if (found.gain.empty()) {
    found.gain = FirstOfKinds(camera, {kReal}, {"Gain", "GainAbs"}, is_factor);
    found.gain_is_factor = !found.gain.empty();
  }
  found.gain_raw = FirstOfKinds(camera, {kInteger, kReal}, {"GainRaw", "Gain", "GainAbs"},
                                [&](const char* name) { return name != found.gain; });
  found.gain_selector = FirstOfKinds(camera, {kChoice}, {"GainSelector"});
  found.gain_of_all = FirstChoice(camera, found.gain_selector, {"All", "AnalogAll", "DigitalAll"});
}

void FindTrigger(const NamedFeatures& camera, FeatureNames& found) {
  found.trigger_mode = FirstOfKinds(camera, {kChoice}, {"TriggerMode"});
  found.trigger_source = FirstOfKinds(camera, {kChoice}, {"TriggerSource"});
  found.trigger_software = FirstOfKinds(camera, {FeatureType::kCommand}, {"TriggerSoftware"});
  found.software_source =
      FirstChoice(camera, found.trigger_source, {"Software", "SoftTrigger", "SoftwareTrigger"});
  found.trigger_selector = FirstOfKinds(camera, {kChoice}, {"TriggerSelector"});
  found.frame_trigger = FirstChoice(camera, found.trigger_selector,
                                    {"FrameStart", "ExposureStart", "FrameBurstStart", "AcquisitionStart"});
}

void FindWhiteBalance(const NamedFeatures& camera, FeatureNames& found) {
  found.white_balance_auto = FirstOfKinds(camera, {kChoice}, {"BalanceWhiteAuto"});
  found.balance_selector = FirstOfKinds(camera, {kChoice}, {"BalanceRatioSelector"});
  if (!found.balance_selector.empty())
    found.balance_ratio =
        FirstOfKinds(camera, {kReal, kInteger}, {"BalanceRatio", "BalanceRatioAbs", "BalanceRatioRaw"});
  if (!found.balance_ratio.empty() || !found.gain_is_factor) return;
  for (const char* colour : {"Red", "Green", "Blue"})
    if (FirstChoice(camera, found.gain_selector, {colour}).empty()) return;
  found.balance_selector = found.gain_selector;
  found.balance_ratio = found.gain;
  found.balance_is_gain = true;
}

void FindThroughputLimit(const NamedFeatures& camera, FeatureNames& found) {
  found.throughput_limit =
      FirstOfKinds(camera, {kInteger, kReal}, {"DeviceLinkThroughputLimit", "StreamBytesPerSecond"});
  if (found.throughput_limit.empty()) return;
  // Units are of bytes: no camera was seen that counts bits, and not everybody who writes "bps" means them.
  const std::string unit = camera.unit_of(found.throughput_limit);
  found.throughput_bytes = Find({{"", 1},
                                 {"Bps", 1},
                                 {"B/s", 1},
                                 {"bytes/s", 1},
                                 {"Bytes/s", 1},
                                 {"KB", 1e3},
                                 {"KBps", 1e3},
                                 {"KB/s", 1e3},
                                 {"kB/s", 1e3},
                                 {"MB", 1e6},
                                 {"MBps", 1e6},
                                 {"MB/s", 1e6}},
                                unit)
                               .value_or(0);
  found.throughput_mode = FirstOfKinds(camera, {kChoice}, {"DeviceLinkThroughputLimitMode"});
}

}  // namespace

std::optional<double> MicrosecondsIn(const std::string& unit) {
  return Find({{"", 1},
               {"us", 1},
               {"usec", 1},
               {"\u00b5s", 1},  // the micro sign
               {"\u03bcs", 1},  // the Greek letter
               {"microseconds", 1},
               {"ns", 1e-3},
               {"ms", 1e3},
               {"msec", 1e3},
               {"milliseconds", 1e3},
               {"s", 1e6},
               {"sec", 1e6},
               {"seconds", 1e6}},
              unit);
}

bool IsDecibel(const std::string& unit) { return unit == "dB" || unit == "db" || unit == "DB"; }

FeatureNames FindFeatureNames(const NamedFeatures& camera) {
  FeatureNames found;
  FindExposure(camera, found);
  FindGain(camera, found);
  found.pixel_format = FirstOfKinds(camera, {kChoice}, {"PixelFormat"});
  FindTrigger(camera, found);
  FindWhiteBalance(camera, found);
  FindThroughputLimit(camera, found);
  return found;
}

}  // namespace ulf::acquisition
