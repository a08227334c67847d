#include "acquisition/atomic_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
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
  if (descriptor < 0)
    throw Error("{}: cannot be written: {}; check the folder's permissions", path.string(),
                std::strerror(errno));
  const auto fail = [&](const char* what) {
    const int reason = errno;
    close(descriptor);
    unlink(temporary.c_str());
    throw Error("{}: {}: {}; free some space or choose another folder", path.string(), what,
                std::strerror(reason));
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
    throw Error("{}: cannot be renamed into place: {}", path.string(), std::strerror(reason));
  }
  SyncFolder(path.parent_path().empty() ? fs::path(".") : path.parent_path());
}

std::string ReadWholeFile(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw Error("{}: cannot be read: {}", path.string(), std::strerror(errno));
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace ulf
