// Distinguishes folders without a journal: a light field that has lost it, a data set of another program, or
// neither.
#pragma once

#include <filesystem>

#include "core/base/error.h"

namespace ulf {

// Whether derived files with a journal's stamp exist but the journal does not; `ulf repair` restores it.
bool IsJournalMissing(const std::filesystem::path& dir);

// An Error for a writer that tells which of the three it is, and the remedy.
Error MissingJournalError(const std::filesystem::path& dir);

}  // namespace ulf
