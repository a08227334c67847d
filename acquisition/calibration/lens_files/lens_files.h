// Reads a lens from the files of other programs, whatever their syntax. ReadableLensPrograms() lists the
// programs; docs/calibration.md has them as a table.
//
// A word for the model in the file decides what the coefficients are; where there is none and several models
// are possible, a warning says which was assumed and which word decides. A model that ulf does not have is an
// Error that names it and the way out, and so are counts that contradict each other.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "acquisition/calibration/lens_files/lens_numbers.h"
#include "acquisition/calibration/lens_files/lens_tree.h"

namespace ulf::acquisition {

struct ReadLens {
  Lens lens = {};
  std::string program = {};  // "Kalibr"
};

// `camera` selects one of several by its name or number ("cam1", "2"); empty: the file must contain only one.
// Returns none for a text in none of the formats' syntaxes. Throws Error that begins with `where` for any
// other text without a lens that ulf reads.
std::optional<ReadLens> ReadLensText(const std::string& text, const std::string& where,
                                     const std::string& camera = "");

// Returns "Lenses of ulf, Kalibr, ... are read (docs/calibration.md)", for messages.
std::string ReadableLensFiles();
// Returns the names of the programs alone.
std::vector<std::string> ReadableLensPrograms();

}  // namespace ulf::acquisition
