// Finds the names and units under which a camera has the features that a light field needs: exposure, gain,
// pixel format, trigger, white balance, limit of throughput. The Standard Features Naming Convention (GenICam
// SFNC) has one name for each; older cameras, and some others, have different ones. The driver sets the
// features found here (aravis_configuration.h).
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/device/features.h"

namespace ulf::acquisition {

// Queries on a camera's GenICam description, by the name of a feature.
struct NamedFeatures {
  std::function<std::optional<FeatureType>(const std::string& name)> kind_of;  // none: no such feature
  std::function<bool(const std::string& name)>
      is_available;  // at this moment: another setting may change that
  std::function<std::vector<std::string>(const std::string& name)>
      choices_of;                                                          // the choices of an enumeration
  std::function<std::string(const std::string& name)> unit_of;             // empty: it does not tell
  std::function<std::optional<double>(const std::string& name)> least_of;  // none: it does not tell
};

// The names of a camera's features; empty: the camera does not have it.
struct FeatureNames {
  std::string exposure = {};
  double exposure_us = 1;  // microseconds in one of its unit
  // Gain in decibels, or as a factor: a gain without a unit that cannot be 0.
  std::string gain = {};
  bool gain_is_factor = false;
  std::string gain_raw = {};  // a number in units of the camera's own
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
  // Bytes a second in one of the limit's unit; 0: the unit is not known.
  double throughput_bytes = 1;
  std::string throughput_mode = {};  // the switch that enables the limit

  bool CanTrigger() const { return !trigger_source.empty(); }
};
FeatureNames FindFeatureNames(const NamedFeatures& camera);

// Returns the microseconds in a unit of time as descriptions write it; 1 for an empty unit. Returns none for
// a text that is no unit of time.
std::optional<double> MicrosecondsIn(const std::string& unit);
bool IsDecibel(const std::string& unit);

}  // namespace ulf::acquisition
