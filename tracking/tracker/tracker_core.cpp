#include "tracking/tracker/tracker_core.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "core/base/at.h"
#include "core/base/host_time.h"
#include "core/base/quantile.h"
#include "tracking/map/map_matching.h"
#include "tracking/map/pose_log_odds.h"
#include "tracking/tracker/photograph_locator.h"

namespace ulf::tracking {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

// Radii of the first and second search about the predicted pose, and about the last pose, px in images 640 px
// wide. Guessed.
constexpr double kNearPx = 12, kFarPx = 30, kLastPosePx = 40;
// A camera that is followed in another part of the map is looked for in the main part every so many frames.
// Guessed.
constexpr int kTryMainPartEvery = 5;

// Returns where the image shows the points that support a pose. `in_picture`: converts a match's image point,
// given its point in the camera; `px`: of the picture, for one that the matches count.
template <typename InPicture>
std::shared_ptr<const std::vector<MapObservation>> SeenIn(const FramePose& frame_pose, double px,
                                                          InPicture in_picture) {
  auto seen = std::make_shared<std::vector<MapObservation>>();
  for (const PointMatch& match : frame_pose.matches) {
    const Candidate& candidate = frame_pose.CandidateOf(match);
    seen->push_back({candidate.id, in_picture(match.img, frame_pose.cam_from_world * candidate.position),
                     px * match.sigma_px});
  }
  return seen;
}

std::vector<ExpectedPoint> ExpectedOf(const FramePose& frame_pose) {
  std::vector<bool> found(frame_pose.candidates.size());
  for (const PointMatch& match : frame_pose.matches) found[At(match.candidate)] = true;
  std::vector<ExpectedPoint> expected;
  for (const int i : frame_pose.looked_for) {
    const Candidate& candidate = frame_pose.candidates[At(i)];
    expected.push_back({candidate.position, candidate.find_rate, candidate.times_expected, found[At(i)]});
  }
  return expected;
}

}  // namespace

// Returns the velocity since the last frame; none where frames are missing in between.
std::optional<Twist> TrackerCore::VelocitySince(const Rigid3& last_pose, const Rigid3& pose,
                                                double time_s) const {
  const double step_s = time_s - last.time_s;
  if (!(step_s > 0 && step_s < kLongestStepS)) return std::nullopt;
  return TwistBetween(last_pose, pose, step_s);
}

std::optional<CalibrationCheck> TrackerCore::InOriginalPixels(
    const std::optional<CalibrationCheck>& working) const {
  if (!working) return std::nullopt;
  CalibrationCheck check = working->Of(size.original());
  const auto rolling = readout_search.found();
  check.rows_uncompensated = rolling && (!rolling->compensated || rolling->contradicted);
  return check;
}

