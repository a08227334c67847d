// Reports a sequence that `ulf track` tracked: as text, as JSON, and as a table of its frames.
//
// Errors are in the truth's units, which are taken as metres. Maps (Track::map_id) that were discarded, and
// parts of the map that were not joined to the rest, have worlds of their own: their poses are written, but
// only those of the last map that gave live poses are compared with the truth.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/base/model_choice.h"
#include "core/geometry/trajectory.h"
#include "tracking/tracker/tracker.h"

namespace ulf::commands {

struct TrackedFrame {
  double time_s = 0;  // of the device's clock
  tracking::Track track;
  double wall_ms = 0;        // time that tracking the frame took
  double seen_distance = 0;  // median of the found map points, world units; 0: unknown
  // The pose after the last adjustment, and the map in whose world it lies. A frame that was followed in a
  // separate part of the map may have one although it has no live pose.
  std::optional<Rigid3> final_cam_from_world = {};
  int final_map = 0;
  bool HasPose() const { return track.cam_from_world.has_value(); }
};

// The pictures' poses (not those of the middle row) in one map.
struct GivenPoses {
  std::vector<TimedPose> live, final;  // as tracked; after the last adjustment
};

struct TrackRun {
  FrameSource source = FrameSource::kCamera;
  bool deterministic = false;  // frames' times contain mapping
  std::vector<TrackedFrame> frames;
  std::vector<double> orb_cpu_ms;  // of cv::ORB with 1000 features on some frames (--benchmark)
  tracking::TrackerStatistics map;
  std::optional<double>
      wrong_lens_after_s;  // from the first pose on; none if the map never contradicted the lens
  std::string failure;     // why and where the run ended early; empty if it did not
  std::vector<std::pair<std::string, std::uint64_t>> from_outside;  // PoseSource::Counts()
};

int LivePoses(const TrackRun& run);  // number of frames with a live pose
// Returns the poses of each map with poses, in that map's world. The last map that gave live poses comes
// last, the others in their order.
std::vector<GivenPoses> PosesOfMaps(const TrackRun& run);
// Returns the poses of the last map that gave live poses; empty if none did.
GivenPoses LastMapPoses(const TrackRun& run);

// Numbers of live poses. Wrong ones are off by more than 3 % of the distance of the seen points or 2 degrees,
// after one alignment of the run; `unsaid` counts the wrong ones whose quality is one half or more.
struct WrongPoses {
  int compared = 0, wrong = 0, unsaid = 0;
};

// The errors of a run against the truth; none if CompareTrajectories() returns none.
struct TrackErrors {
  std::string truth_name;
  std::vector<TimedPose> truth;
  int earlier_maps = 0;  // number of live poses in other maps, which are not compared
  std::optional<TrajectoryError> live = {}, final = {};
  WrongPoses wrong = {};
  // The errors of poses when the middle row was read; none without a compensated rolling shutter.
  std::optional<TrajectoryError> middle_row_live = {}, middle_row_final = {};
};
inline constexpr double kRelativeErrorStep_s = 1;  // of the relative pose error (RPE)

// Pairs poses by time, within half a frame and 20 ms.
TrackErrors CompareWithTruth(const TrackRun& run, std::vector<TimedPose> truth, std::string truth_name);

// `errors` may be null, here and below: then nothing is compared.
nlohmann::ordered_json ToJson(const TrackRun& run, const TrackErrors* errors);
std::string ToText(const TrackRun& run, const TrackErrors* errors);
// Returns CSV with a line for each frame. Errors are distances of the centres in the truth's units, or empty.
std::string ToCsv(const TrackRun& run, const TrackErrors* errors);
// Explains from which two-view model the map started, and how many keyframes and points it keeps.
std::vector<ModelChoice> Explained(const TrackRun& run);

}  // namespace ulf::commands
