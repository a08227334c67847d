// Progress of what takes over a second: a bar on a terminal, plain lines otherwise; on standard error.
#pragma once

#include <string>

namespace ulf {

class Progress {
 public:
  explicit Progress(std::string what, bool quiet = false);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  // `share` 0 to 1; `detail` is printed behind it.
  void Show(double share, const std::string& detail = {});
  // A line that stays, above the bar; also when quiet.
  void Say(const std::string& line);

 private:
  std::string what_;
  bool quiet_;
  bool terminal_;
  double started_s_;
  double last_shown_s_ = -1;
  double last_share_ = -1;
};

}  // namespace ulf
