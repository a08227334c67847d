#include "tracking/tracker/tracker.h"

#include <algorithm>
#include <cmath>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "tracking/map/map_file.h"
#include "tracking/tracker/tracker_core.h"

namespace ulf::tracking {

std::optional<double> Track::PictureSigma() const {
  return center_sigma ? std::optional(std::hypot(*center_sigma, rows_sigma)) : std::nullopt;
}

Tracker::Tracker(const CameraModel& camera, const TrackerOptions& options) {
  camera.Validate("tracker");
  state_ = std::make_unique<State>(camera, options);
}
Tracker::~Tracker() = default;
Tracker::Tracker(Tracker&&) noexcept = default;
Tracker& Tracker::operator=(Tracker&&) noexcept = default;

Track Tracker::Step(const Frame& frame, const std::optional<FiducialObservation>& fiducials) {
  Track track = state_->Step(frame, fiducials);
  track.speed_px = state_->size.ToOriginal(track.speed_px);
  return track;
}

void Tracker::MoveWorld(const Similarity3& given_from_world) { state_->MoveWorld(given_from_world); }

bool Tracker::WorldIsGiven() const { return state_->shared.world_given; }

std::optional<Track> Tracker::Locate(const Image& photograph, const CameraModel& camera,
                                     const std::optional<Rigid3>& near,
                                     const std::optional<FiducialObservation>& fiducials) const {
  camera.Validate("photograph");
  RequireSize("a photograph", photograph.pixels.size(), camera);
  return state_->LocatePhotograph(photograph, camera, near, fiducials);
}

void Tracker::Finish() {
  State& state = *state_;
  state.mapper.Rest();
  state.mapper.AdjustAll();
  if (state.options.lens == LensUse::kFixed) return;
  if (state.zoom.IsMoved()) state.FollowWith(state.size.working());
  const auto check = [&] {
    state.calibration =
        state.InOriginalPixels(CheckCalibration(state.size.working(), state.shared.ReadByOwner()));
  };
  check();
  // A lens that was once replaced is no calibration: the whole map knows it better than the part did.
  const bool replace =
      state.refined_lens || state.options.lens_is_guess || (state.calibration && state.calibration->Wrong());
  if (state.options.lens != LensUse::kRefine || !replace || !state.RefineLens()) return;
  state.mapper.Rest();
  state.mapper.AdjustAll();
  check();
}

Rigid3 Tracker::PoseOf(const Anchored& anchor) const {
  const MapLock lock(state_->shared);
  return state_->shared.map.PoseOf(anchor);
}

std::optional<Rigid3> Tracker::PoseNow(const Track& track) const {
  if (!track.anchor) return track.cam_from_world;
  const Rigid3 anchored = PoseOf(*track.anchor);
  // Where rows roll, a frame's points are not where one pose shows them.
  if (track.lens_revision == state_->lens_revision || !track.seen || state_->rows.rolls()) return anchored;
  std::vector<PointObservation> seen;
  {
    const MapLock lock(state_->shared);
    const Map& map = state_->shared.map;
    const int part = map.keyframe(track.anchor->keyframe_id).part;
    for (const MapObservation& o : *track.seen)
      if (const int point = map.Resolve(o.point); point >= 0 && map.point(point).part == part)
        seen.push_back({map.point(point).position, o.img, o.sigma_px});
  }
  // A point's number may have been given to another point since.
  constexpr double kFewest = 0.6;  // share of the points that must agree. Guessed
  const double fewest = std::max<double>(state_->options.locator.min_matches,
                                         kFewest * static_cast<double>(track.seen->size()));
  const auto solved = RefinePose(state_->size.original(), seen, anchored);
  return solved && solved->inliers >= fewest ? solved->cam_from_world : anchored;
}

int Tracker::MapNow(const Track& track) const {
  if (!track.anchor) return track.map_id;
  const MapLock lock(state_->shared);
  return state_->shared.map.keyframe(track.anchor->keyframe_id).part;
}

std::vector<VisiblePoint> Tracker::VisiblePoints() const {
  if (state_->IsApart()) return {};
  std::vector<VisiblePoint> visible = state_->last.visible;
  for (VisiblePoint& point : visible) point.img = state_->size.ToOriginal(point.img);
  return visible;
}

std::vector<ExpectedPoint> Tracker::ExpectedPoints() const {
  return state_->IsApart() ? std::vector<ExpectedPoint>() : state_->last.expected;
}

std::vector<ScenePoint> Tracker::Points() const {
  const MapLock lock(state_->shared);
  std::vector<ScenePoint> points;
  for (const MapPoint& point : state_->shared.map.points())
    if (point.alive && point.part == state_->shared.map.main_part())
      points.push_back({point.position, point.rgb, 0, point.views});
  return points;
}

void Tracker::NoteView(int view_id, const Track& track) {
  if (!track.seen) return;
  state_->mapper.NoteView(view_id, *track.seen);
}

bool Tracker::SeedMap(std::span<const SeedView> views, const SeedProgress& progress) {
  State& state = *state_;
  state.mapper.Drain();
  if (views.size() < 2) return false;
  // Builds the map in another tracker, so that a failure leaves this one as it was.
  auto seeded = std::make_unique<State>(state.size.original(), state.options);
  for (const SeedView& view : views) {
    RequireSize("a recorded view", view.image.pixels.size(), state.size.original(),
                "resume with the same camera");
    NewKeyframe offered;
    auto pyramid =
        std::make_shared<const Pyramid>(BuildPyramid(state.size.Reduced(GrayForTracking(view.image))));
    offered.keyframe.cam_from_world = view.cam_from_world;
    offered.keyframe.features =
        std::make_shared<const FeatureSet>(seeded->extractor.Extract(*pyramid, 2 * state.options.features));
    offered.keyframe.pyramid = std::move(pyramid);
    offered.keyframe.color = state.size.Reduced(Srgb8(view.image));
    seeded->mapper.AddSeed(std::move(offered));
    if (progress) progress(static_cast<std::size_t>(&view - views.data()) + 1);
  }
  if (!seeded->mapper.FinishSeeds(state.options.min_seed_points)) return false;
  seeded->state = TrackState::kLost;
  seeded->frames_tracked = state.options.proven_frames;  // a given map is proven
  seeded->readout_search.MapIsGiven();
  state_ = std::move(seeded);
  return true;
}

void Tracker::SaveMap(const std::filesystem::path& file, std::uint64_t key) const {
  state_->mapper.Drain();
  const Map& map = state_->shared.ReadByOwner();
  if (map.LivingPoints() == 0) return;
  WriteFileAtomically(file, MapToBytes(map, state_->size.KeyAtWorkingSize(key)));
}

std::string Tracker::RestoreMap(const std::filesystem::path& file, std::uint64_t key) {
  State& state = *state_;
  state.mapper.Drain();
  Map map(state.camera);
  try {
    const std::string problem =
        MapFromBytes(ReadWholeFile(file), state.size.KeyAtWorkingSize(key), state.camera, map);
    if (!problem.empty()) return problem;
  } catch (const Error& error) {
    return error.what();
  }
  auto restored = std::make_unique<State>(state.size.original(), state.options, std::move(map));
  restored->state = TrackState::kLost;
  restored->frames_tracked = state.options.proven_frames;
  restored->readout_search.MapIsGiven();
  state_ = std::move(restored);
  return {};
}

TrackerStatistics Tracker::Statistics() const {
  const MapLock lock(state_->shared);
  return {state_->shared.map.LivingKeyframes(),
          state_->shared.map.LivingPoints(),
          state_->keyframes_left_out,
          state_->shared.loops,
          state_->shared.joins,
          static_cast<int>(state_->shared.map.Parts().size()),
          std::chrono::duration<double>(state_->shared.longest_wait).count(),
          state_->calibration ? state_->calibration : state_->InOriginalPixels(state_->shared.wrong_lens),
          state_->RefinedLensInOriginalPixels(),
          state_->Rolling(),
          static_cast<int>(state_->shared.map.keyframes().size()),
          static_cast<int>(state_->shared.map.points().size()),
          state_->map_start,
          {state_->camera.width, state_->camera.height, state_->size.original().width,
           state_->size.original().height}};
}

const CameraModel& Tracker::camera() const { return state_->size.original(); }

}  // namespace ulf::tracking
