// Knows sets of other programs that are not read, and what makes of each a set that is.
#pragma once

#include <filesystem>
#include <string>

namespace ulf {

// Returns whose set `source`, a file or a folder with such a file, is and what converts it ("sfm.abc: Alembic
// of Meshroom, which is not read; ..."); "" if it is none of them. Files are known by their names, and of
// folders only the files in themselves are looked at.
std::string UnreadSet(const std::filesystem::path& source);

}  // namespace ulf
