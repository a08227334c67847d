// Whole runs of the tracker, deterministic, for charts: what a frame costs and how far off poses are.
#pragma once

#include <string>
#include <vector>

#include "tests/measure/effort.h"
#include "tests/measure/table.h"
#include "tests/support/floors.h"
#include "tracking/tracker/tracker.h"

namespace ulf::test {

struct TrackedRun {
  // Of a frame, median, mapping apart; in units of cv::ORB with 1,000 features on frames of the same run.
  double cpu_over_orb = 0;
  double mapping_over_orb = 0;       // of all else, the map's adjustments among it, by the number of frames
  double tracked_share = 0;          // of all frames
  double live_mm = 0, after_mm = 0;  // centres, RMS after alignment; infinite where too few were tracked
  double keyframes = 0, points = 0;
};

// What is made of a recording's pictures before they are tracked: enlarged (cubic), then blurred as by a soft
// lens, then noise added; their camera with them.
struct PictureChange {
  double enlarged = 1;
  double blur_px = 0;  // standard deviations, of the enlarged picture's pixels and grey levels
  double noise = 0;
};

// The studio's rows lie far enough apart that a short run sees all of it.
inline constexpr char kStudio[] = "sim:studio?row_deg=4";

// `recording`: a simulated camera (`frames` at 15 a second, its scene and hand by the options' seed) or the
// name of a folder of the test data, its first `frames`.
struct TrackedCase {
  std::string recording;
  TrackerOptions options;
  int frames = 0;
  int width = 640;  // that the simulator draws at
  PictureChange change{};
  int every = 1;  // frame, from `first` on; the others are not seen
  int first = 0;
  double focal_factor = 1;  // of the focal length that the tracker is given over the right one
  // The row of a table that its run belongs to.
  std::string panel = {}, series = {}, name = {};
  bool is_default = false;
};
// The runs of a row: three, of the simulator on as many seeds; of a recording, where a seed hardly changes
// anything, with ten features more and fewer; of every Nth frame of one, begun at other frames.
std::vector<TrackedCase> Repeated(const TrackedCase& one, const Effort& effort);
// On as many threads as there are processors, in order. A recording is read once for all of its runs.
std::vector<TrackedRun> TrackRuns(const std::vector<TrackedCase>& cases);

// To the rows of the cases.
void AddRuns(const std::vector<TrackedCase>& cases, const std::vector<TrackedRun>& runs,
             double TrackedRun::*cost, double TrackedRun::*error, Table& table);

// Where a run of every Nth frame begins, so that it meets the kitchen's reference, which has a pose in every
// twelfth frame; another place for each of some runs.
int StartOf(int run, int every);

// Whether the recording is to be had.
bool HasRecording(const std::string& recording);
bool IsSimulated(const std::string& recording);
// How charts call it.
std::string NameOf(const std::string& recording);

}  // namespace ulf::test
