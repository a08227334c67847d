#include "tracking/tracker/tracker_state.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>
#include <unordered_set>

#include "core/base/error.h"
#include "core/base/quantile.h"
#include "core/base/thread_clock.h"
#include "tracking/estimation/pose_log_odds.h"
#include "tracking/map/map_matching.h"
#include "tracking/tracker/photograph_locator.h"

namespace ulf::tracking {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

constexpr double kLongestStep_s = 0.25;  // between frames, for a velocity

// Where the picture shows what the pose rests on: `in_picture` of a match and its point in the camera.
template <typename InPicture>
std::shared_ptr<const std::vector<MapObservation>> SeenIn(const FramePose& located, InPicture in_picture) {
  auto seen = std::make_shared<std::vector<MapObservation>>();
  for (const PointMatch& match : located.matches) {
    const Candidate& candidate = located.candidates[static_cast<std::size_t>(match.candidate)];
    seen->push_back({candidate.id, in_picture(match.img, located.cam_from_world * candidate.position)});
  }
  return seen;
}

}  // namespace

// None where frames are missing between: the hand was free to do anything.
std::optional<Twist> Tracker::State::VelocitySince(const Rigid3& last_pose, const Rigid3& pose,
                                                   double time_s) const {
  const double step_s = time_s - last.time_s;
  if (!(step_s > 0 && step_s < kLongestStep_s)) return std::nullopt;
  return TwistBetween(last_pose, pose, step_s);
}

std::optional<Readout> Tracker::State::Rolling() const {
  if (readout_search) return readout_search->found();
  return rows.rolls() ? std::optional(Readout{rows.readout_s()}) : std::nullopt;
}

bool Tracker::State::Follow(TrackedImage& image, Track& track) {
  Rigid3 last_pose;
  {
    const MapLock lock(shared);
    last_pose = shared.map.PoseOf(last.anchor);
  }
  const Rigid3 predicted = last.velocity ? *last.velocity * last_pose : last_pose;
  if (rows.rolls()) {
    std::vector<Vector3d> points;
    for (const VisiblePoint& point : last.visible) points.push_back(point.position_in_world);
    rows.Expect(image, predicted, points);
  }
  const double unit = camera.width / 640.0;
  const double near_px = 12 * unit;
  std::optional<FramePose> located;
  double evidence = 0;
  const auto try_from = [&](const Rigid3& pose, double radius_px) {
    located = locator.Locate(image, pose, radius_px, last.img_of_point, track.stages);
    evidence = located ? PoseLogOdds(camera, *located) : 0;
    return evidence > kFollowedLogOdds;
  };
  const bool followed = try_from(predicted, near_px) || try_from(predicted, 30 * unit) ||
                        (last.velocity && try_from(last_pose, 40 * unit));
  // Where no prediction says which of several like things this is, only what is unlike them can.
  if (followed && MedianShiftPx(camera, *located, predicted) > near_px) {
    LeftOut left_out;
    ExcludeAmbiguousMatches(camera, *image.features, *located, left_out);
    evidence = PoseLogOdds(camera, *located, left_out) - kRelocalizedLogOdds;
  }
  if (evidence <= kFollowedLogOdds) {
    spdlog::debug("frame {}: lost: {} points of {:.0f}, evidence {:.1f}, {} known in the frame before", frame,
                  located ? located->matches.size() : 0, located ? located->expected : 0.0, evidence,
                  last.img_of_point.size());
    return false;
  }
  located_ = std::move(located);
  if (rows.rolls())
    rows.Settle(image, *located_, VelocitySince(last_pose, located_->cam_from_world, image.time_s),
                shared.world_given);
  Accept(image.time_s, *located_, track);
  return true;
}

bool Tracker::State::Relocalize(TrackedImage& image, Track& track) {
  const StageTimer timer(&track.stages.relocalization_s);
  std::optional<FramePose> found;
  // What only the frame before could tell from its mirror image is no place to look.
  if (image.fiducials && image.fiducials->center_sigma > 0 && shared.world_given)
    found = locator.FindAt(image, image.fiducials->cam_from_world);
  if (!found) found = locator.Find(image, index, options.seed + static_cast<unsigned>(frame));
  if (!found) return false;
  last = {};
  rows.Forget();
  located_ = std::move(found);
  if (rows.rolls()) rows.Settle(image, *located_, {}, shared.world_given);
  Accept(image.time_s, *located_, track);
  track.relocalized = true;
  spdlog::debug("frame {}: found again", frame);
  return true;
}

