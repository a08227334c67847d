// Sets the shutter times of a bracket one after another; the caller releases the photographs. At the end it
// restores the shutter time that the camera had before. Next() asks a busy camera again for `busy_s`.
//
// Only the camera's thread may use it. It serves cameras without bracketing of their own (camera_bracket.h).
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
  // `settings` must outlive it. `busy_s`: a shutter time that the camera refuses for so long is skipped.
  // `notice` is called with messages for the user.
  ShutterBracket(CameraSettings& settings, double busy_s, std::function<void(const std::string&)> notice)
      : settings_(settings), busy_s_(busy_s), notice_(std::move(notice)) {}

  // Returns whether the camera tells its present shutter time and offers others.
  bool IsPossible() const;
  // Begins a bracket; requires IsPossible(). `stops`: from the present shutter time; above 0: longer.
  void Begin(const std::vector<double>& stops);
  // Returns true until the shutter time is restored.
  bool IsRunning() const { return !before_.empty(); }
  // Sets the shutter time of the next exposure and returns its stops: release the shutter, and call it again
  // when the photograph has come. When it returns none, release nothing, and call it again while IsRunning().
  std::optional<double> Next();
  // Drops the remaining exposures and restores the shutter time, or asks for that by `notice`.
  void GiveUp(bool camera_is_gone);

 private:
  std::optional<std::string> ShutterAt(double stops) const;
  bool Set(const std::string& shutter);
  void Restore();

  CameraSettings& settings_;
  const double busy_s_;
  const std::function<void(const std::string&)> notice_;
  std::deque<double> stops_;  // to come
  std::string before_;        // the shutter time to restore; empty: no bracket is taken
  double before_s_ = 0;
  std::set<std::string> used_;
  std::optional<std::chrono::steady_clock::time_point> refused_since_;
  std::string refusal_;  // why the camera has refused for `busy_s`; empty: it has not
};

}  // namespace ulf::acquisition
