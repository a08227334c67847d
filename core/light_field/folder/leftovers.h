// Temporary files that a killed writer left in a light field's folder. One list of places serves every writer.
#pragma once

#include <filesystem>

namespace ulf {

// What becomes the journal of a light field that is being repaired.
inline constexpr const char* kNewJournal = "journal.jsonl.new";

// Removes the temporary files of the folder. With the journal locked (`has_lock`) every one that only its holder writes, and
// the journal of a repair that was killed; elsewhere, in depth/ and cache/, and without the lock, those of processes that no longer run (IsLeftTemporary).
// Files with names of other programs stay.
void RemoveLeftovers(const std::filesystem::path& light_field_folder, bool has_lock);

}  // namespace ulf
