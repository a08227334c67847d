// Checks the given lens against a map that grows, and says when the images contradict it.
//
// A young map can fit a wrong lens by chance, and the deviations of a few keyframes are too small. So two
// checks in succession, the later on a map that has grown, must find the lens wrong and agree about it. It
// then counts as wrong until a check finds it right: what fits a map that a wrong lens bends changes as the
// map grows.
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
  // Adds a check that needs no second one that agrees, because other evidence contradicts the lens, too.
  void AddConfirmed(const CalibrationCheck& check, int keyframes);
  // Returns the last of two checks that agreed that the lens is wrong; none if the lens is not contradicted.
  const std::optional<CalibrationCheck>& contradiction() const { return contradiction_; }
  void Reset();  // begins anew with another map
  // Begins anew with another lens under the same map of so many keyframes.
  void Restart(int keyframes);

  // Returns whether to search for a better lens at this number of keyframes, if the given lens is a guess.
  bool IsSearchDue(int keyframes) const { return keyframes >= sought_at_; }
  // Call it after a search for a better lens, with the focal length before and after.
  void SearchDone(int keyframes, double focal_px_before, double focal_px);

 private:
  bool Agree(const CalibrationCheck& earlier, const CalibrationCheck& later) const;

  int next_ = 0, sought_at_ = 0;  // keyframes
  std::optional<CalibrationCheck> before_, contradiction_;
};

}  // namespace ulf::tracking
