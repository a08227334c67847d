#include "tests/stability/situations.h"
#include "tests/support/floors.h"

#include <algorithm>
#include <limits>
#include <map>

namespace ulf::test {

WorstError WorstOf(const std::vector<PosePair>& poses, double distance_m) {
  std::map<int, std::vector<PosePair>> by_map;
  for (const PosePair& pose : poses) by_map[pose.map_id].push_back(pose);
  WorstError worst;
  for (const auto& [id, of_map] : by_map) {
    if (of_map.size() < 3) continue;  // two poses can always be aligned
    std::vector<Eigen::Vector3d> estimated, truth;
    for (const PosePair& pose : of_map) {
      estimated.push_back(pose.estimated.OriginInSource());
      truth.push_back(pose.truth.OriginInSource());
    }
    const auto aligned = AlignPoints(estimated, truth);
    if (!aligned) {
      worst.center = worst.turn_deg = std::numeric_limits<double>::infinity();
      return worst;
    }
    // Turned so that orientations agree best: a path that is nearly straight does not hold its own turn.
    std::vector<Eigen::Vector3d> axes, true_axes;
    for (const PosePair& pose : of_map)
      for (int axis = 0; axis < 3; ++axis) {
        axes.push_back(pose.estimated.DirectionInSource(Eigen::Vector3d::Unit(axis)));
        true_axes.push_back(pose.truth.DirectionInSource(Eigen::Vector3d::Unit(axis)));
      }
    const auto turned_alike = AlignPoints(axes, true_axes);
    const Eigen::Quaterniond world_from_truth =
        Eigen::Quaterniond((turned_alike ? *turned_alike : *aligned).rotation).conjugate();
    for (std::size_t i = 0; i < of_map.size(); ++i) {
      const double distance = distance_m > 0 ? distance_m : aligned->scale * of_map[i].depth;
      const double off = (*aligned * estimated[i] - truth[i]).norm() / distance;
      const Eigen::Quaterniond turned = of_map[i].estimated.rotation * world_from_truth;
      const double turn_deg = RotationAngle(turned * of_map[i].truth.rotation.conjugate()) * 180 / M_PI;
      if (off > worst.center) {
        worst.center = off;
        worst.frame = of_map[i].frame;
      }
      worst.turn_deg = std::max(worst.turn_deg, turn_deg);
    }
  }
  return worst;
}

double MedianDepth(const Tracker& tracker) {
  std::vector<double> depths;
  for (const VisiblePoint& point : tracker.VisiblePoints()) depths.push_back(point.depth);
  if (depths.empty()) return 0;
  const auto middle = depths.begin() + static_cast<long>(depths.size() / 2);
  std::nth_element(depths.begin(), middle, depths.end());
  return *middle;
}

int Outcome::Tracked(int from, int to) const {
  return static_cast<int>(std::count_if(tracks.begin() + from, tracks.begin() + to,
                                        [](const Track& track) { return track.cam_from_world.has_value(); }));
}

int Outcome::Told(StartObstacle obstacle) const {
  return static_cast<int>(std::count_if(tracks.begin(), tracks.end(), [&](const Track& track) {
    return track.start && track.start->obstacle == obstacle;
  }));
}

int Outcome::FoundAgain(int from) const {
  for (int k = from; k < static_cast<int>(tracks.size()); ++k)
    if (tracks[static_cast<std::size_t>(k)].cam_from_world) return k;
  return -1;
}

Outcome LeadThrough(const Situation& situation, unsigned seed, const CameraModel& camera, int features) {
  const TexturedRoom room({.furniture = situation.furniture, .seed = seed});
  CameraModel believed = camera;
  believed.fx *= situation.believed_focal;
  believed.fy *= situation.believed_focal;
  Tracker tracker(believed, {.deterministic = true, .seed = seed, .features = features});
  Outcome outcome;
  std::vector<Anchored> anchors;
  for (int k = 0; k < situation.frames; ++k) {
    const TexturedRoom::Moment moment = situation.moment ? situation.moment(k) : TexturedRoom::Moment{};
    const Frame frame = room.Take(situation.motion(k), static_cast<std::uint64_t>(k), camera, moment);
    const Track track = tracker.Step(frame);
    if (track.cam_from_world) {
      if (outcome.first_tracked < 0) outcome.first_tracked = k;
      outcome.poses.push_back(
          {k, track.map_id, *track.cam_from_world, *frame.known_cam_from_world, MedianDepth(tracker)});
      anchors.push_back(*track.anchor);
    }
    outcome.tracks.push_back(track);
  }
  outcome.worst = WorstOf(outcome.poses, situation.distance_m);
  outcome.loops = tracker.Statistics().loops;
  if (!anchors.empty()) tracker.Finish();
  std::vector<PosePair> after = outcome.poses;
  for (std::size_t i = 0; i < anchors.size(); ++i) after[i].estimated = tracker.PoseOf(anchors[i]);
  outcome.worst_after = WorstOf(after, situation.distance_m);
  return outcome;
}

}  // namespace ulf::test