// The living keyframe that shares most points with these matches.
Anchored Tracker::State::AnchorOf(const FramePose& located) const {
  const Map& map = shared.map;
  std::unordered_map<int, int> seen_with;
  for (const PointMatch& match : located.matches) {
    const int id = located.candidates[static_cast<std::size_t>(match.candidate)].id;
    for (const Observation& o : map.point(id).observations) ++seen_with[o.keyframe];
  }
  int reference = map.FirstKeyframe(), most = 0;
  for (const auto& [keyframe, seen] : seen_with)
    if (seen > most || (seen == most && keyframe < reference)) {
      reference = keyframe;
      most = seen;
    }
  return {reference, located.cam_from_world * map.PoseOf(reference).Inverse(), map.keyframe(reference).unit};
}

void Tracker::State::Describe(const FramePose& located, Track& track) const {
  track.cam_from_world = located.picture_from_cam * located.cam_from_world;
  if (rows.rolls()) track.middle_row_from_picture = located.picture_from_cam.Inverse();
  track.matched_points = static_cast<int>(located.matches.size());
  std::vector<double> distances;
  for (const PointMatch& match : located.matches)
    distances.push_back(
        (located.cam_from_world * located.candidates[static_cast<std::size_t>(match.candidate)].position)
            .norm());
  const double distance = Median(std::move(distances));
  track.center_sigma = std::hypot(located.center_sigma, unrest.Of(shared.map, distance));
  if (shared.world_given && world_information > 0)
    track.center_sigma = std::hypot(*track.center_sigma, 1 / std::sqrt(world_information));
  track.quality = QualityOf(*track.center_sigma, distance);
}

std::vector<ExpectedPoint> ExpectedOf(const FramePose& located) {
  std::vector<bool> found(located.candidates.size());
  for (const PointMatch& match : located.matches) found[static_cast<std::size_t>(match.candidate)] = true;
  std::vector<ExpectedPoint> expected;
  for (const int i : located.looked_for) {
    const Candidate& candidate = located.candidates[static_cast<std::size_t>(i)];
    expected.push_back({candidate.position, candidate.find_rate, candidate.times_expected,
                        found[static_cast<std::size_t>(i)]});
  }
  return expected;
}

// The frame is tracked: chooses the keyframe to anchor to, counts, and remembers for the next frame.
void Tracker::State::Accept(double time_s, const FramePose& located, Track& track) {
  LastFrame now;
  now.time_s = time_s;
  std::vector<double> motion_px;
  {
    const MapLock lock(shared);
    Map& map = shared.map;
    for (const int i : located.in_view)
      ++map.point(located.candidates[static_cast<std::size_t>(i)].id).expected;
    for (const PointMatch& match : located.matches) {
      const Candidate& candidate = located.candidates[static_cast<std::size_t>(match.candidate)];
      ++map.point(candidate.id).found;
      if (const auto before = last.img_of_point.find(candidate.id); before != last.img_of_point.end())
        motion_px.push_back((before->second - match.img).norm());
      now.img_of_point[candidate.id] = match.img;
      now.visible.push_back(
          {candidate.position, match.img, (located.cam_from_world * candidate.position).z()});
    }
    now.expected = ExpectedOf(located);
    now.anchor = AnchorOf(located);
    if (std::exchange(revision, shared.revision) != shared.revision) unrest.Forget();
    Describe(located, track);
    if (last.anchor.keyframe_id >= 0) {
      const Rigid3 last_pose = map.PoseOf(last.anchor);
      now.velocity = located.cam_from_world * last_pose.Inverse();
      now.between = VelocitySince(last_pose, located.cam_from_world, time_s);
    }
  }
  spdlog::debug("frame {}: {} of {:.0f} points, {} candidates, {} aligned, {:.1f} px", frame,
                located.matches.size(), located.expected, located.candidates.size(),
                std::count_if(located.matches.begin(), located.matches.end(),
                              [](const PointMatch& m) { return m.aligned; }),
                Median(motion_px));
  frame_before.reset();
  if (now.between) frame_before = {last.time_s, last.anchor};
  last = std::move(now);
  track.anchor = last.anchor;
  track.anchor->cam_from_keyframe = located.picture_from_cam * last.anchor.cam_from_keyframe;
  track.speed_px = Median(motion_px);
  ++frames_tracked;
}

