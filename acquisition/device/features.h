// Defines access to a device's own settings by name, for `ulf features`: the GenICam tree of a machine-vision
// camera, the controls of a webcam, the configuration of a tethered camera.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/device/device.h"

namespace ulf::acquisition {

enum class FeatureType { kInteger, kFloat, kBoolean, kEnumeration, kString, kCommand };
const char* Name(FeatureType type);

// The users that a feature is meant for (GenICam: Visibility).
enum class FeatureVisibility { kBeginner, kExpert, kGuru, kInvisible };
const char* Name(FeatureVisibility visibility);

struct CameraFeature {
  std::string name;
  std::string category;  // "AcquisitionControl"; nested ones with '/'
  FeatureType type = FeatureType::kString;
  std::string value;                       // as text; empty for commands and unreadable features
  bool readable = true, writable = false;  // at this moment; another feature may change that
  bool read_only = false;                  // never writable
  std::optional<double> min, max, step;
  std::string unit;
  std::vector<std::string> choices;  // of an enumeration: those available at this moment
  std::string description;
  FeatureVisibility visibility = FeatureVisibility::kBeginner;
  bool streamable = true;            // a persistent setting, which a feature file holds (feature_file.h)
  std::vector<std::string> selects;  // features that have one value for each value of this one
};

// An image format that a camera offers: a pixel format in one size, or in any size up to it.
struct OfferedFormat {
  std::string name = {};         // "YUYV", "BayerRG8"; the device's own name if ulf cannot read it
  std::string code = {};         // V4L2 four-character code; empty for other cameras
  int width = 0, height = 0;     // pixels, the largest if `any_size`; 0: unknown
  bool any_size = false;         // any part of the sensor can be sent, in the camera's steps
  std::vector<double> fps = {};  // frames per second, or both limits if `any_fps`; empty: unknown
  bool any_fps = false;
  bool supported = true;  // ulf reads it
};

// The features of an open device. All functions throw Error that names the device and the feature.
class FeatureAccess {
 public:
  virtual ~FeatureAccess() = default;
  virtual DeviceInfo Info() const = 0;
  // Returns the image formats of the camera; empty if they are unknown.
  virtual std::vector<OfferedFormat> Formats() { return {}; }
  // Lists the features in the device's own order, grouped by category.
  virtual std::vector<CameraFeature> List() = 0;
  // Returns none when there is no such feature.
  virtual std::optional<CameraFeature> Find(const std::string& name) = 0;
  // Writes a value, or runs a command (value "" or "execute"). Throws Refusal for an unknown or read-only
  // feature and for a value out of range, naming the range or the choices.
  virtual void Set(const std::string& name, const std::string& value) = 0;
};

// Returns the values that a feature accepts, for people: "a whole number", "0 to 10 step 2", "Off, On".
std::string RangeText(const CameraFeature& feature);
// Returns the `count` names most similar to `wrong`, best first; for error messages.
std::vector<std::string> NearestNames(const std::string& wrong, const std::vector<std::string>& names,
                                      std::size_t count = 3);

// Returns the text that `feature` reads back after it was set to `value`. Throws Refusal, beginning with
// `who`, for a value that does not parse or is out of range.
std::string CheckedValue(const std::string& who, const CameraFeature& feature, const std::string& value);
// Returns whether two texts are the same value of a feature ("1" and "1.0").
bool SameValue(const CameraFeature& feature, const std::string& a, const std::string& b);

}  // namespace ulf::acquisition
