// Checks the given lens against a map that grows, and says when the images contradict it.
//
// A young map can fit a wrong lens by chance, and the deviations of a few keyframes are too small. So two checks in
// succession, the later on a map that has grown, must find the lens wrong and agree about it. It then counts as wrong until
// a check finds it right: what fits a map that a wrong lens bends changes as the map grows.
#pragma once

#include <optional>

#include "tracking/estimation/calibration_check.h"

namespace ulf::tracking {

// Guessed.
struct LensWatchOptions {
  int first_keyframes = 8;     // with which the first check is made
  double growth = 1.25;        // of the keyframes from check to check
  double most_apart = 0.02;    // share of the focal length by which two checks that agree differ, at most
  double most_apart_k1 = 0.3;  // the same of the distortion's difference from the given one
  double most_apart_center = 0.01;  // and of the principal point's, of the focal length
  // A lens that nobody has calibrated is sought when the map has so many keyframes, again each time it has grown by this,
  // and no longer once its focal length has changed by less than this share.
  int sought_keyframes = 20;
  double sought_growth = 1.6;
  double settled = 0.005;
};

class LensWatch {
 public:
  explicit LensWatch(const LensWatchOptions& options = {})
      : options_(options), next_(options.first_keyframes), sought_at_(options.sought_keyframes) {}

  bool IsDue(int keyframes) const { return keyframes >= next_; }
  void Note(const std::optional<CalibrationCheck>& check, int keyframes);
  // The same where something else speaks against the lens, too: this check needs no other that agrees.
  void NoteDoubted(const CalibrationCheck& check, int keyframes);
  // The last of two checks that agreed that the lens is wrong; none: the lens is not contradicted.
  const std::optional<CalibrationCheck>& contradiction() const { return contradiction_; }
  void Reset();  // for another map
  // For another lens under the same map of so many keyframes.
  void Restart(int keyframes);

  // For a lens that is a guess: whether another is due to be sought whether or not images contradict it.
  bool IsSought(int keyframes) const { return keyframes >= sought_at_; }
  void NoteSought(int keyframes, double focal_px_before, double focal_px);

 private:
  bool Agree(const CalibrationCheck& earlier, const CalibrationCheck& later) const;

  LensWatchOptions options_;
  int next_, sought_at_;
  std::optional<CalibrationCheck> before_, contradiction_;
};

}  // namespace ulf::tracking
