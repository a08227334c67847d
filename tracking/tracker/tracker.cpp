#include "tracking/tracker/tracker.h"

#include <algorithm>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "tracking/map/map_adjustment.h"
#include "tracking/map/map_file.h"
#include "tracking/tracker/tracker_core.h"

namespace ulf::tracking {
namespace {

constexpr int kMinSeedPoints = 60;  // of a map that is made from recorded views. Guessed

}  // namespace

Tracker::Tracker(const CameraModel& camera, const TrackerOptions& options) {
  camera.Validate("tracker");
  core_ = std::make_unique<TrackerCore>(camera, options);
}
Tracker::~Tracker() = default;
Tracker::Tracker(Tracker&&) noexcept = default;
Tracker& Tracker::operator=(Tracker&&) noexcept = default;

Track Tracker::Step(const Frame& frame, const std::optional<FiducialObservation>& fiducials) {
  Track track = core_->Step(frame, fiducials);
  track.speed_px = core_->size.ToOriginal(track.speed_px);
  return track;
}

void Tracker::MoveWorld(const Similarity3& given_from_world) { core_->MoveWorld(given_from_world); }

bool Tracker::WorldIsGiven() const { return core_->shared.world_given; }

std::optional<Track> Tracker::Locate(const Image& photograph, const CameraModel& camera,
                                     const std::optional<Rigid3>& near,
                                     const std::optional<FiducialObservation>& fiducials) const {
  camera.Validate("photograph");
  RequireSize("a photograph", photograph.pixels.size(), camera);
  return core_->LocatePhotograph(photograph, camera, near, fiducials);
}

void Tracker::Finish() {
  TrackerCore& core = *core_;
  core.mapper.WaitUntilIdle();
  core.mapper.AdjustAll();
  if (core.options.lens == LensUse::kFixed) return;
  if (core.zoom.IsMoved()) core.TrackWithLens(core.size.working());
  const auto check = [&] {
    core.calibration =
        core.InOriginalPixels(CheckCalibration(core.size.working(), ProblemOf(core.shared.ReadByOwner())));
  };
  check();
  // A lens that was once replaced is no calibration: the whole map knows it better than the part did.
  const bool replace =
      core.refined_lens || core.options.lens_is_guess || (core.calibration && core.calibration->Wrong());
  if (core.options.lens != LensUse::kRefine || !replace || !core.RefineLens()) return;
  core.mapper.WaitUntilIdle();
  core.mapper.AdjustAll();
  check();
}

Rigid3 Tracker::PoseOf(const Anchored& anchor) const {
  const MapLock lock(core_->shared);
  return core_->shared.map.PoseOf(anchor);
}

std::optional<Rigid3> Tracker::PoseNow(const Track& track) const {
  if (!track.anchor) return track.cam_from_world;
  const Rigid3 anchored = PoseOf(*track.anchor);
  // Under a rolling shutter a frame's points are not where one pose projects them.
  if (track.lens_revision == core_->lens_revision || !track.seen || core_->rows.rolls()) return anchored;
  std::vector<PointObservation> seen;
  {
    const MapLock lock(core_->shared);
    const Map& map = core_->shared.map;
    const int part = map.keyframe(track.anchor->keyframe_id).part;
    for (const MapObservation& o : *track.seen)
      if (const int point = map.Resolve(o.point); point >= 0 && map.point(point).part == part)
        seen.push_back({map.point(point).position, o.img, o.sigma_px});
  }
  // A point's number may have been given to another point since.
  constexpr double kFewest = 0.6;  // share of the points that must agree. Guessed
  const double fewest =
      std::max<double>(kMinLocatedMatches, kFewest * static_cast<double>(track.seen->size()));
  const auto solved = RefinePose(core_->size.original(), seen, anchored);
  return solved && solved->inliers >= fewest ? solved->cam_from_world : anchored;
}

int Tracker::MapNow(const Track& track) const {
  if (!track.anchor) return track.map_id;
  const MapLock lock(core_->shared);
  return core_->shared.map.keyframe(track.anchor->keyframe_id).part;
}

std::vector<VisiblePoint> Tracker::VisiblePoints() const {
  if (core_->IsApart()) return {};
  std::vector<VisiblePoint> visible = core_->last.visible;
  for (VisiblePoint& point : visible) point.img = core_->size.ToOriginal(point.img);
  return visible;
}

std::vector<ExpectedPoint> Tracker::ExpectedPoints() const {
  return core_->IsApart() ? std::vector<ExpectedPoint>() : core_->last.expected;
}

std::vector<ScenePoint> Tracker::Points() const {
  const MapLock lock(core_->shared);
  std::vector<ScenePoint> points;
  for (const MapPoint& point : core_->shared.map.points())
    if (point.alive && point.part == core_->shared.map.main_part())
      points.push_back({point.position, point.rgb, 0, point.views});
  return points;
}

void Tracker::NoteView(int view_id, const Track& track) {
  if (!track.seen) return;
  core_->mapper.NoteView(view_id, *track.seen);
}

bool Tracker::SeedMap(std::span<const SeedView> views, const SeedProgress& progress) {
  TrackerCore& core = *core_;
  core.mapper.Drain();
  if (views.size() < 2) return false;
  // Builds the map in another tracker, so that a failure leaves this one as it was.
  auto seeded = std::make_unique<TrackerCore>(core.size.original(), core.options);
  for (const SeedView& view : views) {
    RequireSize("a recorded view", view.image.pixels.size(), core.size.original(),
                "resume with the same camera");
    NewKeyframe offered;
    auto pyramid =
        std::make_shared<const Pyramid>(BuildPyramid(core.size.Reduced(GrayForTracking(view.image))));
    offered.keyframe.cam_from_world = view.cam_from_world;
    offered.keyframe.features =
        std::make_shared<const FeatureSet>(seeded->extractor.Extract(*pyramid, 2 * core.options.features));
    offered.keyframe.pyramid = std::move(pyramid);
    offered.keyframe.color = core.size.Reduced(Srgb8(view.image));
    seeded->mapper.AddSeed(std::move(offered));
    if (progress) progress(static_cast<std::size_t>(&view - views.data()) + 1);
  }
  if (!seeded->mapper.FinishSeeds(kMinSeedPoints)) return false;
  seeded->state = TrackState::kLost;
  seeded->frames_tracked = kProvenFrames;  // a given map is proven
  seeded->readout_search.AssumeGlobalShutter();
  core_ = std::move(seeded);
  return true;
}

void Tracker::SaveMap(const std::filesystem::path& file, std::uint64_t key) const {
  core_->mapper.Drain();
  const Map& map = core_->shared.ReadByOwner();
  if (map.LivingPoints() == 0) return;
  WriteFileAtomically(file, MapToBytes(map, core_->size.KeyAtWorkingSize(key)));
}

std::optional<MapRefusal> Tracker::RestoreMap(const std::filesystem::path& file, std::uint64_t key) {
  TrackerCore& core = *core_;
  core.mapper.Drain();
  Map map(core.camera);
  try {
    if (auto refusal = MapFromBytes(ReadWholeFile(file), core.size.KeyAtWorkingSize(key), core.camera, map))
      return refusal;
  } catch (const Error& error) {
    return MapRefusal{MapProblem::kUnusable, error.what()};
  }
  auto restored = std::make_unique<TrackerCore>(core.size.original(), core.options, std::move(map));
  restored->state = TrackState::kLost;
  restored->frames_tracked = kProvenFrames;
  restored->readout_search.AssumeGlobalShutter();
  core_ = std::move(restored);
  return std::nullopt;
}

TrackerStatistics Tracker::Statistics() const {
  const MapLock lock(core_->shared);
  return {core_->shared.map.LivingKeyframes(),
          core_->shared.map.LivingPoints(),
          core_->keyframes_left_out,
          core_->shared.loops,
          core_->shared.joins,
          static_cast<int>(core_->shared.map.Parts().size()),
          std::chrono::duration<double>(core_->shared.longest_wait).count(),
          core_->calibration ? core_->calibration : core_->InOriginalPixels(core_->shared.wrong_lens),
          core_->RefinedLensInOriginalPixels(),
          core_->readout_search.found(),
          static_cast<int>(core_->shared.map.keyframes().size()),
          static_cast<int>(core_->shared.map.points().size()),
          core_->map_start,
          {core_->camera.width, core_->camera.height, core_->size.original().width,
           core_->size.original().height}};
}

const CameraModel& Tracker::camera() const { return core_->size.original(); }

}  // namespace ulf::tracking
