// A camera that moves through a room and then stands still.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <vector>

#include "tests/support/floors.h"
#include "tests/tracking/scenes/textured_room.h"
#include "tracking/tracker/tracker.h"

namespace ulf::test {

struct Standing {
  bool tracked_throughout = true;
  int keyframes_added = 0, points_added = 0;  // while it stood
  double drift_m = 0;                         // of the last second's mean centre from the first's
  double spread_m = 0;                        // root mean square of single centres about their mean
};

// A dozen pictures of one view, each with noise of its own, over and over.
inline Standing StandStill(int frames) {
  constexpr int kWalk = 60, kPictures = 12, kSettle = 15, kSecond = 30;
  const TexturedRoom room({});
  Tracker tracker(TexturedRoom::Camera(), {.deterministic = true});
  std::vector<Rigid3> walked;
  for (int k = 0; k < kWalk; ++k) {
    const Track track = tracker.Step(room.Take(TexturedRoom::HandAt(k), k));
    if (track.cam_from_world) walked.push_back(*track.cam_from_world);
  }
  Standing result;
  if (walked.size() < 10) return {.tracked_throughout = false};
  const auto true_center = [](int k) { return TexturedRoom::HandAt(k).OriginInSource(); };
  const double unit_m =
      (true_center(kWalk - 1) - true_center(kWalk - static_cast<int>(walked.size()))).norm() /
      (walked.back().OriginInSource() - walked.front().OriginInSource()).norm();
  std::vector<Frame> pictures;
  for (int k = 0; k < kPictures; ++k) pictures.push_back(room.Take(TexturedRoom::HandAt(kWalk), 1000 + k));
  std::vector<Eigen::Vector3d> centers;
  TrackerStatistics before;
  for (int k = 0; k < kSettle + frames; ++k) {
    Frame frame = pictures[static_cast<std::size_t>(k * 7 % kPictures)];
    frame.id = static_cast<std::uint64_t>(kWalk + k);
    frame.device_time_s = static_cast<double>(kWalk + k) / 30;
    const Track track = tracker.Step(frame);
    result.tracked_throughout = result.tracked_throughout && track.cam_from_world;
    if (k == kSettle) before = tracker.Statistics();
    if (k >= kSettle && track.cam_from_world)
      centers.push_back(unit_m * track.cam_from_world->OriginInSource());
  }
  const auto mean = [&](std::size_t from, std::size_t to) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t i = from; i < to; ++i) sum += centers[i];
    return Eigen::Vector3d(sum / static_cast<double>(to - from));
  };
  if (centers.size() < 2 * kSecond) return {.tracked_throughout = false};
  result.keyframes_added = tracker.Statistics().keyframes - before.keyframes;
  result.points_added = tracker.Statistics().map_points - before.map_points;
  result.drift_m = (mean(centers.size() - kSecond, centers.size()) - mean(0, kSecond)).norm();
  const Eigen::Vector3d middle = mean(0, centers.size());
  double sum = 0;
  for (const Eigen::Vector3d& center : centers) sum += (center - middle).squaredNorm();
  result.spread_m = std::sqrt(sum / static_cast<double>(centers.size()));
  return result;
}

inline void ExpectNothingAdded(const Standing& stand) {
  ASSERT_TRUE(stand.tracked_throughout);
  EXPECT_LE(stand.keyframes_added, 0);
  EXPECT_LE(stand.points_added, 0);
  EXPECT_LT(stand.drift_m, 0.0005);
  EXPECT_LT(stand.spread_m, 0.002);
}

}  // namespace ulf::test
