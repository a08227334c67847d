// Reads a lens out of the files of other programs, whatever their syntax. ReadableLensPrograms() is the one
// list of whose are read; docs/calibration.md has it as a table.
//
// A model's word in the file decides what the coefficients are; where none is and both are possible, a
// warning says what was taken and which word decides. A model that ulf does not have is an Error that names
// it and the way out, and so are counts that contradict each other.
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
// None: the text is of no program that is known. Errors begin with `where`.
std::optional<ReadLens> ReadLensText(const std::string& text, const std::string& where,
                                     const std::string& camera = "");

// "Lenses of ulf, Kalibr, ... are read (docs/calibration.md)", for messages.
std::string ReadableLensFiles();
// The programs alone.
std::vector<std::string> ReadableLensPrograms();

}  // namespace ulf::acquisition
