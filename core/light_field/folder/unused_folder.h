// Says where a new light field may begin: also in the folder of a capture that ended before its first view.
#pragma once

#include <filesystem>

namespace ulf {

// Returns whether the folder holds a light field without any view or photograph, and never held one: only
// derived files.
bool IsUnused(const std::filesystem::path& dir);

// Throws Error if `dir` is a file, holds a light field that was used, or anything else.
void RequireForNewLightField(const std::filesystem::path& dir);

// Removes such a light field, and the folder with it, unless anything else lies there. Does nothing to any
// other folder.
void RemoveUnused(const std::filesystem::path& dir);

}  // namespace ulf
