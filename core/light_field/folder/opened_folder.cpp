#include "core/light_field/folder/opened_folder.h"

#include <fcntl.h>
#include <fmt/format.h>

#include <cerrno>
#include <cstring>

#include "core/base/atomic_file.h"
#include "core/base/error.h"

namespace ulf {
namespace fs = std::filesystem;

OpenedFolder::OpenedFolder(const fs::path& folder)
    : path_(folder), descriptor_(open(folder.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC)) {
  if (!descriptor_.IsOpen())
    throw Error("{}: cannot open the folder: {}; check the path and its permissions", folder.string(),
                std::strerror(errno));
  tells_numbers_ = IsSameFile(descriptor_.Number(), path_);
}

std::optional<std::string> OpenedFolder::WhyNotInPlace() const {
  std::error_code unknown;
  if (tells_numbers_ ? IsSameFile(descriptor_.Number(), path_) : fs::is_directory(path_, unknown))
    return std::nullopt;
  const fs::path now = fs::read_symlink(fmt::format("/proc/self/fd/{}", descriptor_.Number()), unknown);
  if (!unknown && IsSameFile(descriptor_.Number(), now))
    return fmt::format(
        "{}: the folder was moved to {} while it was being written; what was recorded by then is there: go "
        "on with it under that name",
        path_.string(), now.string());
  return fmt::format(
      "{}: the folder was deleted, or moved to another disk, while it was being written; look for it where "
      "it may have been moved to, or begin a new one",
      path_.string());
}

void OpenedFolder::RequireInPlace() const {
  if (const auto why = WhyNotInPlace()) throw Error("{}", *why);
}

void MakeFolderIn(const fs::path& light_field, const fs::path& inside) {
  fs::path folder = light_field;
  for (const fs::path& name : inside) {
    folder /= name;
    std::error_code reason;
    fs::create_directory(folder, reason);
    std::error_code unknown;
    if (!fs::is_directory(folder, unknown))
      ThrowDiskError(reason ? reason.value() : ENOTDIR,
                     fmt::format("{}: the folder cannot be made", folder.string()));
  }
}

}  // namespace ulf
