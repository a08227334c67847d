#include "tracking/tracker/track_words.h"

#include <fmt/core.h>

#include <cmath>

#include "core/base/counted.h"

namespace ulf::tracking {

std::string InWords(const StartProgress& start) {
  switch (start.obstacle) {
    case StartObstacle::kNone:
    case StartObstacle::kFirstView:
    case StartObstacle::kConflictingMotions:
      return Advice(start.obstacle);
    case StartObstacle::kTooFewFeatures:
    case StartObstacle::kTooFewMatches:
      return fmt::format("{} ({} of {})", Advice(start.obstacle), start.matches, start.matches_needed);
    case StartObstacle::kRotationOnly:
    case StartObstacle::kLowParallax:
    case StartObstacle::kAmbiguousPlane:
    case StartObstacle::kMapDidNotHold:
      break;
  }
  return fmt::format("{} ({:.1f} of {:.1f} degrees of parallax)", Advice(start.obstacle), start.parallax_deg,
                     start.parallax_needed_deg);
}

std::string ZoomInWords(double focal_ratio) {
  return fmt::format(
      "the zoom was moved, or another lens is mounted: the focal length is {:.1f} % {} than the given "
      "lens's; "
      "put it back, or calibrate",
      100 * std::abs(focal_ratio - 1), focal_ratio > 1 ? "longer" : "shorter");
}

std::string InWords(const Track& track) {
  switch (track.state) {
    case TrackState::kInitializing:
      return track.start ? InWords(*track.start) : "starting";
    case TrackState::kTracking:
      if (track.focal_ratio) return ZoomInWords(*track.focal_ratio);
      return track.matched_points > 0 ? "following " + Counted(track.matched_points, "point")
                                      : "its pose is known";
    case TrackState::kApart:
      return fmt::format(
          "apart: {} followed, but how they lie to what was seen before is not known: move on until both are "
          "in view",
          Counted(track.matched_points, "point"));
    case TrackState::kLost:
      if (track.features && *track.features < kFewestFeatures)
        return fmt::format("lost: {} ({} of {})", Advice(StartObstacle::kTooFewFeatures), *track.features,
                           kFewestFeatures);
      if (track.start)
        return "lost: nothing in view is recognised: go back to what was seen before, or begin anew here: " +
               InWords(*track.start);
      if (track.turn)
        return "position lost, only turns are followed: move sideways, or show a part that was seen before";
      return "lost: nothing in view is recognised: show a part that was seen before, from where it was seen";
  }
  return "unknown";
}

}  // namespace ulf::tracking
