// Holds the folder of a light field open while it is written, so that its writer notices when another program
// moves or deletes the folder, and does not write under its old name, which may be another folder's by now.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/base/file_descriptor.h"

namespace ulf {

class OpenedFolder {
 public:
  // Throws Error if there is no such folder.
  explicit OpenedFolder(const std::filesystem::path& folder);

  // Returns none if the path still leads to this folder, otherwise says that it was moved, and to where, or
  // deleted. Any thread may call it.
  std::optional<std::string> WhyNotInPlace() const;
  // Throws this reason as Error.
  void RequireInPlace() const;

 private:
  const std::filesystem::path path_;
  FileDescriptor descriptor_;
  bool tells_numbers_ = false;  // false on file systems that give one folder several inode numbers
};

// Makes the folder `inside` ("sparse/0") of a light field, but never `light_field` itself. Throws Error
// naming what stands in the way, or DiskFullError.
void MakeFolderIn(const std::filesystem::path& light_field, const std::filesystem::path& inside);

}  // namespace ulf
