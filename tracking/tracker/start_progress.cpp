#include "tracking/tracker/start_progress.h"

#include <fmt/core.h>

namespace ulf::tracking {
namespace {

struct ObstacleWords {
  const char *finding, *to_do;  // what to do with a camera in the hand; empty: nothing
};

ObstacleWords WordsOf(StartObstacle obstacle) {
  switch (obstacle) {
    case StartObstacle::kNone:
      return {"the map has started", ""};
    case StartObstacle::kFirstView:
      return {"the first picture, which the next ones are compared with", "move the camera sideways"};
    case StartObstacle::kTooFewFeatures:
      return {"the picture shows hardly any corners", "more light or texture, or a sharper picture"};
    case StartObstacle::kTooFewMatches:
      return {"too few features are found again", "more light or texture, or a slower motion"};
    case StartObstacle::kRotationOnly:
      return {"the camera only turns", "move it sideways"};
    case StartObstacle::kLowParallax:
      return {"too little parallax", "continue to move sideways"};
    case StartObstacle::kAmbiguousPlane:
      return {"the scene is flat, and two motions explain it",
              "continue to move, or show something that stands out"};
    case StartObstacle::kConflictingMotions:
      return {"parts of the picture move on their own, or look alike", "show more that stands still"};
    case StartObstacle::kMapDidNotHold:
      return {"the first map could not be tracked and was discarded", "continue to move sideways"};
  }
  return {"unknown", ""};
}

}  // namespace

std::string Advice(StartObstacle obstacle, FrameSource source) {
  const auto [finding, to_do] = WordsOf(obstacle);
  if (IsTaken(source) || *to_do == 0) return finding;
  return obstacle == StartObstacle::kFirstView ? to_do : fmt::format("{}: {}", finding, to_do);
}

std::string InWords(const StartProgress& start, FrameSource source) {
  switch (start.obstacle) {
    case StartObstacle::kNone:
    case StartObstacle::kFirstView:
    case StartObstacle::kConflictingMotions:
      return Advice(start.obstacle, source);
    case StartObstacle::kTooFewFeatures:
    case StartObstacle::kTooFewMatches:
      return fmt::format("{} ({} of {})", Advice(start.obstacle, source), start.matches,
                         start.matches_needed);
    case StartObstacle::kRotationOnly:
    case StartObstacle::kLowParallax:
    case StartObstacle::kAmbiguousPlane:
    case StartObstacle::kMapDidNotHold:
      break;
  }
  return fmt::format("{} ({:.1f} of {:.1f} degrees of parallax)", Advice(start.obstacle, source),
                     start.parallax_deg, start.parallax_needed_deg);
}

}  // namespace ulf::tracking
