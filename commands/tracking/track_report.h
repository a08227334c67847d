// Reports a tracked sequence for `ulf track`: as text, as JSON, and as a table of its frames.
//
// Errors are in the truth's units, which are metres in TUM files. A map that was discarded within its first
// frames, and a part of the map that was not joined to the rest (Track::map_id), are other worlds: their
// poses are in the files, but only those of the last map that gave live poses are compared.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/base/model_choice.h"
#include "core/geometry/trajectory.h"
#include "tracking/tracker/tracker.h"

namespace ulf::commands {

// The live outcome of one frame.
struct TrackedFrame {
  double time_s = 0;
  tracking::Track track;
  double wall_ms = 0;
  double seen_distance = 0;  // median of the found map points, world units; 0: unknown
  // The pose after the last adjustment and the map in whose world it lies; a frame that was tracked in a
  // separate part of the map has one without a live pose.
  std::optional<Rigid3> final_cam_from_world = {};
  int final_map = 0;
  bool HasPose() const { return track.cam_from_world.has_value(); }
};

struct GivenPoses {
  std::vector<TimedPose> live, final;  // as tracked; after the last adjustment
};

struct TrackRun {
  FrameSource source = FrameSource::kCamera;
  bool deterministic = false;  // mapping ran inside the frames
  std::vector<TrackedFrame> frames;
  std::vector<double> orb_cpu_ms;  // cv::ORB with 1000 features, on some of the frames
  tracking::TrackerStatistics map;
  std::optional<double>
      wrong_lens_after_s;  // from the first pose on; none if the map never contradicted the lens
  std::string failure;     // why and where the run ended early; empty if it did not
  std::vector<std::pair<std::string, std::uint64_t>> from_outside;  // PoseSource::Counts()
};

int LivePoses(const TrackRun& run);
// Returns the poses of each map: each lies in a world of its own. Maps without poses are left out. The last
// map that gave live poses comes last, the others in their order.
std::vector<GivenPoses> PosesOfMaps(const TrackRun& run);
// Returns the poses of the last map that gave live poses; empty if none did.
GivenPoses LastMapPoses(const TrackRun& run);

// Counts of live poses: wrong ones are off by 3 % of the distance of the seen points or by 2 degrees, after
// one alignment of the run; unsaid ones are wrong with a quality of one half or more.
struct WrongPoses {
  int compared = 0, wrong = 0, unsaid = 0;
};

// The errors of a run against the truth.
struct TrackErrors {
  std::string truth_name;
  std::vector<TimedPose> truth;
  int earlier_maps = 0;  // poses of discarded maps, which are not compared
  std::optional<TrajectoryError> live = {}, final = {};
  WrongPoses wrong = {};
  std::optional<TrajectoryError> middle_row_live = {}, middle_row_final = {};
};
inline constexpr double kRelativeErrorStep_s = 1;

TrackErrors CompareWithTruth(const TrackRun& run, std::vector<TimedPose> truth, std::string truth_name);

nlohmann::ordered_json ToJson(const TrackRun& run, const TrackErrors* errors);
std::string ToText(const TrackRun& run, const TrackErrors* errors);
// Returns CSV with a line for each frame. Errors are distances of the centres in the truth's units, empty if
// nothing is compared.
std::string ToCsv(const TrackRun& run, const TrackErrors* errors);
// Explains the model from which the map started, and what it keeps.
std::vector<ModelChoice> Explained(const TrackRun& run);

}  // namespace ulf::commands
