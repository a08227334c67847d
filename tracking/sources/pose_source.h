// Where poses come from: the tracker, what a frame knows already (the simulator's truth, a replayed light
// field), markers, or something beside the camera. One small interface, so that whoever needs a pose for
// every frame
// (`ulf track`, `ulf capture`) does not care.
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
  // Where a photograph was taken that another camera made (a tethered camera's full resolution), `near` here
  // or so; none when unsure. Frames' poses are not touched.
  virtual std::optional<Track> Locate(const Frame& photograph, const CameraModel& camera,
                                      const std::optional<Rigid3>& near) const = 0;
  // What an anchor given earlier means now; poses move when the map is adjusted.
  virtual Rigid3 PoseOf(const Anchored& anchor) const = 0;
  virtual std::vector<VisiblePoint> VisiblePoints() const { return {}; }
  virtual std::vector<ExpectedPoint> ExpectedPoints() const { return {}; }
  // The image of that track was recorded as a view, before the next Step(): Points() know it then.
  virtual void NoteView(int /*view_id*/, const Track& /*track*/) {}
  virtual std::vector<ScenePoint> Points() const { return {}; }
  // Before the first Step(), to go on with a capture.
  virtual bool SeedMap(std::span<const SeedView> /*views*/) { return true; }
  // As Tracker's; nothing where there is no map.
  virtual void SaveMap(const std::filesystem::path& /*file*/, std::uint64_t /*key*/) const {}
  virtual std::string RestoreMap(const std::filesystem::path& /*file*/, std::uint64_t /*key*/) {
    return "these poses need no map";
  }
  virtual void Finish() {}
  virtual TrackerStatistics Statistics() const { return {}; }  // of the map; zero where there is none
  // What became of poses from outside, by name, in the order to be shown.
  virtual std::vector<std::pair<std::string, std::uint64_t>> Counts() const { return {}; }
  // Whether the world's unit is the metre; it may become so while tracking.
  virtual bool IsMetric() const { return false; }
};

std::unique_ptr<PoseSource> MakeTrackerSource(const CameraModel& camera, const TrackerOptions& options);

// Poses as the frames bring them; a frame without one is a lost one. With a subject, the image's motion is
// judged at its distance; without one not at all.
std::unique_ptr<PoseSource> MakeKnownPoseSource(const CameraModel& camera,
                                                const std::optional<Subject>& subject = {},
                                                bool metric = false);

// By markers alone, and with a map of features that the markers begin, give its metre, and help out of sight.
std::unique_ptr<PoseSource> MakeMarkerSource(const CameraModel& camera, const MarkerSpec& spec);
std::unique_ptr<PoseSource> MakeFeaturesAndMarkersSource(const CameraModel& camera, const MarkerSpec& spec,
                                                         const TrackerOptions& options);

// From a TUM file, by the frames' device times; between poses it interpolates.
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

// As `--poses` says it, on the command line of `ulf track` and `ulf capture`.
inline constexpr const char* kPosesHelp =
    "Where poses come from: features (tracked), markers:SPEC, features+markers:SPEC, known (by the device), "
    "tum:FILE, tcp:PORT (docs/tracking.md)";

class PosesSpec {
 public:
  // Throws UsageError that names the forms.
  static PosesSpec Parse(const std::string& text);
  const std::string& Text() const { return text_; }
  // Not found in the images: given with the frames or from outside; there are no tracked points.
  bool AreGiven() const { return kind_ == Kind::kKnown || kind_ == Kind::kFile || kind_ == Kind::kStream; }
  bool ComeWithFrames() const { return kind_ == Kind::kKnown; }
  // The world is known before the first frame: a subject can be named in it.
  bool HaveAWorld() const { return kind_ != Kind::kFeatures; }
  // The world is whichever marker is seen first: another session's is another one.
  bool ChoosesWorldAnew() const {
    return (kind_ == Kind::kMarkers || kind_ == Kind::kBoth) && markers_.kind == MarkerSpec::Kind::kSeveral;
  }
  // A map of features is built, which a capture that goes on must be given.
  bool UseFeatures() const { return kind_ == Kind::kFeatures || kind_ == Kind::kBoth; }
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
