// Finds the names and units under which a camera has the features that a light field needs: exposure, gain,
// pixel format, trigger, white balance, limit of throughput. The Standard Features Naming Convention (GenICam
// SFNC) has one name for each; older cameras, and some others, use other names.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/device/features.h"

namespace ulf::acquisition {

// Answers questions about a feature by its name, from a camera or its description (aravis_description.h).
struct NamedFeatures {
  std::function<std::optional<FeatureType>(const std::string& name)> kind_of;  // none: no such feature
  std::function<bool(const std::string& name)>
      is_available;  // at this moment: another setting may change that
  std::function<std::vector<std::string>(const std::string& name)>
      choices_of;                                                          // the choices of an enumeration
  std::function<std::string(const std::string& name)> unit_of;             // empty: it does not tell
  std::function<std::optional<double>(const std::string& name)> least_of;  // none: it does not tell
};

// The names of a camera's features; empty: the camera does not have the feature.
struct FeatureNames {
  std::string exposure = {};
  double exposure_us = 1;  // how many microseconds are one unit of `exposure`
  // Gain in decibels, or as a factor: a gain without a unit that cannot be 0.
  std::string gain = {};
  bool gain_is_factor = false;
  std::string gain_raw = {};  // gain in the camera's own unit
  // The selector among several gains, and its choice that means all pixels.
  std::string gain_selector = {}, gain_of_all = {};
  std::string pixel_format = {};
  std::string trigger_mode = {}, trigger_source = {}, trigger_software = {};
  std::string software_source = {};  // the choice of trigger_source that means trigger_software
  // The selector among several triggers, and its choice that starts a frame.
  std::string trigger_selector = {}, frame_trigger = {};
  std::string white_balance_auto = {};
  std::string balance_selector = {}, balance_ratio = {};  // selects the colour of the ratio to green
  bool balance_is_gain = false;  // balance_ratio is each colour's own gain, green's among them
  std::string throughput_limit = {};
  // How many bytes a second are one unit of `throughput_limit`; 0: its unit is unknown.
  double throughput_bytes = 1;
  std::string throughput_mode = {};  // the switch that enables the limit

  bool CanTrigger() const { return !trigger_source.empty(); }
};
FeatureNames FindFeatureNames(const NamedFeatures& camera);

// Returns how many microseconds are one unit of time, as descriptions write units ("us", "ms"); 1 for an
// empty text, none for a text that is no unit of time.
std::optional<double> MicrosecondsIn(const std::string& unit);
bool IsDecibel(const std::string& unit);

}  // namespace ulf::acquisition