bool Tracker::State::WantsKeyframe(const FramePose& located, int reference_points) const {
  const int matched = static_cast<int>(located.matches.size());
  if (frames_since_keyframe < 2) return false;
  const Rigid3& pose = last.anchor.cam_from_keyframe;
  std::vector<double> depths;
  for (const VisiblePoint& point : last.visible) depths.push_back(point.depth);
  const double depth = std::max(1e-9, Median(depths));
  const double moved = pose.OriginInSource().norm() / depth;
  const double turned_deg = RotationAngle(pose.rotation) * 180 / M_PI;
  const bool thin = matched < 0.75 * reference_points || matched < 80;
  const bool far = moved > options.mapping.keyframe_moved || turned_deg > options.mapping.keyframe_turned_deg;
  return (thin && (moved > 0.02 || turned_deg > 4)) || far;
}

// Of the frame before, if it became a keyframe: from the frames before and after it, so that it is of its own
// moment, and what the hand trembles faster than that is no error of one sign.
void Tracker::State::SetVelocity(const TrackedImage& image, const FramePose& located) {
  if (before_keyframe && image.time_s - before_keyframe->time_s < 2 * kLongestStep_s) {
    const MapLock lock(shared);
    const Twist velocity = TwistBetween(shared.map.PoseOf(before_keyframe->anchor), located.cam_from_world,
                                        image.time_s - before_keyframe->time_s);
    // A mapper that has not put it into the map yet leaves it with the velocity before it.
    if (!shared.map.living().empty())
      if (Keyframe& newest = shared.map.keyframe(shared.map.living().back());
          newest.time_s == before_keyframe->keyframe_time_s)
        newest.velocity = velocity;
  }
  before_keyframe.reset();
}

void Tracker::State::OfferKeyframe(const TrackedImage& image, const Frame& frame_in, const FramePose& located,
                                   Track& track) {
  StageTimer timer(&track.stages.keyframe_s);
  {
    const MapLock lock(shared);
    if (!WantsKeyframe(located, shared.map.keyframe(last.anchor.keyframe_id).points_at_birth)) return;
  }
  NewKeyframe offered;
  offered.keyframe.time_s = image.time_s;
  offered.keyframe.cam_from_world = located.cam_from_world;
  offered.keyframe.pyramid = image.pyramid;
  offered.keyframe.velocity = last.between;
  offered.keyframe.color = size.Reduced(Srgb8(frame_in.image));
  if (shared.world_given)
    offered.keyframe.corners = CornersOf(shared, image, located.cam_from_world);
  else if (image.fiducials && !image.pyramid->rows)
    offered.keyframe.corners = image.fiducials->corners;
  locator.Describe(*image.features, located, offered);
  timer.Stop();
  const double before_s = ThreadCpuSeconds();
  track.keyframe = mapper.Offer(std::move(offered));
  if (options.deterministic) mapping_cpu_s += ThreadCpuSeconds() - before_s;
  if (track.keyframe) {
    frames_since_keyframe = 0;
    AddWorldInformation(image);
    if (frame_before) before_keyframe = {frame_before->first, frame_before->second, image.time_s};
    unrest.Give(last.anchor, located.cam_from_world);
  } else {
    ++keyframes_left_out;
  }
}

void Tracker::State::Initialize(TrackedImage& image, const Frame& frame_in, Track& track) {
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
  rows.AtStart(*attempt.start);
  image = attempt.start->second;
  StartMap(*attempt.start, size.Reduced(Srgb8(frame_in.image)));
  // The map stands or falls by whether this frame can be tracked on it.
  {
    const MapLock lock(shared);
    const int keyframes = static_cast<int>(shared.map.keyframes().size());
    last.anchor = {shared.map.LivingKeyframes() > 0 ? keyframes - 1 : -1, {}, 1};
    for (const MapPoint& point : shared.map.points())
      if (point.alive) last.img_of_point[point.id] = point.observations.back().img;
  }
  if (last.anchor.keyframe_id >= 0 && Follow(image, track)) {
    state = TrackState::kTracking;
    frames_since_keyframe = 0;
    track.keyframe = true;
    initializer.Restart();
    map_start = MapStart{attempt.model, attempt.evidence};
    return;
  }
  spdlog::debug("frame {}: the first map did not hold", frame);
  track.start->obstacle = StartObstacle::kMapDidNotHold;
  mapper.Reset();
  last = {};
  unrest.Forget();
  initializer.Restart();
}

void Tracker::State::StartMap(const TwoViewStart& start, const cv::Mat& color) {
  mapper.Drain();
  std::vector<double> depths;
  for (const Vector3d& point : start.points) depths.push_back(point.z());
  mapper.StartFromTwoViews(start, 1 / std::max(1e-9, Median(depths)), color);
  world_information = 0;
  AddWorldInformation(start.first);
  AddWorldInformation(start.second);
}

// What was learnt of the motion so far goes on in the new world's unit.
void Tracker::State::MoveWorld(const Similarity3& given_from_world) {
  mapper.Rest();
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
  unrest.Forget();
  mapper.AdjustSoon();
}

