// A file whose checksum an index beside it keeps.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace ulf::render {

// As an index keeps it.
std::string ChecksumForIndex(std::string_view bytes);
// Throws Error where the file is missing, or its bytes have another checksum.
std::string ReadIndexedFile(const std::filesystem::path& path, const std::string& checksum);

}  // namespace ulf::render
