// A device's own settings by name: the GenICam tree of a machine-vision camera, the controls of a webcam, the
// configuration of a tethered camera. Behind `ulf features`.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/device.h"

namespace ulf {

enum class FeatureType { kInteger, kFloat, kBoolean, kEnumeration, kString, kCommand };
const char* Name(FeatureType type);

struct Feature {
  std::string name;
  std::string category;  // "AcquisitionControl"; nested ones with '/'
  FeatureType type = FeatureType::kString;
  std::string value;  // as text; empty for commands and what cannot be read
  bool readable = true, writable = false;
  std::optional<double> min, max, step;
  std::string unit;
  std::vector<std::string> choices;  // of an enumeration, those available now
  std::string description;
};

// An open device's features. Throws Error naming the device and the feature.
class FeatureAccess {
 public:
  virtual ~FeatureAccess() = default;
  virtual DeviceInfo Info() const = 0;
  // In the device's own order, categories together.
  virtual std::vector<Feature> List() = 0;
  // None: there is no such feature.
  virtual std::optional<Feature> Find(const std::string& name) = 0;
  // Writes and runs (a command takes the value "" or "execute"). Throws UsageError for what is unknown,
  // read-only or out of range, with the range or the choices.
  virtual void Set(const std::string& name, const std::string& value) = 0;
};

// By scheme, as OpenDevice. Throws UsageError for a device without features (replay, sim).
std::unique_ptr<FeatureAccess> OpenFeatures(const std::string& uri);

}  // namespace ulf