bool TrackerCore::Follow(TrackedImage& image, Track& track) {
  Rigid3 last_pose;
  int joins;
  {
    const MapLock lock(shared);
    joins = shared.joins;
    const Keyframe& anchored_to = shared.map.keyframe(last.anchor.keyframe_id);
    last_pose = shared.map.PoseOf(last.anchor);
    part = anchored_to.part;
    const double scale = anchored_to.unit / last.anchor.unit;
    if (scale != 1) rows.Scale(scale);
    if (last.velocity) last.velocity->translation *= scale;
    last.anchor.cam_from_keyframe.translation *= scale;
    last.anchor.unit = anchored_to.unit;
  }
  if (last.joins != joins) {
    last.visible.clear();
    last.expected.clear();
  }
  const Rigid3 predicted = last.velocity ? *last.velocity * last_pose : last_pose;
  if (rows.rolls()) {
    std::vector<Vector3d> points;
    for (const VisiblePoint& point : last.visible) points.push_back(point.position_in_world);
    rows.RemoveExpectedShift(image, predicted, points);
  }
  const double unit = PxAt640(camera.width);
  const double near_px = kNearPx * unit;
  std::optional<FramePose> frame_pose;
  double evidence = 0;
  const auto try_from = [&](const Rigid3& pose, double radius_px) {
    frame_pose = locator.Locate(image, pose, part, radius_px, last.img_of_point, track.stages);
    evidence = frame_pose ? PoseLogOdds(camera, *frame_pose) : 0;
    return evidence > kFollowedLogOdds;
  };
  const bool followed = try_from(predicted, near_px) || try_from(predicted, kFarPx * unit) ||
                        (last.velocity && try_from(last_pose, kLastPosePx * unit));
  // Far from the prediction, whose candidates these are, the pose is looked for again with those that it
  // should see itself, and only unambiguous points tell similar places apart.
  if (followed && MedianShiftPx(camera, *frame_pose, predicted) > near_px) {
    const auto unambiguous = [&](const FramePose& pose) {
      ExcludedCandidates left_out;
      ExcludeAmbiguousMatches(camera, *image.features, pose, left_out);
      return PoseLogOdds(camera, pose, left_out) - kRelocalizedLogOdds;
    };
    evidence = unambiguous(*frame_pose);
    if (auto again = locator.FindNear(image, frame_pose->cam_from_world, part))
      if (const double better = unambiguous(*again); better > evidence) {
        frame_pose = std::move(again);
        evidence = better;
      }
  }
  if (evidence <= kFollowedLogOdds) {
    spdlog::debug("frame {}: lost: {} points of {:.0f}, evidence {:.1f}, {} known in the frame before", frame,
                  frame_pose ? frame_pose->matches.size() : 0, frame_pose ? frame_pose->expected : 0.0,
                  evidence, last.img_of_point.size());
    return false;
  }
  frame_pose_ = std::move(frame_pose);
  if (rows.rolls())
    rows.RefineWithRows(image, *frame_pose_,
                        VelocitySince(last_pose, frame_pose_->cam_from_world, image.time_s),
                        shared.world_given);
  return Accept(image.time_s, *frame_pose_, joins, track);
}

// Anchors a pose to the living keyframe that shares most points with its matches.
Anchored TrackerCore::AnchorOf(const FramePose& frame_pose) const {
  const Map& map = shared.map;
  std::unordered_map<int, int> seen_with;
  for (const PointMatch& match : frame_pose.matches) {
    const int id = frame_pose.CandidateOf(match).id;
    for (const Observation& o : map.point(id).observations) ++seen_with[o.keyframe];
  }
  int reference = map.FirstKeyframe(part), most = 0;
  for (const auto& [keyframe, seen] : seen_with)
    if (seen > most || (seen == most && keyframe < reference)) {
      reference = keyframe;
      most = seen;
    }
  return {reference, frame_pose.cam_from_world * map.PoseOf(reference).Inverse(),
          map.keyframe(reference).unit};
}

// Returns how far the one pose that explains an image is from the camera's pose at the middle row.
double TrackerCore::RowsApart(const FramePose& frame_pose, const std::optional<Twist>& between,
                              double distance) const {
  if (rows.rolls()) return frame_pose.picture_from_cam.OriginInSource().norm();
  if (!between) return 0;
  constexpr double kShare = 0.6;  // of the way during the readout. Measured on turns about all axes
  const double speed = std::hypot(between->head<3>().norm() * distance, between->tail<3>().norm());
  return kShare * speed * readout_search.Suspected();
}

