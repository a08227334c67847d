#include "tracking/tracker/track.h"

#include <fmt/core.h>

#include <cmath>

#include "core/base/counted.h"

namespace ulf::tracking {

std::optional<double> Track::PictureSigma() const {
  return center_sigma ? std::optional(std::hypot(*center_sigma, rows_sigma)) : std::nullopt;
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
