// Tells the operator why a map has not started yet: what prevents the start, how much parallax there is
// (median over the matched features), and how much is needed.
#pragma once

#include <string>

#include "core/frames/frame.h"
#include "tracking/estimation/relative_pose.h"

namespace ulf::tracking {

enum class StartObstacle {
  kNone,                // the map has started
  kFirstView,           // this frame is the reference for later ones
  kTooFewFeatures,      // this image shows hardly any corners: no texture, darkness, out of focus
  kTooFewMatches,       // too few features match the reference: blur, noise, or a jump
  kRotationOnly,        // the camera only turned, or stood still
  kLowParallax,         // the camera moved, but not far enough for a certain direction
  kAmbiguousPlane,      // the scene is flat, and two motions explain it
  kConflictingMotions,  // parts of the image move differently, or repeat
  kMapDidNotHold,       // a map was made and discarded: its second frame could not be tracked on it
};

// With fewer corners in an image no map starts, and a lost camera is not found. Guessed.
inline constexpr int kFewestFeatures = 80;

struct StartProgress {
  StartObstacle obstacle = StartObstacle::kFirstView;
  double parallax_deg = 0;
  double parallax_needed_deg = 0;  // that suffices at this frame's noise, as far as is known
  int matches = 0;                 // for kTooFewFeatures the number of features
  int matches_needed = 0;
};

// The model and the evidence of the two views that started a map.
struct MapStart {
  RelativePoseModel model = RelativePoseModel::kEssential;
  MotionEvidence evidence;
};

// Returns the obstacle and, for a camera in the hand, what to do: a sentence without a full stop.
std::string Advice(StartObstacle obstacle, FrameSource source);

// Returns the same, and how much of the parallax or of the matches there is.
std::string InWords(const StartProgress& start, FrameSource source);

}  // namespace ulf::tracking
