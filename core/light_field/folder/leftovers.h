// Temporary files that a killed writer left in a light field's folder. One list of places serves every
// writer.
#pragma once

#include <filesystem>

namespace ulf {

// What becomes the journal of a light field that is being repaired.
inline constexpr const char* kNewJournal = "journal.jsonl.new";

// Removes the temporary files of the folder. Whoever holds the journal's lock (`has_lock`) alone writes
// photographs, masters and masks: all temporary files of these are removed, and the journal of a repair that
// was killed. In depth/, cache/ and kept/, and everywhere without the lock, those go whose process no longer
// runs (IsLeftTemporary). Files with other names stay.
void RemoveLeftovers(const std::filesystem::path& light_field_folder, bool has_lock);

}  // namespace ulf
