// The tracker computes camera poses from frames, in real time, without markers.
//
// The world is the first keyframe's camera until MoveWorld(). Its unit is the median depth of the first
// two-view map, so that the scale is arbitrary. Poses are cam_from_world, image quantities pixels of the
// images as they come. Larger images are reduced to a working size inside (working_size.h).
//
// Method: features with ORB descriptors are spread over the image. Two views start the map (homography or
// essential matrix, and a parallax test; rotation alone never starts it). Every frame is matched against the
// map under a motion model, and its pose is refined robustly. Keyframes go to the mapper, which triangulates,
// merges and adjusts in a second thread. Descriptors, P3P and guided verification find a lost camera again.
// (Klein and Murray 2007 for the two threads; Mur-Artal, Montiel and Tardos 2015 for one descriptor through
// all stages; Forster et al. 2014 for aligning patches.)
#pragma once

#include <memory>
#include <optional>

#include "core/frames/frame.h"
#include "core/geometry/camera_model.h"
#include "core/geometry/similarity3.h"
#include "core/image/image.h"
#include "core/light_field/light_field.h"
#include "tracking/map/anchored.h"
#include "tracking/map/fiducial_observation.h"
#include "tracking/tracker/pose_source.h"
#include "tracking/tracker/tracker_options.h"

namespace ulf::tracking {

struct TrackerCore;

class Tracker final : public PoseSource {
 public:
  // Throws Error if the camera's intrinsics are out of range.
  explicit Tracker(const CameraModel& camera, const TrackerOptions& options = {});
  ~Tracker() override;
  Tracker(Tracker&&) noexcept;
  Tracker& operator=(Tracker&&) noexcept;

  Track Step(const Frame& frame) override { return Step(frame, std::nullopt); }
  // `fiducials` is what the frame shows of a given world (a board's), in pixels of the frame. Keyframes keep
  // it. In a map moved into that world it takes part, and a lost tracker searches at its pose.
  Track Step(const Frame& frame, const std::optional<FiducialObservation>& fiducials);

  std::optional<Track> Locate(const Frame& photograph, const CameraModel& camera,
                              const std::optional<Rigid3>& near) const override {
    return Locate(photograph.image, camera, near);
  }
  // Throws Error if the photograph's size is not its camera's. Returns none without a map or with a moved
  // zoom.
  std::optional<Track> Locate(const Image& photograph, const CameraModel& camera,
                              const std::optional<Rigid3>& near = {},
                              const std::optional<FiducialObservation>& fiducials = {}) const;

  // Moves the map into the world in which fiducials are given, for as long as the map lives. Anchors,
  // VisiblePoints() and the last pose follow.
  void MoveWorld(const Similarity3& given_from_world);
  bool WorldIsGiven() const;

  void Finish() override;

  // An anchor of a discarded map (Track::map_id) keeps its pose in that map's world.
  Rigid3 PoseOf(const Anchored& anchor) const override;
  // Returns PoseOf() the track's anchor or, if the lens was replaced since, a pose solved again from the
  // points that the frame showed. It lies in the world of MapNow().
  std::optional<Rigid3> PoseNow(const Track& track) const override;
  int MapNow(const Track& track) const override;

  std::vector<VisiblePoint> VisiblePoints() const override;
  std::vector<ExpectedPoint> ExpectedPoints() const override;
  void NoteView(int view_id, const Track& track) override;
  std::vector<ScenePoint> Points() const override;

  // A tracker with a seeded or restored map is lost until a frame sees the map.
  bool SeedMap(std::span<const SeedView> views, const SeedProgress& progress = {}) override;
  void SaveMap(const std::filesystem::path& file, std::uint64_t key) const override;
  std::optional<MapRefusal> RestoreMap(const std::filesystem::path& file, std::uint64_t key) override;

  TrackerStatistics Statistics() const override;
  const CameraModel& camera() const;

 private:
  std::unique_ptr<TrackerCore> core_;
};

}  // namespace ulf::tracking
