#include "tracking/track_words.h"

#include <fmt/core.h>

#include "acquisition/counted.h"

namespace ulf {

std::string InWords(const StartProgress& start) {
  switch (start.obstacle) {
    case StartObstacle::kNone:
    case StartObstacle::kFirstView:
    case StartObstacle::kConflictingMotions:
      return Advice(start.obstacle);
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

std::string InWords(const Track& track) {
  switch (track.state) {
    case TrackState::kInitializing:
      return track.start ? InWords(*track.start) : "starting";
    case TrackState::kTracking:
      return track.matched_points > 0 ? "following " + Counted(track.matched_points, "point")
                                      : "its pose is known";
    case TrackState::kLost:
      return "lost: show a part that was seen before";
  }
  return "unknown";
}

}  // namespace ulf
