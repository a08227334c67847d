// Finds the photographs that two light fields have in common, to compare the light fields on them.
#pragma once

#include <cstddef>
#include <vector>

#include "core/light_field/light_field.h"

namespace ulf::render {

// A photograph's views in both light fields, by index.
struct SharedPhotograph {
  int in_first = 0, in_second = 0;
};

struct SharedPhotographs {
  std::vector<SharedPhotograph> found;  // in the order of the first light field's views; no view twice
  // Number of views that have a counterpart of their name, but not of their picture: names alone say nothing,
  // because every capture has a photograph 000001.
  std::size_t other_pictures = 0;
};

// Two photographs are the same if their files are, byte by byte, whatever their names; or if they have the
// same name (below images/, without the ending) and size, and pictures that differ by no more than encoding
// does. An undistorted or resized copy is another photograph. Reads files whose lengths or names agree, and
// throws Error for one that cannot be read.
SharedPhotographs PhotographsInBoth(const LightField& first, const LightField& second);

}  // namespace ulf::render