void TrackerCore::Describe(const FramePose& frame_pose, const std::optional<Twist>& between,
                           Track& track) const {
  track.cam_from_world = frame_pose.picture_from_cam * frame_pose.cam_from_world;
  if (rows.rolls()) {
    track.middle_row_from_picture = frame_pose.picture_from_cam.Inverse();
    track.twist = frame_pose.twist;
  }
  track.matched_points = static_cast<int>(frame_pose.matches.size());
  std::vector<double> distances, parallaxes;
  for (const PointMatch& match : frame_pose.matches) {
    const Candidate& candidate = frame_pose.CandidateOf(match);
    distances.push_back((frame_pose.cam_from_world * candidate.position).norm());
    parallaxes.push_back(shared.map.point(candidate.id).parallax);
  }
  const double distance = Median(std::move(distances));
  const double bend = frame_pose.center_sigma * MapBend(Median(std::move(parallaxes)));
  track.center_sigma = std::hypot(frame_pose.center_sigma, bend, map_drift.CenterSigma(shared.map, distance));
  if (shared.world_given && world_information > 0)
    track.center_sigma = std::hypot(*track.center_sigma, 1 / std::sqrt(world_information));
  track.rows_sigma = RowsApart(frame_pose, between, distance);
  track.distance = distance;
  track.wrong_lens = shared.wrong_lens.has_value();
  track.lens_error_share = shared.wrong_lens ? shared.wrong_lens->error_share : 0;
  track.quality = QualityOf(std::hypot(*track.PictureSigma(), track.lens_error_share * distance), distance);
}

// Anchors the pose of a tracked frame and keeps what the next frame needs. Returns false where parts of the
// map were joined since it was found (`joins`), so that it may be of another world.
bool TrackerCore::Accept(double time_s, const FramePose& frame_pose, int joins, Track& track) {
  LastFrame now;
  now.time_s = time_s;
  now.joins = joins;
  std::vector<double> motion_px;
  {
    const MapLock lock(shared);
    if (shared.joins != joins) {
      frame_pose_.reset();
      return false;
    }
    for (const PointMatch& match : frame_pose.matches) {
      const Candidate& candidate = frame_pose.CandidateOf(match);
      if (const auto before = last.img_of_point.find(candidate.id); before != last.img_of_point.end())
        motion_px.push_back((before->second - match.img).norm());
      now.img_of_point[candidate.id] = match.img;
      now.visible.push_back(
          {candidate.position, match.img, (frame_pose.cam_from_world * candidate.position).z()});
    }
    now.expected = ExpectedOf(frame_pose);
    part = shared.map.point(frame_pose.CandidateOf(frame_pose.matches.front()).id).part;
    now.anchor = AnchorOf(frame_pose);
    if (std::exchange(revision, shared.revision) != shared.revision) map_drift.Clear();
    if (last.anchor.keyframe_id >= 0) {
      const Rigid3 last_pose = shared.map.PoseOf(last.anchor);
      now.velocity = frame_pose.cam_from_world * last_pose.Inverse();
      now.between = VelocitySince(last_pose, frame_pose.cam_from_world, time_s);
    }
    Describe(frame_pose, now.between, track);
  }
  spdlog::debug("frame {}: {} of {:.0f} points, {} candidates, {} aligned, {:.1f} px", frame,
                frame_pose.matches.size(), frame_pose.expected, frame_pose.candidates.size(),
                std::ranges::count_if(frame_pose.matches, [](const PointMatch& m) { return m.aligned; }),
                Median(motion_px));
  frame_before.reset();
  if (now.between) frame_before = {last.time_s, last.anchor};
  last = std::move(now);
  track.anchor = last.anchor;
  track.anchor->cam_from_keyframe = frame_pose.picture_from_cam * last.anchor.cam_from_keyframe;
  track.speed_px = Median(motion_px);
  ++frames_tracked;
  ++frames_of_part[part];
  lost_since_s.reset();
  return true;
}

