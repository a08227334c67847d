#include "tracking/tracker/track.h"

#include <fmt/core.h>

#include <cmath>

#include "core/base/counted.h"

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

std::string ZoomInWords(double focal_ratio, FrameSource source) {
  return fmt::format(
      "the zoom was moved, or another lens is mounted: the focal length is {:.1f} % {} than the given "
      "lens's; {}",
      100 * std::abs(focal_ratio - 1), focal_ratio > 1 ? "longer" : "shorter",
      IsTaken(source) ? "what was taken with it needs a run and a calibration of its own"
                      : "put it back, or calibrate");
}

std::string InWords(const Track& track, FrameSource source) {
  const bool is_taken = IsTaken(source);
  switch (track.state) {
    case TrackState::kInitializing:
      return track.start ? InWords(*track.start, source) : "starting";
    case TrackState::kTracking:
      if (track.focal_ratio) return ZoomInWords(*track.focal_ratio, source);
      return track.matched_points > 0 ? "following " + Counted(track.matched_points, "point")
                                      : "its pose is known";
    case TrackState::kApart:
      return fmt::format("apart: {} followed, but how they lie to what was seen before is not known{}",
                         Counted(track.matched_points, "point"),
                         is_taken ? "" : ": move on until both are in view");
    case TrackState::kLost:
      if (track.features && *track.features < kFewestFeatures)
        return fmt::format("lost: {} ({} of {})", Advice(StartObstacle::kTooFewFeatures, source),
                           *track.features, kFewestFeatures);
      if (track.turn && !track.start)
        return is_taken ? "position lost, only turns are followed until something is recognised"
                        : "position lost, only turns are followed: move sideways, or show a part that was "
                          "seen before";
      if (is_taken)
        return std::string("lost: nothing in the picture is recognised") +
               (track.start ? ", a new map is begun here: " + InWords(*track.start, source) : "");
      if (track.start)
        return "lost: nothing in view is recognised: go back to what was seen before, or begin anew here: " +
               InWords(*track.start, source);
      return "lost: nothing in view is recognised: show a part that was seen before, from where it was seen";
  }
  return "unknown";
}

}  // namespace ulf::tracking
