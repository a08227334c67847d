// The size of a lens's pictures under any of the words that programs have for it: two keys, a list, or a text.
#pragma once

#include <string>
#include <vector>

#include "acquisition/calibration/lens_files/lens_numbers.h"
#include "acquisition/calibration/lens_files/lens_tree.h"

namespace ulf::acquisition {

// Looks in the maps in their order, and in each for the keys with the mark before those without. The principal point of
// `numbers` decides what the name of a list leaves open. Throws Error that begins with `where`, also where it does not.
void ReadLensSize(const std::vector<const LensNode*>& maps, const std::string& mark, LensNumbers& numbers,
                  const std::string& where);

}  // namespace ulf::acquisition
