// By which names a camera calls what a light field needs of it: exposure, gain, pixel format, trigger, white balance. The
// Standard Features Naming Convention has one name for each; cameras before it, and some beside it, have others. What is
// found here is what the driver sets (aravis_configuration.h).
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace ulf::acquisition {

enum class NodeKind { kNone, kInteger, kReal, kChoice, kBoolean, kCommand, kText };

// A camera's description as far as names go. `kind_of`: kNone for a feature that it does not have; `choices_of`: of an
// enumeration.
struct NamedFeatures {
  std::function<NodeKind(const std::string& name)> kind_of;
  std::function<std::vector<std::string>(const std::string& name)> choices_of;
};

// Empty: the camera does not have it.
struct FeatureNames {
  std::string exposure = {};  // microseconds
  std::string gain_db = {};   // decibels
  std::string gain_raw = {};  // a whole number, in units of the camera's own
  std::string pixel_format = {};
  std::string trigger_mode = {}, trigger_source = {}, trigger_software = {};
  std::string software_source = {};  // the choice of trigger_source that means trigger_software
  std::string white_balance_auto = {};
  std::string balance_selector = {}, balance_ratio = {};  // the colour, and its ratio to green
  std::string exposure_auto = {}, gain_auto = {};

  bool CanTrigger() const { return !trigger_source.empty(); }
  bool CanBalance() const { return !white_balance_auto.empty() || !balance_ratio.empty(); }
};
FeatureNames FindFeatureNames(const NamedFeatures& camera);

}  // namespace ulf::acquisition
