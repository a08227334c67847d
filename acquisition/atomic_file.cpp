#include "acquisition/atomic_file.h"

#include <fcntl.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>

#include "acquisition/error.h"

namespace ulf {
namespace fs = std::filesystem;

void SyncFolder(const fs::path& folder) {
  const int descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) throw Error("{}: cannot open the folder: {}", folder.string(), std::strerror(errno));
  fsync(descriptor);
  close(descriptor);
}

void WriteFileAtomically(const fs::path& path, std::string_view bytes) {
  const fs::path temporary = path.string() + std::string(kTemporaryEnding);
  const int descriptor = open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (descriptor < 0) ThrowDiskError(errno, fmt::format("{}: cannot be written", path.string()));
  const auto fail = [&](const char* what) {
    const int reason = errno;
    close(descriptor);
    unlink(temporary.c_str());
    ThrowDiskError(reason, fmt::format("{}: {}", path.string(), what));
  };
  while (!bytes.empty()) {
    const ssize_t written = write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail("writing failed");
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  if (fsync(descriptor) != 0) fail("syncing to disk failed");
  close(descriptor);
  if (rename(temporary.c_str(), path.c_str()) != 0) {
    const int reason = errno;
    unlink(temporary.c_str());
    ThrowDiskError(reason, fmt::format("{}: cannot be renamed into place", path.string()));
  }
  SyncFolder(path.parent_path().empty() ? fs::path(".") : path.parent_path());
}

void ThrowDiskError(int reason, const std::string& what_failed) {
  if (reason == ENOSPC || reason == EDQUOT)
    throw DiskFullError("{}: {}; free some space", what_failed, std::strerror(reason));
  throw Error("{}: {}; check the folder's permissions and its disk, or choose another folder", what_failed,
              std::strerror(reason));
}

void MakeFolder(const fs::path& folder) {
  std::error_code reason;
  fs::create_directories(folder, reason);
  if (reason || !fs::is_directory(folder))
    ThrowDiskError(reason ? reason.value() : ENOTDIR,
                   fmt::format("{}: the folder cannot be made", folder.string()));
}

std::uint64_t FreeBytes(const fs::path& folder) {
  struct statvfs room {};
  if (statvfs(folder.c_str(), &room) != 0) return std::numeric_limits<std::uint64_t>::max();
  return static_cast<std::uint64_t>(room.f_bavail) * room.f_frsize;
}

std::string ReadWholeFile(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw Error("{}: cannot be read: {}", path.string(), std::strerror(errno));
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace ulf