void TrackerCore::Initialize(TrackedImage& image, const Frame& frame_in, Track& track) {
  StageTimer timer(&track.stages.initialization_s);
  InitializerAttempt attempt = initializer.Step(image);
  timer.Stop();
  track.start = attempt.progress;
  track.matched_points = attempt.progress.matches;
  track.speed_px = attempt.median_motion_px;
  spdlog::debug(
      "frame {}: start: {} matches, {}, {:.2f} deg, direction to {:.2f} deg, next best worse by {:.0f}",
      frame, attempt.progress.matches, Name(attempt.outcome), attempt.progress.parallax_deg,
      attempt.direction_sigma_deg, attempt.evidence.runner_up);
  if (!attempt.start) return;
  rows.InitializeFrom(*attempt.start);
  image = attempt.start->second;
  StartMap(*attempt.start, size.Reduced(Srgb8(frame_in.image)));
  // The map is kept only if this frame can be tracked on it.
  {
    const MapLock lock(shared);
    const std::vector<int> begun = shared.map.LivingOf(part);
    last = {};
    last.anchor = {begun.empty() ? -1 : begun.back(), {}, 1};
    for (const MapPoint& point : shared.map.points())
      if (point.alive && point.part == part) last.img_of_point[point.id] = point.observations.back().img;
  }
  if (last.anchor.keyframe_id >= 0 && Follow(image, track)) {
    state = TrackState::kTracking;
    track.keyframe = true;
    last_keyframe_frame = frame;
    last_keyframe_s = image.time_s;
    initializer.Restart();
    map_start = MapStart{attempt.model, attempt.evidence};
    return;
  }
  spdlog::debug("frame {}: the first map did not hold", frame);
  track.start->obstacle = StartObstacle::kMapDidNotHold;
  Abandon();
}

void TrackerCore::StartMap(const TwoViewStart& start, const cv::Mat& color) {
  mapper.Drain();
  std::vector<double> depths;
  for (const Vector3d& point : start.points) depths.push_back(point.z());
  part = mapper.StartFromTwoViews(start, 1 / std::max(1e-9, Median(depths)), color);
  frames_tracked = 0;
  world_information = 0;
  AddWorldInformation(start.first);
  AddWorldInformation(start.second);
}

// It converts the state of the last frame to the new world, too.
void TrackerCore::MoveWorld(const Similarity3& given_from_world) {
  mapper.WaitUntilIdle();
  mapper.MoveWorld(given_from_world);
  const double scale = given_from_world.scale;
  if (last.velocity) last.velocity->translation *= scale;
  if (last.between) last.between->tail<3>() *= scale;
  for (VisiblePoint& point : last.visible) {
    point.position_in_world = given_from_world * point.position_in_world;
    point.depth *= scale;
  }
  for (ExpectedPoint& point : last.expected)
    point.position_in_world = given_from_world * point.position_in_world;
  rows.Scale(scale);
  turns.Forget();
  last_turn_ = last_turn_ * Eigen::Quaterniond(given_from_world.rotation).conjugate();
  map_drift.Clear();
  mapper.RequestFullAdjustment();
}

void TrackerCore::AddWorldInformation(const TrackedImage& image) {
  if (image.fiducials && image.fiducials->center_sigma > 0)
    world_information += std::pow(image.fiducials->center_sigma, -2);
}

