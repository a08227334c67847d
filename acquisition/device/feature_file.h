// Saves a camera's settings in a file and restores them, on the same camera or another of its model.
//
// The file is JSON: {"format": "ulf-features", "version": 1, "device": {...}, "features": [{"name", "value",
// "selectors": {NAME: VALUE}}, ...]}, in the camera's own order. It contains the writable features that the
// camera's maker marks as persistent (GenICam SFNC: Streamable; if the description marks none, all writable
// ones), never commands. A feature with one value per value of a selector is saved for each of them
// (enumerations, and integers of up to 16 values; of a longer table only the selected entry).
//
// A camera refuses a value that another setting forbids at that moment (an offset because of a width, an
// exposure because of a frame rate). ApplyFeatures() therefore writes all features that still differ in the
// file's order, and repeats this until all match or a round changes nothing; then it reads everything back.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "acquisition/device/features.h"

namespace ulf::acquisition {

struct SavedFeature {
  std::string name, value;
  std::vector<std::pair<std::string, std::string>>
      selectors;             // to be set in this order before the feature is read or written
  std::string Text() const;  // "TriggerMode[TriggerSelector=FrameStart]"
};

struct FeatureFile {
  DeviceInfo device;  // whose settings these are
  std::vector<SavedFeature> features;
};

// Reads all persistent features. Changes selectors meanwhile and restores them.
FeatureFile CollectFeatures(FeatureAccess& access);

void WriteFeatureFile(const std::filesystem::path& path, const FeatureFile& file);
// Throws Error naming what is wrong with the file and where.
FeatureFile ReadFeatureFile(const std::filesystem::path& path);

struct FeatureRefusal {
  SavedFeature wanted;
  std::string reads;   // the camera's value; empty: it cannot be read
  std::string reason;  // why the camera did not take the value; empty: unknown
};
struct FeatureLoadSummary {
  std::size_t taken = 0;    // features that have the file's value at the end
  std::size_t changed = 0;  // of those, features that differed before
  int rounds = 0;
  std::vector<FeatureRefusal> refused;
};
// Restores the settings of `file`, as above; a value that the camera refuses is no error.
FeatureLoadSummary ApplyFeatures(const FeatureFile& file, FeatureAccess& access);

}  // namespace ulf::acquisition
