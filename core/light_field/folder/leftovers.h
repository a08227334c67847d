// Removes temporary files that a killed writer left in a light field's folder.
#pragma once

#include <filesystem>

namespace ulf {

// The journal of a light field under repair, before it is renamed.
inline constexpr const char* kNewJournal = "journal.jsonl.new";

// Removes the temporary files of the folder. Only the holder of the journal's lock (`has_lock`: the caller)
// writes photographs, masters and masks: it removes all temporary files of these, and the journal of a killed
// repair. Elsewhere, and everywhere without the lock, only files of ended processes are removed
// (IsLeftTemporary). Files with other names stay.
void RemoveLeftovers(const std::filesystem::path& light_field_folder, bool has_lock);

}  // namespace ulf
