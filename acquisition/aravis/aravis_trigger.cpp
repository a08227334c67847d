#include "acquisition/aravis/aravis_trigger.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "acquisition/aravis/aravis_automatics.h"
#include "acquisition/aravis/aravis_calls.h"
#include "acquisition/aravis/aravis_setting.h"

namespace ulf::acquisition {
namespace {

bool Has(const std::vector<std::string>& choices, const std::string& choice) {
  return std::find(choices.begin(), choices.end(), choice) != choices.end();
}

// A source that is described as read-only is written all the same, and read back: the description of some
// cameras with a software trigger says so (Point Grey's Grasshopper3), and they take the write. Of no other
// feature is that done: a camera that has the command has a use for the source, whereas a width or a rate
// that is read-only is one that cannot change.
std::string WriteSource(const AravisSession& session, const std::string& feature, const std::string& source,
                        std::vector<std::string>& notes) {
  const std::string why = WriteSetting(session, feature, source);
  if (why.empty() || !IsReadOnly(session, feature)) return why;
  ArvCamera* camera = session.Camera();
  arv_camera_set_access_check_policy(camera, ARV_ACCESS_CHECK_POLICY_DISABLE);
  FailureOf(arv_camera_set_string, camera, feature.c_str(), source.c_str());
  arv_camera_set_access_check_policy(camera, ARV_ACCESS_CHECK_POLICY_ENABLE);
  if (ReadSetting(session, feature) != source) return why + ", and a write all the same was not taken";
  notes.push_back(fmt::format("took {}={} although its description calls that read-only", feature, source));
  return "";
}

}  // namespace

void ClearAravisTriggers(const AravisSession& session, const FeatureNames& names) {
  if (names.trigger_mode.empty()) return;
  if (!WhyFixed(session, names.trigger_selector).empty()) {
    WriteSetting(session, names.trigger_mode, "Off");
    return;
  }
  for (const std::string& trigger : session.Choices(names.trigger_selector)) {
    WriteSetting(session, names.trigger_selector, trigger);
    WriteSetting(session, names.trigger_mode, "Off");
  }
}

std::vector<std::string> WriteAravisTrigger(const AravisSession& session, const std::string& who,
                                            const FeatureNames& names, const AravisOptions& options) {
  std::vector<std::string> notes;
  if (!options.Triggered()) return notes;
  if (!names.CanTrigger()) throw Refused(who, "the camera cannot be triggered", "leave trigger out");
  const std::vector<std::string> sources = session.Choices(names.trigger_source);
  if (options.SoftwareTriggered() && names.software_source.empty())
    throw Refused(who, "the camera has no software trigger",
                  fmt::format("give one of its lines ({}), or leave trigger out", fmt::join(sources, ", ")));
  const std::string source = options.SoftwareTriggered() ? names.software_source : options.trigger;
  if (!Has(sources, source)) throw NoSuchChoice(who, "trigger=" + source, sources);
  const std::string asked = "trigger=" + options.trigger;
  // A rate of its own would leave out triggers that come faster.
  for (const char* own_rate : {"AcquisitionFrameRateEnable", "AcquisitionFrameRateEnabled"})
    SwitchAutomatic(session, own_rate, AutomaticMode::kOff);
  ClearAravisTriggers(session, names);
  if (WhyFixed(session, names.trigger_selector).empty()) {
    if (names.frame_trigger.empty())
      throw Refused(who,
                    fmt::format("none of the camera's triggers ({}) starts a frame",
                                fmt::join(session.Choices(names.trigger_selector), ", ")),
                    "leave trigger out");
    RequireSetting(session, who, asked, names.trigger_selector, names.frame_trigger);
  }
  if (!names.trigger_mode.empty()) RequireSetting(session, who, asked, names.trigger_mode, "On");
  // Some cameras have a source while the mode is on, others take one only while it is off.
  std::string why = WriteSetting(session, names.trigger_source, source);
  if (!why.empty()) {
    const bool is_off =
        !names.trigger_mode.empty() && WriteSetting(session, names.trigger_mode, "Off").empty();
    why = WriteSource(session, names.trigger_source, source, notes);
    if (is_off) RequireSetting(session, who, asked, names.trigger_mode, "On");
  }
  if (!why.empty()) throw Refused(who, fmt::format("{}: {}", asked, why), "leave trigger out");
  const std::vector<std::string> edges = session.Choices("TriggerActivation");
  for (const char* edge : {"RisingEdge", "RisingEdgeOrHighLevel"})
    if (Has(edges, edge)) {
      // Nobody asked for an edge by name.
      if (std::string kept = WriteSetting(session, "TriggerActivation", edge); !kept.empty())
        notes.push_back("triggers as it does: " + kept);
      break;
    }
  return notes;
}

}  // namespace ulf::acquisition
