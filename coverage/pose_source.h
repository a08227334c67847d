// Where a capture's poses come from: the tracker, or what a frame knows already (the simulator's truth, a
// replayed light field, a robot). One small interface, so that the session does not care.
#pragma once

#include <memory>
#include <optional>
#include <span>
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
  virtual std::vector<VisiblePoint> VisiblePoints() const = 0;
  virtual std::vector<ScenePoint> Points() const = 0;
  virtual bool SeedMap(
      std::span<const SeedView> views) = 0;  // before the first Step(), to go on with a capture
  virtual void Finish() = 0;
};

std::unique_ptr<PoseSource> MakeTrackerSource(const CameraModel& camera, const TrackerOptions& options);

// Poses as the frames bring them; a frame without one is a lost one. With a subject, the image's motion is
// judged at its distance; without one not at all.
std::unique_ptr<PoseSource> MakeKnownPoseSource(const CameraModel& camera,
                                                const std::optional<Subject>& subject = {});

}  // namespace ulf
