// Photographs of a bracket one after another: each gets its shutter time before it is released, and the
// camera has its own back at the end. A camera that is busy is asked again in the next round of its thread,
// so long as it may be busy.
//
// Belongs to the camera's thread. For cameras without a bracketing of their own (camera_bracket.h).
#pragma once

#include <chrono>
#include <deque>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "acquisition/gphoto2/camera_settings.h"

namespace ulf::acquisition {

class ShutterBracket {
 public:
  // `settings` outlives it. `busy_s`: so long a camera may refuse a shutter time before the bracket goes on
  // without it.
  ShutterBracket(CameraSettings& settings, double busy_s, std::function<void(const std::string&)> notice)
      : settings_(settings), busy_s_(busy_s), notice_(std::move(notice)) {}

  // Whether the camera has shutter times to choose from, and tells the one it has.
  bool IsPossible() const;
  // Stops from the present shutter time.
  void Begin(const std::vector<double>& stops);
  // Until the shutter is back where it was.
  bool IsRunning() const { return !before_.empty(); }
  // The next exposure whose shutter time is set now: release it. None: not yet, or no more.
  std::optional<double> Next();
  // Gives up what is to come. Tells when the shutter stays elsewhere.
  void GiveUp(bool camera_is_gone);

 private:
  std::optional<std::string> ShutterAt(double stops) const;
  bool Set(const std::string& shutter);
  void Restore();

  CameraSettings& settings_;
  const double busy_s_;
  const std::function<void(const std::string&)> notice_;
  std::deque<double> stops_;  // to come
  std::string before_;        // empty: no bracket is taken
  double before_s_ = 0;
  std::set<std::string> used_;
  std::optional<std::chrono::steady_clock::time_point> refused_since_;
  std::string refusal_;  // for so long that it counts; empty: none
};

}  // namespace ulf::acquisition