Track TrackerCore::Step(const Frame& frame_in, const std::optional<FiducialObservation>& fiducials) {
  const double start_s = ThreadCpuSeconds();
  mapping_cpu_s = 0;
  Track track;
  track.state = state;
  ++frame;
  if (frame_in.status != FrameStatus::kComplete || frame_in.image.empty()) {
    track.skipped = true;
    return track;
  }
  RequireSize(fmt::format("frame {}: its image", frame_in.id), frame_in.image.pixels.size(), size.original());

  readout_search.Step();
  PrepareLens();
  TrackedImage image;
  image.time_s = frame_in.device_time_s;
  if (fiducials) image.fiducials = std::make_shared<const FiducialObservation>(size.Reduced(*fiducials));
  StageTimer pyramid(&track.stages.pyramid_s);
  const cv::Mat gray = GrayForTracking(frame_in.image);
  image.pyramid = std::make_shared<const Pyramid>(BuildPyramid(size.Reduced(gray)));
  // Measure the image as it comes, which is what is recorded: reduction hides a blur of a few pixels.
  track.sharpness =
      sharpness.Step(size.IsReduced() ? ForSharpness(gray) : image.pyramid->levels[kSharpnessLevel]);
  pyramid.Stop();
  StageTimer detection(&track.stages.features_s);
  const bool may_begin =
      state == TrackState::kInitializing || (state == TrackState::kLost && MayBeginPart(image.time_s));
  const int features = may_begin ? 2 * options.features : options.features;
  image.features = std::make_shared<const FeatureSet>(extractor.Extract(*image.pyramid, features));
  detection.Stop();
  track.features = image.features->size();
  frame_pose_.reset();
  if (options.wait_for_mapper) mapper.Drain();
  joins_of_frame = shared.joins;

  switch (state) {
    case TrackState::kInitializing:
      Initialize(image, frame_in, track);
      break;
    case TrackState::kTracking:
      if (IsApart() && frame % kTryMainPartEvery == 0 && ReturnToMainPart(image, track)) break;
      if (!Follow(image, track) && !Relocalize(image, track)) {
        state = TrackState::kLost;
        lost_since_s = last.time_s;
        last = {};
        initializer.Restart();
      }
      break;
    case TrackState::kLost:
      if (Relocalize(image, track))
        state = TrackState::kTracking;
      else if (may_begin)
        Initialize(image, frame_in, track);
      break;
    case TrackState::kApart:  // of tracks alone
      break;
  }
  if (frame_pose_) WatchZoom(image.time_s, *frame_pose_, track);
  if (frame_pose_)
    track.seen = SeenIn(*frame_pose_, size.ToOriginal(1.0), [&](const Vector2d& img, const Vector3d& in_cam) {
      return size.ToOriginal(image.pyramid->Seen(img, &in_cam));
    });
  if (frame_pose_) Report(image, frame_in, *frame_pose_, track);
  if (state == TrackState::kLost && frames_tracked < kProvenFrames) Abandon();
  if (state == TrackState::kTracking) ChooseMainPart();
  track.state = state;
  {
    const MapLock lock(shared);
    const bool joined = shared.joins != joins_of_frame;
    track.map_id = track.anchor ? shared.map.keyframe(track.anchor->keyframe_id).part : part;
    if (track.anchor && joined) {
      track.cam_from_world = shared.map.PoseOf(*track.anchor);
      last.visible.clear();
      last.expected.clear();
    }
    if (track.anchor && track.map_id != shared.map.main_part()) {
      track.state = TrackState::kApart;
      track.cam_from_world.reset();
      track.middle_row_from_picture.reset();
      track.quality = 0;
    }
  }
  FollowTurn(image, track);
  track.map_revision = shared.revision;
  track.lens_revision = lens_revision;
  track.cpu_s = ThreadCpuSeconds() - start_s - mapping_cpu_s;
  return track;
}

std::optional<Track> TrackerCore::LocatePhotograph(
    const Image& image, const CameraModel& photograph_camera, const std::optional<Rigid3>& near,
    const std::optional<FiducialObservation>& fiducials) const {
  // There is no map yet, or the photograph's lens is not its camera's.
  if (state == TrackState::kInitializing || zoom.IsMoved()) return std::nullopt;
  const PhotographLocator photographs(camera, photograph_camera, shared, mapper.index(), 2 * options.features,
                                      options.seed);
  const auto frame_pose = photographs.Locate(GrayForTracking(image), near, fiducials);
  if (!frame_pose) return std::nullopt;
  Track track;
  track.state = TrackState::kTracking;
  const MapLock lock(shared);
  track.map_id = shared.map.main_part();
  if (shared.map.point(frame_pose->CandidateOf(frame_pose->matches.front()).id).part != track.map_id)
    return std::nullopt;
  Describe(*frame_pose, {}, track);
  track.anchor = AnchorOf(*frame_pose);
  track.seen = SeenIn(*frame_pose, 1, [](const Vector2d& img, const Vector3d&) { return img; });
  return track;
}

}  // namespace ulf::tracking
