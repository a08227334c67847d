// Reads a light field's photographs for rendering. The store reads a level when it is requested and keeps it
// in memory while there is room; the least recently used level is evicted first.
//
// A level comes from memory; or from the photograph's pyramid file under the light field's cache/
// (render/photographs/pyramid_file); or the store decodes the photograph, makes all its levels, and writes
// the pyramid file. Pyramid files are written only if the light field has a journal, and the photographs keep
// their size and are not masks. Deleting them is safe at any time. If they cannot be written, or less than 1
// GB is free, the store warns once and decodes each time.
//
// Several threads may call all functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/light_field/light_field.h"
#include "render/photographs/photograph.h"

namespace ulf::render {

struct PhotographStoreOptions {
  bool linear = false;            // Photograph::linear()
  bool masks = false;             // use the views' masks as photographs, white inside; not with `linear`
  int size_limit_px = 0;          // limit of the longer side of photographs; 0: none
  double memory_limit_mb = 2048;  // for cached levels; levels that callers still use come on top
  // By view index: whether the view's clipped pixels get hardly any weight (kShareOfClipped), because views
  // of a shorter exposure show more there. Works only with `linear`. Empty: no view.
  std::vector<bool> masks_clipped = {};
};

class PhotographStore {
 public:
  PhotographStore(const LightField& light_field, const PhotographStoreOptions& options);
  ~PhotographStore();

  // Returns the photograph of view `index` of the light field. It may outlive the store.
  std::shared_ptr<const Photograph> PhotographOf(std::size_t index) const;

  // Counts events since the store was made.
  struct Counts {
    std::size_t decoded = 0;        // photographs
    std::size_t levels_read = 0;    // from pyramid files
    std::size_t files_written = 0;  // pyramid files
    std::size_t files_refused = 0;  // pyramid files that existed and were outdated or damaged
    std::size_t held_bytes = 0, most_held_bytes = 0;
    // Pixels of the photographs that were read, in their size on disk: all; clipped ones; of these, those
    // with kShareOfClipped.
    std::uint64_t pixels = 0, clipped_px = 0, masked_px = 0;
    std::size_t photographs = 0;
  };
  Counts counts() const;

 private:
  struct State;
  class Stored;
  std::shared_ptr<State> state_;
};

// The folder of the pyramid files under the light field's root.
inline constexpr char kPyramidFolder[] = "cache/pyramids";

}  // namespace ulf::render
