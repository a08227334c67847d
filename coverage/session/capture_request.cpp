#include "coverage/session/capture_request.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <sstream>
#include <utility>

#include "core/base/error.h"

namespace ulf::coverage {
namespace {

[[noreturn]] void Refuse(const std::string& line) {
  throw Refusal(
      "", line, fmt::format("'{}' is not a request", line),
      fmt::format(
          "there are: take-back [COUNT], take-back views ID..., subject [x,y,z,r], subject [depth D] [size "
          "SHARE], subject proposed, pause, record [anyway], finish; with {} also press KEYS, look FILE",
          Parameter("offscreen")));
}

std::vector<std::string> Words(const std::string& line) {
  std::istringstream stream(line);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

template <typename Number>
Number Read(const std::string& word, const std::string& line, Number least) {
  std::istringstream stream(word);
  Number value{};
  if (!(stream >> value) || !stream.eof() || !(value >= least)) Refuse(line);
  return value;
}

CaptureRequest ParseTakeBack(const std::vector<std::string>& words, const std::string& line) {
  if (words.size() == 1) return TakeBackLast{};
  if (words[1] != "views") {
    if (words.size() != 2) Refuse(line);
    return TakeBackLast{Read<int>(words[1], line, 1)};
  }
  TakeBackViews request;
  for (std::size_t i = 2; i < words.size(); ++i) request.ids.push_back(Read<int>(words[i], line, 0));
  if (request.ids.empty()) Refuse(line);
  return request;
}

CaptureRequest ParseSubjectRequest(const std::vector<std::string>& words, const std::string& line) {
  if (words.size() == 2 && words[1] == "proposed") return PlaceProposedSphere{};
  if (words.size() == 2) return PlaceSphere{ParseSubject(words[1])};
  FindSubject request;
  if (words.size() % 2 == 0) Refuse(line);
  for (std::size_t i = 1; i < words.size(); i += 2) {
    if (words[i] == "depth")
      request.depth = Read<double>(words[i + 1], line, 1e-9);
    else if (words[i] == "size")
      request.width_share = Read<double>(words[i + 1], line, 1e-9);
    else
      Refuse(line);
  }
  return request;
}

}  // namespace

CaptureRequest ParseCaptureRequest(const std::string& line) {
  const std::vector<std::string> words = Words(line);
  if (words.empty()) Refuse(line);
  if (words[0] == "take-back") return ParseTakeBack(words, line);
  if (words[0] == "subject") return ParseSubjectRequest(words, line);
  if (words.size() == 2 && words[0] == "record" && words[1] == "anyway")
    return SetRecording{.on = true, .although_checks_fail = true};
  if (words.size() != 1) Refuse(line);
  if (words[0] == "pause") return SetRecording{false};
  if (words[0] == "record") return SetRecording{true};
  if (words[0] == "finish") return FinishCapture{};
  Refuse(line);
}

std::uint64_t CaptureRequests::Push(CaptureRequest request) {
  const MutexLock lock(mutex_);
  asked_.push_back(std::move(request));
  return ++count_;
}

std::vector<CaptureRequest> CaptureRequests::Take() {
  const MutexLock lock(mutex_);
  return std::exchange(asked_, {});
}

RequestLines::RequestLines(const std::string& path, std::function<void(const std::string&)> take)
    : take_(std::move(take)) {
  // Without O_NONBLOCK, open() waits until another program writes to the fifo.
  descriptor_ =
      FileDescriptor(path == "-" ? dup(STDIN_FILENO) : open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  struct stat about {};
  if (!descriptor_.IsOpen() || fstat(descriptor_.Number(), &about) != 0 || S_ISDIR(about.st_mode))
    throw Refusal(
        Parameter("requests"), path,
        fmt::format("cannot be read: {}", descriptor_.IsOpen() ? "it is a folder" : std::strerror(errno)),
        "give - for standard input, or a fifo (mkfifo)");
  others_may_write_ = S_ISFIFO(about.st_mode) && path != "-";
}

// Returns false when there is nothing more at the moment.
bool RequestLines::ReadMore() {
  pollfd ready{descriptor_.Number(), POLLIN, 0};
  if (!descriptor_.IsOpen() || poll(&ready, 1, 0) <= 0) return false;
  std::array<char, 4096> bytes;
  const ssize_t count = read(descriptor_.Number(), bytes.data(), bytes.size());
  if (count > 0) {
    text_.append(bytes.data(), static_cast<std::size_t>(count));
    return true;
  }
  const bool none_now = count < 0 && (errno == EAGAIN || errno == EINTR);
  if (none_now || (count == 0 && others_may_write_)) return false;
  if (!text_.empty()) text_ += '\n';  // the last line may lack its end
  descriptor_ = FileDescriptor();
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
    } catch (const Refusal& error) {
      say(error.what());
    }
  }
}

}  // namespace ulf::coverage
