// Folders in memory for what a fuzzer makes: readers of ours take paths.
#pragma once

#include <filesystem>
#include <span>
#include <string_view>

namespace ulf::test {

// Replaces the files of one folder of this process's, which is removed at the end. Several files share the bytes: each
// ends where a line "=====" stands, and the last ones may be missing. Names may have folders.
std::filesystem::path FuzzFolder(std::string_view bytes, std::span<const char* const> names);
// One file with all the bytes.
std::filesystem::path FuzzFile(std::string_view bytes, const char* name);

// A folder of small photographs, 0001.png to 0004.png of 64 x 48 pixels, which stays.
std::filesystem::path FuzzPhotographs();

// The same photographs in a new folder, which must not lead out of another one (hard links).
void PutFuzzPhotographs(const std::filesystem::path& folder);

// Ends the process with the words and the place: something that a reader must never return or throw.
[[noreturn]] void Broken(const char* what);

}  // namespace ulf::test
