// A number of a camera, which some cameras have whole and others not, in the unit that ulf counts in.
#pragma once

#include <optional>
#include <string>
#include <utility>

#include "acquisition/aravis/aravis_calls.h"
#include "acquisition/aravis/aravis_session.h"

namespace ulf::acquisition {

class AravisNumber {
 public:
  // `unit`: ours in one of the camera's. Empty `feature`: the camera does not have it.
  AravisNumber() = default;
  AravisNumber(const AravisSession& session, std::string feature, double unit = 1);

  bool IsThere() const { return !feature_.empty(); }
  const std::string& Feature() const { return feature_; }
  // None: not there, or not readable now.
  std::optional<double> Read() const;
  // Rounded to the camera's steps where it counts in whole numbers. Throws Error that begins with `who`.
  void Write(const std::string& who, double value) const;
  // Smallest and largest. Throws Error that begins with `who`.
  std::pair<double, double> Bounds(const std::string& who) const;
  // 0: it has none.
  double Step() const;

 private:
  ArvCamera* camera_ = nullptr;
  std::string feature_;
  double unit_ = 1;
  bool is_whole_ = false;
};

}  // namespace ulf::acquisition
