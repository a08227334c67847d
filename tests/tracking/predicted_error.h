// What the tracker says about its error, beside its error: frames of whole runs, sorted into bins.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <vector>

#include "tests/tracking/textured_room.h"
#include "tracking/quantile.h"
#include "tracking/tracker.h"
#include "tracking/trajectory.h"

namespace ulf::test {

struct PredictedError {
  std::uint64_t frame = 0;
  double predicted = 0;  // Track::center_sigma, in the truth's unit
  double actual = 0;     // distance of the live centre from the truth, after alignment of the run
  double quality = 0;
  int points = 0;
};

// `next` gives frames with known poses until there are none. Only frames that are tracked count.
inline std::vector<PredictedError> RunForErrors(const CameraModel& camera, const TrackerOptions& options,
                                                const std::function<std::optional<Frame>()>& next) {
  Tracker tracker(camera, options);
  std::vector<Eigen::Vector3d> seen, truth;
  std::vector<PredictedError> errors;
  while (const auto frame = next()) {
    const Track track = tracker.Step(*frame);
    if (!track.cam_from_world || !track.center_sigma || !frame->known_cam_from_world) continue;
    seen.push_back(track.cam_from_world->OriginInSource());
    truth.push_back(frame->known_cam_from_world->OriginInSource());
    errors.push_back({frame->id, *track.center_sigma, 0, track.quality, track.matched_points});
  }
  const auto truth_from_world = AlignPoints(seen, truth);
  if (!truth_from_world) return {};
  for (std::size_t i = 0; i < errors.size(); ++i) {
    errors[i].predicted *= truth_from_world->scale;
    errors[i].actual = (*truth_from_world * seen[i] - truth[i]).norm();
  }
  return errors;
}

struct ErrorBin {
  int frames = 0;
  double predicted = 0, actual = 0;  // root mean squares
};

// Bins of equally many frames, by what was predicted.
inline std::vector<ErrorBin> BinErrors(std::vector<PredictedError> errors, std::size_t bins) {
  std::sort(errors.begin(), errors.end(),
            [](const PredictedError& a, const PredictedError& b) { return a.predicted < b.predicted; });
  std::vector<ErrorBin> binned(bins);
  for (std::size_t i = 0; i < errors.size(); ++i) {
    ErrorBin& bin = binned[i * bins / errors.size()];
    ++bin.frames;
    bin.predicted += errors[i].predicted * errors[i].predicted;
    bin.actual += errors[i].actual * errors[i].actual;
  }
  for (ErrorBin& bin : binned) {
    bin.predicted = std::sqrt(bin.predicted / std::max(1, bin.frames));
    bin.actual = std::sqrt(bin.actual / std::max(1, bin.frames));
  }
  return binned;
}

// The room under different conditions: sensor noise and how many features there are.
inline std::vector<PredictedError> RoomErrors(double noise, int features, unsigned seed, int frames) {
  const TexturedRoom room({.seed = seed, .noise = noise});
  int k = 0;
  return RunForErrors(TexturedRoom::Camera(), {.deterministic = true, .seed = seed, .features = features},
                      [&]() -> std::optional<Frame> {
                        if (k >= frames) return std::nullopt;
                        const int now = k++;
                        return room.Take(TexturedRoom::HandAt(now), static_cast<std::uint64_t>(now));
                      });
}

}  // namespace ulf::test
