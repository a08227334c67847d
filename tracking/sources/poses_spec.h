// The interface of all sources of frames' poses: the tracker, the frame's own pose (the simulator's truth, a
// replayed light field), markers, or a system outside the camera. `ulf track` and `ulf
// capture` know only this interface. Poses are cam_from_world; see Track (tracker.h) for frames and units.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/geometry/camera_model.h"
#include "core/image/frame.h"
#include "core/light_field/light_field.h"
#include "tracking/sources/marker_spec.h"
#include "tracking/sources/pose_stream.h"
#include "tracking/tracker/tracker.h"

namespace ulf::tracking {

class PoseSource {
 public:
  virtual ~PoseSource() = default;
  virtual Track Step(const Frame& frame) = 0;
  // Finds where another camera took a photograph (a tethered camera's full resolution), about at `near`; none
  // when the pose is not certain. Does not change the frames' poses.
  virtual std::optional<Track> Locate(const Frame& photograph, const CameraModel& camera,
                                      const std::optional<Rigid3>& near) const = 0;
  // The pose that an anchor means now; poses move when the map is adjusted.
  virtual Rigid3 PoseOf(const Anchored& anchor) const = 0;
  // The pose that a frame's track means now; none where it had none.
  virtual std::optional<Rigid3> PoseNow(const Track& track) const {
    return track.anchor ? PoseOf(*track.anchor) : track.cam_from_world;
  }
  // The map in whose world PoseNow() lies: Track::map_id, after parts of the map were joined since.
  virtual int MapNow(const Track& track) const { return track.map_id; }
  virtual std::vector<VisiblePoint> VisiblePoints() const { return {}; }
  virtual std::vector<ExpectedPoint> ExpectedPoints() const { return {}; }
  // The image of that track was recorded as a view: Points() lists what it shows. Call it before the next
  // Step().
  virtual void NoteView(int /*view_id*/, const Track& /*track*/) {}
  virtual std::vector<ScenePoint> Points() const { return {}; }
  // Called before the first Step() when a capture goes on.
  virtual bool SeedMap(std::span<const SeedView> /*views*/, const SeedProgress& /*progress*/) { return true; }
  // As Tracker's; without a map they do nothing.
  virtual void SaveMap(const std::filesystem::path& /*file*/, std::uint64_t /*key*/) const {}
  virtual std::string RestoreMap(const std::filesystem::path& /*file*/, std::uint64_t /*key*/) {
    return "these poses need no map";
  }
  virtual void Finish() {}
  virtual TrackerStatistics Statistics() const { return {}; }  // of the map; zeros without a map
  // How many poses came from outside, and how many frames got one: names and counts, in the order to show.
  virtual std::vector<std::pair<std::string, std::uint64_t>> Counts() const { return {}; }
  // Whether the world's unit is the metre; it may become so while tracking.
  virtual bool IsMetric() const { return false; }
};

// Remembers whether a source has given a pose, and completes the state of its tracks.
class PoseContinuity {
 public:
  // Without a pose the state is initializing before the first one, then lost. Skipped frames change nothing.
  void Complete(Track& track) {
    const bool posed = track.cam_from_world.has_value();
    if (!posed) track.state = began_ ? TrackState::kLost : TrackState::kInitializing;
    track.relocalized = posed && began_ && lost_;
    if (!track.skipped) lost_ = !posed;
    began_ = began_ || posed;
  }

 private:
  bool began_ = false, lost_ = false;
};

std::unique_ptr<PoseSource> MakeTrackerSource(const CameraModel& camera, const TrackerOptions& options);

// The frames' own poses; a frame without one is lost. The image's motion is measured at the subject's
// distance, and is unknown without a subject.
std::unique_ptr<PoseSource> MakeKnownPoseSource(const CameraModel& camera,
                                                const std::optional<Subject>& subject = {},
                                                bool metric = false);

// By markers alone; or by markers and a map of features, which gets its frame and its unit from the markers
// and gives poses where they are out of sight.
std::unique_ptr<PoseSource> MakeMarkerSource(const CameraModel& camera, const MarkerSpec& spec);
std::unique_ptr<PoseSource> MakeFeaturesAndMarkersSource(const CameraModel& camera, const MarkerSpec& spec,
                                                         const TrackerOptions& options);

// From a TUM file: interpolates between poses at the frames' device times.
struct TrajectoryOptions {
  double offset_s = 0;     // added to a frame's time before it is looked up
  double max_gap_s = 0.2;  // between poses farther apart there is none
  Rigid3 tool_from_cam;    // where the camera sits on what the poses are of
};
std::unique_ptr<PoseSource> MakeTrajectorySource(const CameraModel& camera, const std::filesystem::path& file,
                                                 const TrajectoryOptions& options,
                                                 const std::optional<Subject>& subject = {});

// From a program that sends them (pose_stream.h).
std::unique_ptr<PoseSource> MakeStreamSource(const CameraModel& camera, std::unique_ptr<PoseStream> stream,
                                             const Rigid3& tool_from_cam,
                                             const std::optional<Subject>& subject = {});

struct PoseSourceOptions {
  TrackerOptions tracker = {};
  std::optional<Subject> subject = {};  // of poses that are given
  bool metric = false;                  // known poses are in metres
  std::function<bool()> stop = {};      // asked while waiting for poses from outside
};

// The option `--poses` of `ulf track` and `ulf capture`.
inline constexpr const char* kPosesHelp =
    "Where poses come from: features (tracked), markers:SPEC, features+markers:SPEC, known (by the device), "
    "tum:FILE, tcp:PORT (docs/tracking.md)";

// The same as --help lists values.
inline constexpr const char* kPosesValues =
    "features,markers:SPEC,features+markers:SPEC,known,tum:FILE,tcp:PORT";

class PosesSpec {
 public:
  // Throws UsageError that names the accepted forms.
  static PosesSpec Parse(const std::string& text);
  const std::string& Text() const { return text_; }
  // The poses come with the frames or from outside, not from the images: there are no tracked points.
  bool AreGiven() const { return kind_ == Kind::kKnown || kind_ == Kind::kFile || kind_ == Kind::kStream; }
  bool ComeWithFrames() const { return kind_ == Kind::kKnown; }
  // The world is known before the first frame, so the user can name a subject in it.
  bool HaveAWorld() const { return kind_ != Kind::kFeatures; }
  // The world is the marker that is seen first, which differs between sessions.
  bool ChoosesWorldAnew() const {
    return (kind_ == Kind::kMarkers || kind_ == Kind::kBoth) && markers_.kind == MarkerSpec::Kind::kSeveral;
  }
  // A lens is found from a map of features alone (LensUse::kRefine). Throws UsageError where these poses have more
  // than that, or none.
  void RequireFor(LensUse lens) const;
  // The source builds a map of features, which a resumed capture must restore.
  bool UseFeatures() const { return kind_ == Kind::kFeatures || kind_ == Kind::kBoth; }
  // Of markers:SPEC and features+markers:SPEC.
  const MarkerSpec& markers() const { return markers_; }
  std::unique_ptr<PoseSource> Open(const CameraModel& camera, const PoseSourceOptions& options) const;

 private:
  enum class Kind { kFeatures, kKnown, kMarkers, kBoth, kFile, kStream };
  std::string text_ = "features";
  Kind kind_ = Kind::kFeatures;
  MarkerSpec markers_;
  std::filesystem::path file_;
  TrajectoryOptions trajectory_;
  PoseStreamOptions stream_;
};

}  // namespace ulf::tracking
