// Shows the progress of work of more than a second on standard error: a bar on a terminal, else plain lines.
#pragma once

#include <chrono>
#include <string>

namespace ulf {

class Progress {
 public:
  // `what` names the work and stands before the bar. If `quiet`, Show() prints nothing.
  explicit Progress(std::string what, bool quiet = false);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  // `share` is the part done so far, 0 to 1. `detail` is printed after the percentage.
  void Show(double share, const std::string& detail = {});
  // Prints a line that stays, above the bar, also when quiet.
  void Say(const std::string& line);

 private:
  std::string what_;
  bool quiet_;
  bool terminal_;
  std::chrono::steady_clock::time_point started_ = std::chrono::steady_clock::now();
  double last_shown_s_ = -1;  // since `started_`
  double last_share_ = -1;
};

}  // namespace ulf
