#include "tracking/tracker/start_progress.h"

#include <fmt/core.h>

#include <array>

namespace ulf::tracking {
namespace {

struct ObstacleWords {
  const char *finding, *to_do;  // what to do with a camera in the hand; empty: nothing
};

// The order is that of StartObstacle.
constexpr std::array<ObstacleWords, 9> kObstacleWords{{
    {"the map has started", ""},
    {"the first picture, which the next ones are compared with", "move the camera sideways"},
    {"the picture shows hardly any corners", "more light or texture, or a sharper picture"},
    {"too few features are found again", "more light or texture, or a slower motion"},
    {"the camera only turns", "move it sideways"},
    {"too little parallax", "continue to move sideways"},
    {"the scene is flat, and two motions explain it", "continue to move, or show something that stands out"},
    {"parts of the picture move on their own, or look alike", "show more that stands still"},
    {"the first map could not be tracked and was discarded", "continue to move sideways"},
}};

}  // namespace

std::string Advice(StartObstacle obstacle, FrameSource source) {
  const auto [finding, to_do] = kObstacleWords[static_cast<std::size_t>(obstacle)];
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
