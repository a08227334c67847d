// A new folder that is whole or not there: it is filled under a hidden name and renamed when it is done. What
// a killed process leaves of it is removed by the next of that name.
#pragma once

#include <filesystem>
#include <vector>

namespace ulf {

class StagedFolder {
 public:
  // For `target`, which must not exist or be empty (Error otherwise). Throws Error where nothing can be
  // written.
  explicit StagedFolder(std::filesystem::path target);
  StagedFolder(const StagedFolder&) = delete;
  StagedFolder& operator=(const StagedFolder&) = delete;
  ~StagedFolder();  // removes what was not committed, with the folders above that were made for it

  // Where to write until Commit(): beside the target (hidden, `.NAME.part`), or in it where it is the root of
  // a file system of its own.
  const std::filesystem::path& path() const { return path_; }
  // Syncs the file system and gives the folder its name. Throws DiskFullError, Error.
  void Commit();

 private:
  std::filesystem::path target_, path_;
  std::vector<std::filesystem::path> made_parents_;  // the innermost first
  bool committed_ = false;
};

}  // namespace ulf
