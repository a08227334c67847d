// What the tracker says about its error, beside its error: frames of whole runs, sorted into bins.
#pragma once

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/calibration/calibration_io.h"
#include "acquisition/calibration/intrinsics.h"
#include "acquisition/device/device.h"
#include "acquisition/opening/open_device.h"
#include "core/base/quantile.h"
#include "core/geometry/trajectory.h"
#include "tests/support/floors.h"
#include "tests/tracking/scenes/textured_room.h"
#include "tracking/map/pose_error.h"
#include "tracking/tracker/tracker.h"

namespace ulf::test {

struct PredictedError {
  std::uint64_t frame = 0;
  double predicted = 0;  // Track::center_sigma, in the truth's unit
  double actual = 0;     // distance of the live centre from the truth, after alignment of the run
  double distance = 0;   // of what is seen, likewise
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
    std::vector<double> distances;
    for (const VisiblePoint& point : tracker.VisiblePoints())
      distances.push_back((point.position_in_world - track.cam_from_world->OriginInSource()).norm());
    errors.push_back({frame->id, *track.center_sigma, 0, Median(std::move(distances)), track.quality,
                      track.matched_points});
  }
  const auto truth_from_world = AlignPoints(seen, truth);
  if (!truth_from_world) return {};
  for (std::size_t i = 0; i < errors.size(); ++i) {
    errors[i].predicted *= truth_from_world->scale;
    errors[i].distance *= truth_from_world->scale;
    errors[i].actual = (*truth_from_world * seen[i] - truth[i]).norm();
  }
  return errors;
}

struct ErrorBin {
  double predicted = 0, actual = 0;  // medians, of the distance
};

// Bins of equally many frames, by what the quality value predicts (QualityOf, the other way round).
inline std::vector<ErrorBin> BinErrors(std::vector<PredictedError> errors, std::size_t bins) {
  const auto predicted = [](const PredictedError& error) { return ErrorShareOf(error.quality); };
  std::sort(errors.begin(), errors.end(),
            [&](const PredictedError& a, const PredictedError& b) { return predicted(a) < predicted(b); });
  std::vector<ErrorBin> binned;
  for (std::size_t b = 0; b < bins; ++b) {
    std::vector<double> of_quality, of_truth;
    for (std::size_t i = b * errors.size() / bins; i < (b + 1) * errors.size() / bins; ++i) {
      of_quality.push_back(predicted(errors[i]));
      of_truth.push_back(errors[i].actual / errors[i].distance);
    }
    binned.push_back({Median(std::move(of_quality)), Median(std::move(of_truth))});
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

// A hand that turns on the spot before a camera whose shutter rolls for 26 ms.
inline std::vector<PredictedError> TurnErrors(unsigned seed, int frames) {
  const TexturedRoom room({.furniture = Furniture::kRound, .seed = seed});
  int k = 0;
  return RunForErrors(
      TexturedRoom::Camera(), {.deterministic = true, .seed = seed}, [&]() -> std::optional<Frame> {
        if (k >= frames) return std::nullopt;
        return room.TakeRolling(TexturedRoom::TurningAndSwayingAt, k++, 0.026, TexturedRoom::Camera());
      });
}

// A simulated scene ("studio").
inline std::vector<PredictedError> SimulatorErrors(const std::string& scene, unsigned seed,
                                                   double duration_s) {
  const auto device = OpenDevice("sim:" + scene + "?duration_s=" + std::to_string(duration_s) +
                                 "&seed=" + std::to_string(seed));
  device->Start();
  const auto next = [&]() -> std::optional<Frame> {
    while (!IsOver(device->State()))
      if (auto frame = device->Next(std::chrono::milliseconds(200))) return frame;
    return std::nullopt;
  };
  const auto first = next();
  if (!first) return {};
  const CameraModel camera = ResolveIntrinsics(*device, {}, first->image.width(), first->image.height());
  return RunForErrors(camera, {.deterministic = true, .seed = seed}, next);
}

// A recording's folder: pictures, intrinsics.txt, and colmap_reference.txt or groundtruth.txt.
inline std::vector<PredictedError> RecordingErrors(const std::filesystem::path& folder) {
  const bool colmap = std::filesystem::exists(folder / "colmap_reference.txt");
  const auto truth = ReadTum(folder / (colmap ? "colmap_reference.txt" : "groundtruth.txt"));
  const auto device =
      OpenDevice("replay:" + folder.string() + (colmap ? "?glob=*.color.jpg" : "?glob=*.jpg"));
  device->Start();
  const auto next = [&]() -> std::optional<Frame> {
    auto frame = device->Next(std::chrono::milliseconds(1000));
    if (!frame) return std::nullopt;
    for (const TimedPose& pose : truth)
      if (std::abs(pose.time_s - frame->device_time_s) < 1.0 / 60)
        frame->known_cam_from_world = pose.cam_from_world;
    return frame;
  };
  return RunForErrors(ReadCalibration(folder / "intrinsics.txt"), {.deterministic = true}, next);
}

}  // namespace ulf::test
