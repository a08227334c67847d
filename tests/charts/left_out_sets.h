// Light fields of which charts leave out views: scans of the simulator, and sets of the test data.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/light_field/light_field.h"
#include "render/scene/scene.h"
#include "tests/support/floors.h"

namespace ulf::test {

struct LeftOutSet {
  std::string name = {};
  LightField light_field = {};
  SceneOptions options = {};
};

struct ScanOptions {
  std::string uri = {};  // of the simulator
  int views = 200, frames_between = 6;
};
// A scan with the sensor's noise and exact poses, in the new folder `dir`.
LightField SimulatedScan(const ScanOptions& options, const std::filesystem::path& dir);

// Returns a set of the test data (photographs of shop_grid_even at two thirds of their size): fox_half,
// llff_fern, shop_grid_even, temple_ring, or one of strecha's. None: it is not there. Writes into `work`.
std::optional<LeftOutSet> FoundSet(const std::string& name, const std::filesystem::path& work);

// Returns the indices of every `every`th view from `first` on.
std::vector<int> EveryView(const LightField& light_field, int every, int first = 0);

}  // namespace ulf::test
