// What a map still waits for, for whoever holds the camera: how much parallax there is, how much it takes,
// and what stands in the way. Angles are degrees, medians over the matched features.
#pragma once

namespace ulf::tracking {

enum class StartObstacle {
  kNone,                // the map has started
  kFirstView,           // this frame is what later ones are compared with
  kTooFewFeatures,      // in this picture alone: hardly any texture, darkness, or out of focus
  kTooFewMatches,       // with the reference: blur, noise, or a jump
  kRotationOnly,        // the camera only turned, or stood still
  kLowParallax,         // it moved, not far enough for the direction to be certain
  kAmbiguousPlane,      // what is seen is flat, and two motions explain it
  kConflictingMotions,  // parts of the picture move differently, or repeat
  kMapDidNotHold,       // a map was made and refused: this frame could not be tracked on it
};

// Fewer corners than that in a picture start no map, and find no camera that was lost.
inline constexpr int kFewestFeatures = 80;

struct StartProgress {
  StartObstacle obstacle = StartObstacle::kFirstView;
  double parallax_deg = 0;
  // What it takes at this frame's noise, as far as is known: at least the smallest that is ever accepted.
  double parallax_needed_deg = 0;
  int matches = 0;  // of kTooFewFeatures: features
  int matches_needed = 0;
};

// What to do about it, as a sentence for the operator without a full stop.
inline const char* Advice(StartObstacle obstacle) {
  switch (obstacle) {
    case StartObstacle::kNone:
      return "the map has started";
    case StartObstacle::kFirstView:
      return "move the camera sideways";
    case StartObstacle::kTooFewFeatures:
      return "the picture shows hardly any corners: more light or texture, or a sharper picture";
    case StartObstacle::kTooFewMatches:
      return "too few features are found again: more light or texture, or a slower hand";
    case StartObstacle::kRotationOnly:
      return "the camera only turns: move it sideways";
    case StartObstacle::kLowParallax:
      return "too little parallax: move on sideways";
    case StartObstacle::kAmbiguousPlane:
      return "what is seen is flat and two motions explain it: move on, or show something that stands out";
    case StartObstacle::kConflictingMotions:
      return "parts of the picture move on their own, or repeat: show more that stands still";
    case StartObstacle::kMapDidNotHold:
      return "the first map did not hold: move on sideways";
  }
  return "unknown";
}

}  // namespace ulf::tracking
