// Capture requests as lines of text from standard input or a file, typically a fifo: a script or another
// program asks by them what a person asks by the display's keys. Never blocks.
#pragma once

#include <functional>
#include <string>

#include "coverage/session/capture_request.h"

namespace ulf::coverage {

class RequestLines {
 public:
  // "-": standard input. Throws UsageError when it cannot be read. `take` gets each line and throws
  // UsageError, in words, for one that is no request.
  RequestLines(const std::string& path, std::function<void(const std::string&)> take);
  ~RequestLines();
  RequestLines(const RequestLines&) = delete;
  RequestLines& operator=(const RequestLines&) = delete;

  // Hands over the complete lines that have arrived; reports the error of a refused one to `say`.
  void Take(const std::function<void(const std::string&)>& say);

 private:
  bool ReadMore();

  int descriptor_ = -1;
  bool others_may_write_ = false;  // a fifo: its end is only the end of who wrote last
  std::string text_;
  std::function<void(const std::string&)> take_;
};

}  // namespace ulf::coverage
