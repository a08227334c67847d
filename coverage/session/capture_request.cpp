#include "coverage/session/capture_request.h"

#include <sstream>
#include <utility>

#include "core/base/error.h"

namespace ulf::coverage {
namespace {

[[noreturn]] void Refuse(const std::string& line) {
  throw UsageError(
      "'{}' is not a request; there are: take-back [COUNT], take-back views ID..., subject [x,y,z,r], "
      "subject "
      "[depth D] [size SHARE], pause, record, finish; with --offscreen also press KEYS, look FILE",
      line);
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
  if (words.size() == 2) return PlaceSubject{ParseSubject(words[1])};
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
  if (words.size() != 1) Refuse(line);
  if (words[0] == "pause") return SetRecording{false};
  if (words[0] == "record") return SetRecording{true};
  if (words[0] == "finish") return FinishCapture{};
  Refuse(line);
}

std::uint64_t CaptureRequests::Ask(CaptureRequest request) {
  const MutexLock lock(mutex_);
  asked_.push_back(std::move(request));
  return ++count_;
}

std::vector<CaptureRequest> CaptureRequests::Take() {
  const MutexLock lock(mutex_);
  return std::exchange(asked_, {});
}

}  // namespace ulf::coverage
