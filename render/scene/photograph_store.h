// A light field's photographs for rendering: read when a level of one is asked for, held while there is room.
//
// A level comes from memory; else from the photograph's pyramid file under the light field's cache/
// (render/scene/pyramid_file); else the photograph is decoded, all its levels are made, and the pyramid file
// is written for the next time. What was used longest ago leaves memory first. Pyramid files are kept only
// where the light field is one of ours (it has a journal) and photographs are not made smaller; deleting them
// is safe at any time. A folder or a disk that takes none is said once, and photographs are decoded each
// time.
//
// All may be called from several threads.
#pragma once

#include <cstddef>
#include <memory>

#include "core/light_field/light_field.h"
#include "render/scene/photograph.h"

namespace ulf::render {

struct PhotographStoreOptions {
  bool linear = false;            // Photograph::linear()
  int size_limit_px = 0;          // longer side; 0: as they are
  double memory_limit_mb = 2048;  // of levels held; what is being used is held by whoever uses it
};

class PhotographStore {
 public:
  PhotographStore(const LightField& light_field, const PhotographStoreOptions& options);
  ~PhotographStore();

  // Of view `index` of the light field; keeps what it needs of the store alive.
  std::shared_ptr<const Photograph> Of(std::size_t index) const;

  // What it has come to so far.
  struct Counts {
    std::size_t decoded = 0;        // photographs
    std::size_t levels_read = 0;    // from pyramid files
    std::size_t files_written = 0;  // pyramid files
    std::size_t files_refused = 0;  // that were there and did not fit
    std::size_t held_bytes = 0, most_held_bytes = 0;
  };
  Counts counts() const;

 private:
  struct State;
  class Stored;
  std::shared_ptr<State> state_;
};

// Where they are, under the light field's root.
inline constexpr char kPyramidFolder[] = "cache/pyramids";

}  // namespace ulf::render
