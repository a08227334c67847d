// A tracker led through a situation, and how far off it was at worst.
//
// Errors are of live poses against the truth, after one similarity alignment of all camera centres on one map
// (a map's frame and scale are arbitrary): centres as a share of the distance to the subject; turns in
// degrees, after one turn for all orientations.
#pragma once

#include <functional>
#include <vector>

#include "core/geometry/trajectory.h"
#include "tests/support/floors.h"
#include "tests/tracking/scenes/textured_room.h"
#include "tracking/tracker/tracker.h"

namespace ulf::test {

struct Situation {
  Furniture furniture = Furniture::kPanels;
  int frames = 80;
  std::function<Rigid3(int)> motion = TexturedRoom::HandAt;
  std::function<TexturedRoom::Moment(int)> moment = {};  // none: plain
  double distance_m = 2.5;                               // to the subject
  double believed_focal = 1;                             // the tracker's focal length over the true one
};

// A live pose beside what was true.
struct PosePair {
  int frame = 0, map_id = 0;
  Rigid3 estimated, truth;
  double depth = 0;  // median of the points seen, the map's unit; 0: unknown
};

struct WorstError {
  double center = 0;  // share of the distance
  double turn_deg = 0;
  int frame = -1;  // of the worst centre
};
// Where `distance_m` is 0, each frame's depth is the distance.
WorstError WorstOf(const std::vector<PosePair>& poses, double distance_m);
double MedianDepth(const Tracker& tracker);

struct Outcome {
  std::vector<Track> tracks;
  std::vector<PosePair> poses;
  int first_tracked = -1;
  WorstError worst;
  int loops = 0;           // closed
  WorstError worst_after;  // of the same poses when the run's end has adjusted everything

  int Tracked(int from, int to) const;
  int Told(StartObstacle obstacle) const;  // in how many frames
  int FoundAgain(int from) const;          // first frame with a pose, from this one on; -1: none
};

Outcome LeadThrough(const Situation& situation, unsigned seed, const CameraModel& camera, int features);

}  // namespace ulf::test
