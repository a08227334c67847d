// Decides from repeated checks of a growing map (calibration_check.h) whether the images contradict the lens,
// and when checks and searches for a better lens are due.
//
// A young map can fit a wrong lens by chance, and the standard deviations of a few keyframes are too small.
// So two checks in succession, the later on a map that has grown, must find the lens wrong and agree about
// it. Then it counts as wrong until a check does not find it wrong: what fits a bent map changes.
#pragma once

#include <optional>

#include "tracking/estimation/calibration_check.h"

namespace ulf::tracking {

class LensWatch {
 public:
  LensWatch() { Reset(); }

  // Returns whether a map of so many keyframes is to be checked.
  bool IsDue(int keyframes) const { return keyframes >= next_; }
  // Adds a check of the map; none: there was too little evidence.
  void Note(const std::optional<CalibrationCheck>& check, int keyframes);
  // Adds a check that needs no second one, because other evidence contradicts the lens, too.
  void AddConfirmed(const CalibrationCheck& check, int keyframes);
  // Returns the last check that agreed with the one before that the lens is wrong; none: it counts as right.
  const std::optional<CalibrationCheck>& contradiction() const { return contradiction_; }
  void Reset();                 // begins anew with another map
  void Restart(int keyframes);  // begins anew with another lens and the same map, of so many keyframes

  // Returns whether to search for a better lens in a map of so many keyframes, if the given lens is a guess.
  bool IsSearchDue(int keyframes) const { return keyframes >= sought_at_; }
  // Call it after a search for a better lens, with the focal lengths before and after.
  void SearchDone(int keyframes, double focal_px_before, double focal_px);

 private:
  bool Agree(const CalibrationCheck& earlier, const CalibrationCheck& later) const;

  int next_ = 0, sought_at_ = 0;  // keyframes
  std::optional<CalibrationCheck> before_, contradiction_;
};

}  // namespace ulf::tracking
