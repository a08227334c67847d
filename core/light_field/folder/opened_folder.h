// The folder of a light field that is being written. It is held open, so that its writer notices when another
// program moves or deletes it: nothing is then written under its old name, which may be another folder's by
// now.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace ulf {

class OpenedFolder {
 public:
  // Throws Error where there is no such folder.
  explicit OpenedFolder(const std::filesystem::path& folder);
  ~OpenedFolder();
  OpenedFolder(const OpenedFolder&) = delete;
  OpenedFolder& operator=(const OpenedFolder&) = delete;

  // None: the path still leads to this folder. Else says that it was moved, and to where, or that it is gone.
  // Safe to call from any thread.
  std::optional<std::string> WhyGone() const;
  // Throws these words as Error.
  void RequireInPlace() const;

 private:
  bool IsAt(const std::filesystem::path& path) const;
  const std::filesystem::path path_;
  int descriptor_ = -1;
  bool tells_numbers_ = false;  // file systems are conceivable that tell two numbers of one folder
};

// Makes the folder `inside` ("sparse/0") of a light field, but never `light_field` itself. Throws Error
// naming what stands in the way.
void MakeFolderIn(const std::filesystem::path& light_field, const std::filesystem::path& inside);

}  // namespace ulf
