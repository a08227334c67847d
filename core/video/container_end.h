// Checks that a video's file is complete, by the sizes that its outermost boxes, segment or chunk state (ISO
// base media such as MP4, Matroska, AVI).
#pragma once

#include <filesystem>
#include <string>

namespace ulf {

// Returns what is missing, as a clause ("its end is missing: 1.2 of 3.4 MB are there"); empty if nothing is,
// or the container does not tell.
std::string MissingEnd(const std::filesystem::path& file);

}  // namespace ulf
