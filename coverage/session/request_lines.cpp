#include "coverage/session/request_lines.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "core/base/error.h"

namespace ulf::coverage {

RequestLines::RequestLines(const std::string& path, std::function<void(const std::string&)> take)
    : take_(std::move(take)) {
  // Without O_NONBLOCK opening a fifo waits for whoever writes.
  descriptor_ = path == "-" ? dup(STDIN_FILENO) : open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  struct stat about {};
  if (descriptor_ < 0 || fstat(descriptor_, &about) != 0 || S_ISDIR(about.st_mode))
    throw UsageError("--requests {}: cannot be read: {}; give - for standard input, or a fifo (mkfifo)", path,
                     descriptor_ < 0 ? std::strerror(errno) : "it is a folder");
  others_may_write_ = S_ISFIFO(about.st_mode) && path != "-";
}

RequestLines::~RequestLines() {
  if (descriptor_ >= 0) close(descriptor_);
}

// False when there is nothing more at the moment.
bool RequestLines::ReadMore() {
  pollfd ready{descriptor_, POLLIN, 0};
  if (descriptor_ < 0 || poll(&ready, 1, 0) <= 0) return false;
  std::array<char, 4096> bytes;
  const ssize_t count = read(descriptor_, bytes.data(), bytes.size());
  if (count > 0) {
    text_.append(bytes.data(), static_cast<std::size_t>(count));
    return true;
  }
  const bool none_now = count < 0 && (errno == EAGAIN || errno == EINTR);
  if (none_now || (count == 0 && others_may_write_)) return false;
  if (!text_.empty()) text_ += '\n';  // the last line needs no end
  close(descriptor_);
  descriptor_ = -1;
  return false;
}

void RequestLines::Take(const std::function<void(const std::string&)>& say) {
  while (ReadMore()) {
  }
  for (std::size_t end; (end = text_.find('\n')) != std::string::npos;) {
    const std::string line = text_.substr(0, end);
    text_.erase(0, end + 1);
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    try {
      take_(line);
    } catch (const UsageError& error) {
      say(error.what());
    }
  }
}

}  // namespace ulf::coverage
