// Opens text files of other programs, which may come from Windows or be written by hand.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include "core/base/atomic_file.h"
#include "core/base/binary_file.h"

namespace ulf {

// Opens a regular file behind its byte order mark, if it has one. Throws Error as OpenRegularFile() does.
inline std::ifstream OpenTextFile(const std::filesystem::path& path) {
  std::ifstream file = OpenRegularFile(path);
  SkipByteOrderMark(file);
  return file;
}

// Returns whether nothing but white space is in the line, or a comment behind it.
inline bool IsEmptyOrComment(const std::string& line) {
  const std::size_t first = line.find_first_not_of(" \t\r");
  return first == std::string::npos || line[first] == '#';
}

}  // namespace ulf
