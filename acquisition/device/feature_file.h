// A camera's settings kept in a file and put back, on the same camera or its twin.
//
// The file is JSON: {"format": "ulf-features", "version": 1, "device": {...}, "features": [{"name", "value",
// "selectors": {NAME: VALUE}}, ...]}, in the camera's own order. It holds what can be written and what the
// camera's maker calls persistent (GenICam: Streamable; where a description marks nothing, everything
// writable), never commands. A feature that has one value for each value of a selector is kept once for each
// of them (enumerations, and integers of up to 16 values; of a longer table only the line that is selected).
//
// Putting back: a camera refuses a value that another setting forbids just now (an offset beside a width, an
// exposure beside a frame rate). So all that still differ are written in the file's order, again and again,
// until all are as in the file or a round changes nothing; then everything is read back.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "acquisition/device/features.h"

namespace ulf::acquisition {

struct SavedFeature {
  std::string name, value;
  std::vector<std::pair<std::string, std::string>>
      selectors;             // set, in this order, before it is read or written
  std::string Text() const;  // "TriggerMode[TriggerSelector=FrameStart]"
};

struct FeatureFile {
  DeviceInfo device;  // the one that it was taken from
  std::vector<SavedFeature> features;
};

// Moves selectors meanwhile and puts them back.
FeatureFile CollectFeatures(FeatureAccess& access);

void WriteFeatureFile(const std::filesystem::path& path, const FeatureFile& file);
// Throws Error naming what is wrong with the file and where.
FeatureFile ReadFeatureFile(const std::filesystem::path& path);

struct FeatureRefusal {
  SavedFeature wanted;
  std::string reads;   // empty: cannot be read
  std::string reason;  // the camera's own, where it gave one
};
struct FeatureLoadSummary {
  std::size_t taken = 0;    // as in the file in the end
  std::size_t changed = 0;  // of those, different before
  int rounds = 0;
  std::vector<FeatureRefusal> refused;
};
FeatureLoadSummary ApplyFeatures(const FeatureFile& file, FeatureAccess& access);

}  // namespace ulf::acquisition
