#include "acquisition/unfinished_folder.h"

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "acquisition/atomic_file.h"
#include "acquisition/error.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

// Of processes that are gone.
void RemoveUnfinished(const fs::path& parent, const std::string& prefix) {
  std::error_code unknown;
  std::vector<fs::path> left;
  for (const auto& entry : fs::directory_iterator(parent, unknown)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with(prefix) || !name.ends_with(kTemporaryEnding)) continue;
    const std::string number =
        name.substr(prefix.size(), name.size() - prefix.size() - kTemporaryEnding.size());
    const bool is_number = !number.empty() && number.find_first_not_of("0123456789") == std::string::npos;
    const pid_t pid = is_number ? static_cast<pid_t>(std::atol(number.c_str())) : 0;
    if (pid > 0 && kill(pid, 0) != 0 && errno == ESRCH) left.push_back(entry.path());
  }
  for (const fs::path& path : left) fs::remove_all(path, unknown);
}

}  // namespace

UnfinishedFolder::UnfinishedFolder(const fs::path& path) : path_(path.lexically_normal()) {
  if (!path_.has_filename()) path_ = path_.parent_path();
  std::error_code unknown;
  if (fs::exists(fs::symlink_status(path_, unknown)) &&
      !(fs::is_directory(path_, unknown) && fs::is_empty(path_, unknown)))
    throw Error("{}: exists already and is not an empty folder; choose another name", path_.string());
  const fs::path parent = path_.parent_path().empty() ? fs::path(".") : path_.parent_path();
  const std::string prefix = fmt::format(".{}.", path_.filename().string());
  MakeFolder(parent);
  RemoveUnfinished(parent, prefix);
  unfinished_ = parent / fmt::format("{}{}{}", prefix, getpid(), kTemporaryEnding);
  MakeFolder(unfinished_);
}

UnfinishedFolder::~UnfinishedFolder() {
  std::error_code ignored;
  if (!finished_) fs::remove_all(unfinished_, ignored);
}

void UnfinishedFolder::Finish() {
  // An empty folder is replaced, one that was filled meanwhile is not.
  if (std::rename(unfinished_.c_str(), path_.c_str()) != 0)
    ThrowDiskError(errno, fmt::format("{}: cannot be given its name", path_.string()));
  finished_ = true;
  SyncFolder(path_.parent_path().empty() ? fs::path(".") : path_.parent_path());
}

}  // namespace ulf