void Tracker::State::AddWorldInformation(const TrackedImage& image) {
  if (image.fiducials && image.fiducials->center_sigma > 0)
    world_information += std::pow(image.fiducials->center_sigma, -2);
}

Track Tracker::State::Step(const Frame& frame_in, const std::optional<FiducialObservation>& fiducials) {
  const double start_s = ThreadCpuSeconds();
  mapping_cpu_s = 0;
  Track track;
  track.state = state;
  track.map_id = map_id;
  ++frame;
  if (frame_in.status != FrameStatus::kComplete || frame_in.image.empty()) {
    track.skipped = true;
    return track;
  }
  if (frame_in.image.width() != size.original().width || frame_in.image.height() != size.original().height)
    throw Error(
        "frame {}: its image is {}x{}, the camera's intrinsics are for {}x{}; calibrate for this size",
        frame_in.id, frame_in.image.width(), frame_in.image.height(), size.original().width,
        size.original().height);

  if (readout_search) readout_search->Step();
  TrackedImage image;
  image.time_s = frame_in.device_time_s;
  if (fiducials) image.fiducials = std::make_shared<const FiducialObservation>(size.Reduced(*fiducials));
  StageTimer pyramid(&track.stages.pyramid_s);
  const cv::Mat gray = GrayForTracking(frame_in.image);
  image.pyramid = std::make_shared<const Pyramid>(BuildPyramid(size.Reduced(gray)));
  // Of the picture as it comes: that is what is recorded, and a blur of a few of its pixels is none of a
  // reduced one's.
  track.sharpness =
      sharpness.Step(size.IsReduced() ? ForSharpness(gray) : image.pyramid->levels[kSharpnessLevel]);
  pyramid.Stop();
  StageTimer detection(&track.stages.features_s);
  const int features = state == TrackState::kInitializing ? 2 * options.features : options.features;
  image.features = std::make_shared<const FeatureSet>(extractor.Extract(*image.pyramid, features));
  detection.Stop();
  track.features = image.features->size();
  ++frames_since_keyframe;
  located_.reset();
  // A replay gives the mapper the time that a camera would: it may be a few frames behind, not more.
  constexpr int kMayLag = 3;
  if (options.wait_for_mapper && frames_since_keyframe > kMayLag) mapper.Drain();

  switch (state) {
    case TrackState::kInitializing:
      Initialize(image, frame_in, track);
      break;
    case TrackState::kTracking:
      if (!Follow(image, track) && !Relocalize(image, track)) {
        state = TrackState::kLost;
        last = {};
      }
      break;
    case TrackState::kLost:
      if (Relocalize(image, track)) state = TrackState::kTracking;
      break;
  }
  if (located_)
    track.seen = SeenIn(*located_, [&](const Vector2d& img, const Vector3d& in_cam) {
      return size.ToOriginal(image.pyramid->Seen(img, &in_cam));
    });
  if (located_) SetVelocity(image, *located_);
  if (state == TrackState::kTracking && located_ && !track.keyframe)
    OfferKeyframe(image, frame_in, *located_, track);
  if (state == TrackState::kLost && frames_tracked < 10) {
    // Lost at once: a map that never proved itself.
    spdlog::debug("frame {}: lost at once, starting again", frame);
    mapper.Rest();
    mapper.Reset();
    unrest.Forget();
    initializer.Restart();
    state = TrackState::kInitializing;
    frames_tracked = 0;
    ++map_id;
  }
  track.state = state;
  track.map_id = map_id;
  track.map_revision = shared.revision;
  track.cpu_s = ThreadCpuSeconds() - start_s - mapping_cpu_s;
  return track;
}

std::optional<Track> Tracker::State::LocatePhotograph(
    const Image& image, const CameraModel& photograph_camera, const std::optional<Rigid3>& near,
    const std::optional<FiducialObservation>& fiducials) const {
  if (state == TrackState::kInitializing) return std::nullopt;  // there is no map yet
  const PhotographLocator photographs(camera, photograph_camera, shared, index,
                                      {.features = 2 * options.features, .seed = options.seed});
  const auto located = photographs.Locate(GrayForTracking(image), near, fiducials);
  if (!located) return std::nullopt;
  Track track;
  track.state = TrackState::kTracking;
  track.map_id = map_id;
  const MapLock lock(shared);
  Describe(*located, track);
  track.anchor = AnchorOf(*located);
  track.seen = SeenIn(*located, [](const Vector2d& img, const Vector3d&) { return img; });
  return track;
}

}  // namespace ulf::tracking
