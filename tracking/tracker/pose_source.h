// Defines the interface of all sources of frames' poses: the tracker (tracker.h), the frame's own pose (the
// simulator's truth, a replayed light field), markers, or a system outside the camera (tracking/sources/).
// `ulf track` and `ulf capture` use this interface alone, from one thread.
//
// Poses are cam_from_world. A live pose is the best known at its frame; a map's adjustments may move it. To
// keep a pose, keep its anchor (a keyframe and the rigid transform from it) and ask PoseOf() again at the
// end.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/frames/frame.h"
#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "core/light_field/light_field.h"
#include "tracking/estimation/calibration_check.h"
#include "tracking/map/anchored.h"
#include "tracking/tracker/readout.h"
#include "tracking/tracker/start_progress.h"
#include "tracking/tracker/track.h"

namespace ulf::tracking {

// A recorded view with a known pose, from which a map is made.
struct SeedView {
  Image image;
  Rigid3 cam_from_world;
};
// Called with the number of views that are in the map.
using SeedProgress = std::function<void(std::size_t views)>;

// Size of the images as they are tracked, and as they come, px. Zero: the source tracks no images.
struct TrackedSize {
  int width = 0, height = 0;
  int original_width = 0, original_height = 0;
};

// Counts and findings about a source's map; a source without a map has zeros.
struct TrackerStatistics {
  int keyframes = 0;  // that the map has now, as the points
  int map_points = 0;
  int keyframes_left_out = 0;  // frames that did not become keyframes because the mapper was behind
  int loops = 0;               // closed loops
  int parts_joined = 0;        // parts of the map that were joined to another
  int parts = 0;               // parts of the map that are apart from each other
  double longest_wait_s = 0;   // of another thread until the mapper released the map
  // Set after Finish() if the map is large enough; before that, as soon as the map contradicts the lens.
  std::optional<CalibrationCheck> calibration = {};
  // The lens that replaced the given one, for the images as they come.
  std::optional<RefinedLens> refined_lens = {};
  std::optional<Readout> rolling_shutter = {};  // none: global as far as is known
  int keyframes_made = 0, points_made = 0;      // with those that were removed
  std::optional<MapStart> start = {};           // of the last map; none: no start, or a seeded map
  TrackedSize size = {};
};

class PoseSource {
 public:
  virtual ~PoseSource() = default;
  // Finds one frame's pose. Frames come in the order of their times. A source that looks at images throws
  // Error if one has another size than the camera.
  virtual Track Step(const Frame& frame) = 0;
  // Finds where another camera took a photograph of the same scene (a tethered camera's full resolution
  // beside its live view). `near` is the expected pose, if known. Returns none if it is not certain.
  virtual std::optional<Track> Locate(const Frame& photograph, const CameraModel& camera,
                                      const std::optional<Rigid3>& near) const = 0;
  // Returns the pose that an anchor means now. Every anchor stays valid.
  virtual Rigid3 PoseOf(const Anchored& anchor) const = 0;
  // Returns the pose that a frame's track means now; none if the frame has none.
  virtual std::optional<Rigid3> PoseNow(const Track& track) const {
    return track.anchor ? PoseOf(*track.anchor) : track.cam_from_world;
  }
  // Returns the map in whose world PoseNow() lies: Track::map_id, after parts of the map were joined since.
  virtual int MapNow(const Track& track) const { return track.map_id; }
  // Returns the points that support the last frame's pose; none without a pose.
  virtual std::vector<VisiblePoint> VisiblePoints() const { return {}; }
  // Returns the map points that the last frame should have shown, found or not.
  virtual std::vector<ExpectedPoint> ExpectedPoints() const { return {}; }
  // Notes that the image of `track` was recorded as a view, so that Points() lists what it shows. Call it
  // before the next Step().
  virtual void NoteView(int /*view_id*/, const Track& /*track*/) {}
  // Returns all points of the map's main part, with their colours and the recorded views that show them.
  virtual std::vector<ScenePoint> Points() const { return {}; }
  // Makes a map from views with known poses (at least two that see the same things), in their world, before
  // the first Step(). Returns false, and changes nothing, if too few points could be triangulated.
  virtual bool SeedMap(std::span<const SeedView> /*views*/, const SeedProgress& /*progress*/ = {}) {
    return true;
  }
  // Writes the map to a file (map_file.h) for another session, whole or not at all; `key` says what it
  // belongs to. Writes nothing while there is no map. Throws as WriteFileAtomically does.
  virtual void SaveMap(const std::filesystem::path& /*file*/, std::uint64_t /*key*/) const {}
  // Reads such a file in place of SeedMap(). If the file does not fit, returns why and changes nothing.
  virtual std::optional<MapRefusal> RestoreMap(const std::filesystem::path& /*file*/, std::uint64_t /*key*/) {
    return MapRefusal{MapProblem::kUnusable, "these poses need no map"};
  }
  // Waits for the mapper, adjusts the whole map and checks the lens against it. Call it after the last frame;
  // frames may follow, after which it must be called again.
  virtual void Finish() {}
  virtual TrackerStatistics Statistics() const { return {}; }
  // Returns figures about poses from outside and the frames that got one: names ("frames_posed") and counts.
  virtual std::vector<std::pair<std::string, std::uint64_t>> Counts() const { return {}; }
  // Returns whether the world's unit is the metre; it may become so while tracking.
  virtual bool IsMetric() const { return false; }
};

}  // namespace ulf::tracking
