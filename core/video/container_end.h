// Whether a video's file is there to its end, by the sizes that its own outermost parts name (ISO base media,
// Matroska, AVI).
#pragma once

#include <filesystem>
#include <string>

namespace ulf {

// What is missing, as a clause ("its end is missing: 1.2 of 3.4 MB are there"); empty: nothing, or the
// container does not tell.
std::string MissingEnd(const std::filesystem::path& file);

}  // namespace ulf
