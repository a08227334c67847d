// A device's own settings by name: the GenICam tree of a machine-vision camera, the controls of a webcam, the
// configuration of a tethered camera. Behind `ulf features`.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/device/device.h"

namespace ulf::acquisition {

enum class FeatureType { kInteger, kFloat, kBoolean, kEnumeration, kString, kCommand };
const char* Name(FeatureType type);

// For whom a feature is meant, as its maker says.
enum class FeatureVisibility { kBeginner, kExpert, kGuru, kInvisible };
const char* Name(FeatureVisibility visibility);

struct CameraFeature {
  std::string name;
  std::string category;  // "AcquisitionControl"; nested ones with '/'
  FeatureType type = FeatureType::kString;
  std::string value;                       // as text; empty for commands and what cannot be read
  bool readable = true, writable = false;  // now: another feature may lock it
  bool read_only = false;                  // never writable, whatever else is set
  std::optional<double> min, max, step;
  std::string unit;
  std::vector<std::string> choices;  // of an enumeration, those available now
  std::string description;
  FeatureVisibility visibility = FeatureVisibility::kBeginner;
  bool streamable = true;            // belongs in a feature file
  std::vector<std::string> selects;  // features that have one value for each value of this one
};

// What a camera can send: a pixel format in one size, or up to it.
struct OfferedFormat {
  std::string name = {};         // "YUYV", "BayerRG8"; of one not read here the device's own name
  std::string code = {};         // the kernel's four letters; empty on other buses
  int width = 0, height = 0;     // the largest where `any_size`; 0: not told
  bool any_size = false;         // any part of the sensor, in steps of the camera's own
  std::vector<double> fps = {};  // frames a second, or the two ends where `any_fps`; empty: not told
  bool any_fps = false;
  bool supported = true;  // this program reads it
};

// An open device's features. Throws Error naming the device and the feature.
class FeatureAccess {
 public:
  virtual ~FeatureAccess() = default;
  virtual DeviceInfo Info() const = 0;
  // Empty where the device does not tell.
  virtual std::vector<OfferedFormat> Formats() { return {}; }
  // In the device's own order, categories together.
  virtual std::vector<CameraFeature> List() = 0;
  // None: there is no such feature.
  virtual std::optional<CameraFeature> Find(const std::string& name) = 0;
  // Writes and runs (a command takes the value "" or "execute"). Throws UsageError for what is unknown,
  // read-only or out of range, with the range or the choices.
  virtual void Set(const std::string& name, const std::string& value) = 0;
};

// "integer", "0 to 10 step 2", "Off, On", ...: what a feature takes, for people.
std::string RangeText(const CameraFeature& feature);
// The names most alike `wrong`, best first: for errors.
std::vector<std::string> NearestNames(const std::string& wrong, const std::vector<std::string>& names,
                                      std::size_t count = 3);

// What `feature` would read back after being set to `value`. Throws UsageError, beginning with `who`, for
// what does not parse or is out of range.
std::string CheckedValue(const std::string& who, const CameraFeature& feature, const std::string& value);
// Whether two values of a feature are the same but for how they are written.
bool SameValue(const CameraFeature& feature, const std::string& a, const std::string& b);

// By scheme, as OpenDevice. Throws UsageError for a device without features (replay, sim).
std::unique_ptr<FeatureAccess> OpenFeatures(const std::string& uri);

}  // namespace ulf::acquisition
