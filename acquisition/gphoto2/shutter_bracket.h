// Takes the photographs of a bracket one after another: sets each shutter time before the release, and
// restores the camera's own at the end. A busy camera is asked again in the next round of its thread, until
// its time is over.
//
// Belongs to the camera's thread. It serves cameras without bracketing of their own (camera_bracket.h).
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
  // `settings` outlives it. `busy_s`: a shutter time that the camera refuses for so long is skipped.
  ShutterBracket(CameraSettings& settings, double busy_s, std::function<void(const std::string&)> notice)
      : settings_(settings), busy_s_(busy_s), notice_(std::move(notice)) {}

  // Returns whether the camera has shutter times to choose from, and tells the one it has.
  bool IsPossible() const;
  // Begins exposures, in stops from the present shutter time.
  void Begin(const std::vector<double>& stops);
  // Returns true until the shutter time is restored.
  bool IsRunning() const { return !before_.empty(); }
  // Returns the next exposure, whose shutter time is set now, to be released. Returns none when there is none
  // yet, or no more.
  std::optional<double> Next();
  // Drops the remaining exposures. Reports when the shutter time cannot be restored.
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
