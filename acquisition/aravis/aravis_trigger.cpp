#include "acquisition/aravis/aravis_trigger.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "acquisition/aravis/aravis_calls.h"

namespace ulf::acquisition {
namespace {

std::vector<std::string> ChoicesOf(const AravisSession& session, const std::string& feature) {
  return MaybeNames([&](guint* count, GError** e) {
    return arv_camera_dup_available_enumerations_as_strings(session.Camera(), feature.c_str(), count, e);
  });
}

bool Has(const std::vector<std::string>& choices, const std::string& choice) {
  return std::find(choices.begin(), choices.end(), choice) != choices.end();
}

bool IsWritable(const AravisSession& session, const std::string& feature) {
  ArvGcNode* node = feature.empty() ? nullptr : arv_device_get_feature(session.Device(), feature.c_str());
  if (!node || !ARV_IS_GC_FEATURE_NODE(node)) return false;
  return arv_gc_feature_node_get_actual_access_mode(ARV_GC_FEATURE_NODE(node)) != ARV_GC_ACCESS_MODE_RO &&
         !Maybe([&](GError** e) { return arv_gc_feature_node_is_locked(ARV_GC_FEATURE_NODE(node), e); },
                FALSE);
}

void Set(const AravisSession& session, const std::string& who, const std::string& feature,
         const std::string& choice) {
  Must(who, fmt::format("{}={}", feature, choice),
       [&](GError** e) { arv_camera_set_string(session.Camera(), feature.c_str(), choice.c_str(), e); });
}

}  // namespace

void ClearAravisTriggers(const AravisSession& session, const FeatureNames& names) {
  ArvCamera* camera = session.Camera();
  if (names.trigger_mode.empty()) return;
  const auto off = [&] {
    Try([&](GError** e) { arv_camera_set_string(camera, names.trigger_mode.c_str(), "Off", e); });
  };
  if (!IsWritable(session, names.trigger_selector)) return off();
  for (const std::string& trigger : ChoicesOf(session, names.trigger_selector)) {
    Try([&](GError** e) {
      arv_camera_set_string(camera, names.trigger_selector.c_str(), trigger.c_str(), e);
    });
    off();
  }
}

void WriteAravisTrigger(const AravisSession& session, const std::string& who, const FeatureNames& names,
                        const AravisOptions& options) {
  if (!options.Triggered()) return;
  if (!names.CanTrigger()) throw UsageError("{}: the camera cannot be triggered; leave trigger out", who);
  const std::vector<std::string> sources = ChoicesOf(session, names.trigger_source);
  if (options.SoftwareTriggered() && names.software_source.empty())
    throw UsageError(
        "{}: the camera has no software trigger; give one of its lines ({}), or leave trigger out", who,
        fmt::join(sources, ", "));
  const std::string source = options.SoftwareTriggered() ? names.software_source : options.trigger;
  if (!Has(sources, source))
    throw UsageError("{}: trigger={}: the camera has {}", who, source,
                     sources.empty() ? "none" : fmt::format("{}", fmt::join(sources, ", ")));
  // A rate of its own would leave out triggers that come faster.
  for (const char* own_rate : {"AcquisitionFrameRateEnable", "AcquisitionFrameRateEnabled"})
    Try([&](GError** e) { arv_camera_set_boolean(session.Camera(), own_rate, FALSE, e); });
  ClearAravisTriggers(session, names);
  if (IsWritable(session, names.trigger_selector)) {
    if (names.frame_trigger.empty())
      throw UsageError("{}: none of the camera's triggers ({}) starts a frame; leave trigger out", who,
                       fmt::join(ChoicesOf(session, names.trigger_selector), ", "));
    Set(session, who, names.trigger_selector, names.frame_trigger);
  }
  if (!names.trigger_mode.empty()) Set(session, who, names.trigger_mode, "On");
  Set(session, who, names.trigger_source, source);
  const std::vector<std::string> edges = ChoicesOf(session, "TriggerActivation");
  for (const char* edge : {"RisingEdge", "RisingEdgeOrHighLevel"})
    if (Has(edges, edge)) return Set(session, who, "TriggerActivation", edge);
}

}  // namespace ulf::acquisition
