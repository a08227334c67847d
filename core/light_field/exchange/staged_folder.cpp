#include "core/light_field/exchange/staged_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/file_descriptor.h"

namespace ulf {
namespace fs = std::filesystem;

namespace {

// No folder can be renamed to the root of a file system.
bool IsMountPoint(const fs::path& folder) {
  std::error_code unknown;
  if (!fs::exists(folder, unknown)) return false;
  const auto device_of = [](const fs::path& path) {
    struct stat status {};
    return stat(path.c_str(), &status) == 0 ? status.st_dev : dev_t{0};
  };
  return device_of(folder) != device_of(folder / "..");
}

// Removes the hidden folders of processes that no longer run.
void RemoveUnfinished(const fs::path& parent, const std::string& prefix) {
  std::error_code unknown;
  std::vector<fs::path> left;
  for (const auto& entry : fs::directory_iterator(parent, unknown)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with(prefix) || !name.ends_with(kTemporaryEnding)) continue;
    if (IsOfEndedProcess(name.substr(prefix.size(), name.size() - prefix.size() - kTemporaryEnding.size())))
      left.push_back(entry.path());
  }
  for (const fs::path& path : left) fs::remove_all(path, unknown);
}

}  // namespace

StagedFolder::StagedFolder(fs::path target) : target_(std::move(target)) {
  std::error_code unknown;
  if (target_.empty())
    throw Refusal("", "", "the name of the folder to write is empty", "give one with " + Parameter("output"));
  const fs::path whole =
      fs::weakly_canonical(target_, unknown);  // fails if a parent folder may not be entered
  target_ = unknown ? fs::absolute(target_) : whole;
  if (target_.filename().empty()) target_ = target_.parent_path();
  if (fs::exists(target_, unknown) && !(fs::is_directory(target_, unknown) && fs::is_empty(target_, unknown)))
    throw Error("{}: exists already and is not an empty folder; choose another name", target_.string());
  if (IsMountPoint(target_) || target_ == fs::current_path(unknown)) {
    path_ = target_;
    return;
  }
  const fs::path parent = FolderOf(target_);
  for (fs::path made = parent; !made.empty() && !fs::exists(made, unknown); made = made.parent_path())
    made_parents_.push_back(made);
  MakeFolder(parent);
  const std::string prefix = fmt::format(".{}.", target_.filename().string());
  RemoveUnfinished(parent, prefix);
  path_ = parent / fmt::format("{}{}{}", prefix, ProcessMark(), kTemporaryEnding);
  fs::remove_all(path_, unknown);
  MakeFolder(path_);
}

StagedFolder::~StagedFolder() {
  if (committed_) return;
  std::error_code unknown;
  if (path_ != target_) {
    fs::remove_all(path_, unknown);
    for (const fs::path& made : made_parents_) fs::remove(made, unknown);  // only empty ones are removed
    return;
  }
  for (fs::directory_iterator entry(path_, unknown), end; !unknown && entry != end;
       entry.increment(unknown)) {
    std::error_code kept;
    fs::remove_all(entry->path(), kept);
  }
}

void StagedFolder::Commit() {
  const FileDescriptor folder(open(path_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!folder.IsOpen() || syncfs(folder.Number()) != 0)
    ThrowDiskError(errno, path_.string() + ": syncing to disk failed");
  if (path_ != target_ && rename(path_.c_str(), target_.c_str()) != 0)
    ThrowDiskError(errno, fmt::format("{}: cannot be renamed to {}", path_.string(), target_.string()));
  committed_ = true;
  SyncFolder(FolderOf(target_));
}

}  // namespace ulf
