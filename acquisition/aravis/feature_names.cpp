#include "acquisition/aravis/feature_names.h"

#include <algorithm>
#include <initializer_list>

namespace ulf::acquisition {
namespace {

using Names = std::initializer_list<const char*>;
using Kinds = std::initializer_list<NodeKind>;

// The first of the names that is of one of the kinds.
std::string FirstOfKinds(const NamedFeatures& camera, Kinds kinds, Names names) {
  for (const char* name : names)
    if (std::find(kinds.begin(), kinds.end(), camera.kind_of(name)) != kinds.end()) return name;
  return "";
}

}  // namespace

FeatureNames FindFeatureNames(const NamedFeatures& camera) {
  constexpr auto kInteger = NodeKind::kInteger, kReal = NodeKind::kReal, kChoice = NodeKind::kChoice;
  const auto first = [&](Kinds kinds, Names names) { return FirstOfKinds(camera, kinds, names); };
  FeatureNames found;
  // Decimals first: where a camera has both, the whole number counts in a unit of its own.
  found.exposure = first({kReal}, {"ExposureTime", "ExposureTimeAbs"});
  if (found.exposure.empty())
    found.exposure = first({kInteger}, {"ExposureTime", "ExposureTimeAbs", "ExposureTimeRaw"});
  found.exposure_auto = first({kChoice}, {"ExposureAuto"});
  found.gain_db = first({kReal}, {"Gain", "GainAbs"});
  found.gain_raw = first({kInteger}, {"GainRaw", "Gain"});
  found.gain_auto = first({kChoice}, {"GainAuto"});
  found.pixel_format = first({kChoice}, {"PixelFormat"});
  found.trigger_mode = first({kChoice}, {"TriggerMode"});
  found.trigger_source = first({kChoice}, {"TriggerSource"});
  found.trigger_software = first({NodeKind::kCommand}, {"TriggerSoftware"});
  if (!found.trigger_source.empty()) {
    const std::vector<std::string> sources = camera.choices_of(found.trigger_source);
    for (const char* name : {"Software", "SoftTrigger", "SoftwareTrigger"})
      if (found.software_source.empty() && std::find(sources.begin(), sources.end(), name) != sources.end())
        found.software_source = name;
  }
  found.white_balance_auto = first({kChoice}, {"BalanceWhiteAuto"});
  found.balance_selector = first({kChoice}, {"BalanceRatioSelector"});
  if (!found.balance_selector.empty())
    found.balance_ratio = first({kReal, kInteger}, {"BalanceRatio", "BalanceRatioAbs", "BalanceRatioRaw"});
  return found;
}

}  // namespace ulf::acquisition
