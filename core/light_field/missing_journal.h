// A folder without a journal: a light field that has lost it, a set by another program, or neither.
#pragma once

#include <filesystem>

#include "core/base/error.h"

namespace ulf {

// What follows from a journal is there, with its stamp, and the journal is not: `ulf repair` makes it anew.
bool HasLostItsJournal(const std::filesystem::path& dir);

// For who wants to write there: which of the three it is, and the way out of it.
Error NoJournal(const std::filesystem::path& dir);

}  // namespace ulf
