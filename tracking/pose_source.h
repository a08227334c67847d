// Where poses come from: the tracker, what a frame knows already (the simulator's truth, a replayed light
// field), or something beside the camera. One small interface, so that whoever needs a pose for every frame
// (`ulf track`, `ulf capture`) does not care.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acquisition/camera_model.h"
#include "acquisition/frame.h"
#include "acquisition/light_field.h"
#include "tracking/tracker.h"

namespace ulf {

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
  virtual std::vector<ScenePoint> Points() const { return {}; }
  // Before the first Step(), to go on with a capture.
  virtual bool SeedMap(std::span<const SeedView> /*views*/) { return true; }
  virtual void Finish() {}
  virtual TrackerStatistics Statistics() const { return {}; }  // of the map; zero where there is none
  // Whether the world's unit is the metre; it may become so while tracking.
  virtual bool IsMetric() const { return false; }
};

std::unique_ptr<PoseSource> MakeTrackerSource(const CameraModel& camera, const TrackerOptions& options);

// Poses as the frames bring them; a frame without one is a lost one. With a subject, the image's motion is
// judged at its distance; without one not at all.
std::unique_ptr<PoseSource> MakeKnownPoseSource(const CameraModel& camera,
                                                const std::optional<Subject>& subject = {},
                                                bool metric = false);

struct PoseSourceOptions {
  TrackerOptions tracker = {};
  std::optional<Subject> subject = {};  // of poses that are known
  bool metric = false;             // known poses are in metres
};

// As `--poses` says it, on the command line of `ulf track` and `ulf capture`.
inline constexpr const char* kPosesHelp = "Where poses come from: features (tracked), known (by the device)";

class PosesSpec {
 public:
  // Throws UsageError that names the forms.
  static PosesSpec Parse(const std::string& text);
  const std::string& Text() const { return text_; }
  // Not found in the images: given with the frames or from outside; there are no tracked points.
  bool AreGiven() const { return kind_ == Kind::kKnown; }
  bool ComeWithFrames() const { return kind_ == Kind::kKnown; }
  std::unique_ptr<PoseSource> Open(const CameraModel& camera, const PoseSourceOptions& options) const;

 private:
  enum class Kind { kFeatures, kKnown };
  std::string text_ = "features";
  Kind kind_ = Kind::kFeatures;
};

}  // namespace ulf
