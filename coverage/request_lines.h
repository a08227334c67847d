// Requests as lines of text, from standard input or a file, typically a fifo: what the operator display does
// with keys, a script or another program does with these. Reads what is there and never waits.
#pragma once

#include <functional>
#include <string>

#include "coverage/capture_request.h"

namespace ulf {

class RequestLines {
 public:
  // "-": standard input. Throws UsageError when it cannot be read. `others` takes the lines that are not for
  // the capture: false, or UsageError in words, for one that is not its own.
  explicit RequestLines(const std::string& path, std::function<bool(const std::string&)> others = {});
  ~RequestLines();
  RequestLines(const RequestLines&) = delete;
  RequestLines& operator=(const RequestLines&) = delete;

  // The whole lines that have come since; one that is no request is answered with the parser's words.
  void Take(CaptureRequests& requests, const std::function<void(const std::string&)>& say);

 private:
  bool ReadMore();

  int descriptor_ = -1;
  bool others_may_write_ = false;  // a fifo: its end is only the end of who wrote last
  std::string text_;
  std::function<bool(const std::string&)> others_;
};

}  // namespace ulf
