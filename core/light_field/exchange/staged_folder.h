// Creates a folder atomically: it is filled under a hidden name and renamed at the end. The next process with
// the same target removes the remains of a killed one.
#pragma once

#include <filesystem>
#include <vector>

namespace ulf {

class StagedFolder {
 public:
  // Makes the hidden folder. Throws Error if `target` exists and is not an empty folder, or if nothing can be
  // written beside it; Refusal if its name is empty.
  explicit StagedFolder(std::filesystem::path target);
  StagedFolder(const StagedFolder&) = delete;
  StagedFolder& operator=(const StagedFolder&) = delete;
  ~StagedFolder();  // without Commit(): removes the folder and the parents that were made for it

  // Returns the folder to write to until Commit(): beside the target (hidden, `.NAME.MARK.part`), or the
  // target itself if it is the root of a file system or the current folder.
  const std::filesystem::path& path() const { return path_; }
  // Syncs the file system and gives the folder its name. Throws DiskFullError, Error.
  void Commit();
  // Leaves the hidden folder as it is, for people to look into; the next process with the same target removes
  // it.
  void Keep() { committed_ = true; }

 private:
  std::filesystem::path target_, path_;
  std::vector<std::filesystem::path> made_parents_;  // innermost first
  bool committed_ = false;
};

}  // namespace ulf
