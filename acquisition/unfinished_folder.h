// A folder that is there whole or not at all: filled under a hidden name beside its place and renamed at the
// end. A killed process leaves the hidden one (.NAME.PID.part), which the next of that name removes.
#pragma once

#include <filesystem>

namespace ulf {

class UnfinishedFolder {
 public:
  // Throws Error where something stands at `path` already that is no empty folder, or beside it nothing can
  // be written.
  explicit UnfinishedFolder(const std::filesystem::path& path);
  ~UnfinishedFolder();  // removes what is not finished
  UnfinishedFolder(const UnfinishedFolder&) = delete;
  UnfinishedFolder& operator=(const UnfinishedFolder&) = delete;

  const std::filesystem::path& path() const { return unfinished_; }  // to write into
  void Finish();

 private:
  std::filesystem::path path_, unfinished_;
  bool finished_ = false;
};

}  // namespace ulf
