#include "tracking/tracker.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <deque>
#include <limits>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "acquisition/atomic_file.h"
#include "acquisition/error.h"
#include "tracking/frame_locator.h"
#include "tracking/initializer.h"
#include "tracking/map_file.h"
#include "tracking/map_matching.h"
#include "tracking/mapper.h"
#include "tracking/photograph_locator.h"
#include "tracking/pose_error.h"
#include "tracking/pose_evidence.h"
#include "tracking/quantile.h"
#include "tracking/readout_search.h"
#include "tracking/relocalizer.h"
#include "tracking/row_motion.h"
#include "tracking/thread_clock.h"

namespace ulf {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kLongestStep_s = 0.25;  // between frames, for a velocity

// Energy of fine detail: the variance of the Laplacian, a little below full resolution where noise would
// rule.
double DetailOf(const Pyramid& pyramid) {
  const cv::Mat& image = pyramid.levels[2];
  std::int64_t sum = 0, sum2 = 0;
  for (int y = 1; y + 1 < image.rows; ++y) {
    const std::uint8_t* row = image.ptr<std::uint8_t>(y);
    const std::uint8_t *above = row - image.step, *below = row + image.step;
    std::int32_t row_sum = 0, row_sum2 = 0;  // a row of 2,000 pixels fits whatever it shows
    for (int x = 1; x + 1 < image.cols; ++x) {
      const std::int32_t laplacian = above[x] + below[x] + row[x - 1] + row[x + 1] - 4 * row[x];
      row_sum += laplacian;
      row_sum2 += laplacian * laplacian;
    }
    sum += row_sum;
    sum2 += row_sum2;
  }
  const double count = std::max(1.0, static_cast<double>(image.cols - 2) * (image.rows - 2));
  const double mean = static_cast<double>(sum) / count;
  return static_cast<double>(sum2) / count - mean * mean;
}

// Detail relative to the recent median.
class Sharpness {
 public:
  double Step(const Pyramid& pyramid) {
    const double detail = DetailOf(pyramid);
    const double usual = Median({recent_.begin(), recent_.end()});
    recent_.push_back(detail);
    if (recent_.size() > kRecent) recent_.pop_front();
    return usual > 0 ? detail / usual : 1;
  }

 private:
  static constexpr std::size_t kRecent = 31;
  std::deque<double> recent_;
};

// How far from where a pose would have them the points were found.
double MedianShiftPx(const CameraModel& camera, const Located& located, const Rigid3& cam_from_world) {
  std::vector<double> shifts;
  for (const PointMatch& match : located.matches) {
    const Candidate& candidate = located.candidates[static_cast<std::size_t>(match.candidate)];
    if (const auto img = camera.ImgFromCam(cam_from_world * candidate.position))
      shifts.push_back((*img - match.img).norm());
  }
  return shifts.empty() ? std::numeric_limits<double>::infinity() : Median(std::move(shifts));
}

// The last frame that was tracked.
struct LastFrame {
  double time_s = 0;
  Anchored anchor;
  std::optional<Rigid3> velocity;  // this camera from the frame before
  std::unordered_map<int, Vector2d> img_of_point;
  std::vector<VisiblePoint> visible;
  std::optional<Twist> between;  // the velocity since the frame before
};

}  // namespace

struct Tracker::State {
  State(const CameraModel& camera_in, const TrackerOptions& options_in)
      : camera(camera_in),
        options(options_in),
        extractor(camera_in),
        shared(camera_in),
        index(options_in.seed),
        mapper(camera_in, shared, index, options_in.deterministic, options_in.mapping, options_in.seed),
        locator(camera_in, shared, options_in.features / 5),
        initializer(camera_in, options_in.min_initial_parallax_deg, options_in.seed),
        rows(camera_in, options_in.readout_s.value_or(0)) {
    if (!options.readout_s)
      readout_search.emplace(camera, rows, shared, mapper, options.compensate_found_readout);
  }

  CameraModel camera;
  TrackerOptions options;
  FeatureExtractor extractor;
  SharedMap shared;
  KeyframeIndex index;
  Mapper mapper;
  FrameLocator locator;
  Initializer initializer;
  Sharpness sharpness;
  RowMotion rows;
  std::optional<ReadoutSearch> readout_search;
  std::optional<std::pair<double, Anchored>> frame_before;  // of the last one: time and pose
  struct BeforeKeyframe {
    double time_s;
    Anchored anchor;
    double keyframe_time_s;
  };
  std::optional<BeforeKeyframe> before_keyframe;  // where the last frame became one
  MapUnrest unrest;
  int revision = 0;  // of the map, when the last frame was tracked

  TrackState state = TrackState::kInitializing;
  LastFrame last;
  int frame = 0;
  int frames_since_keyframe = 0;
  int frames_tracked = 0;  // on this map
  int map_id = 0;
  int keyframes_left_out = 0;
  std::optional<CalibrationCheck> calibration;  // of the last Finish()
  double mapping_cpu_s = 0;                     // spent inside Step(), when synchronous

  Track Step(const Frame& frame_in);
  void Initialize(TrackedImage& image, const Frame& frame_in, Track& track);
  void StartMap(const TwoViewStart& start, const cv::Mat& color);
  bool Follow(TrackedImage& image, Track& track);
  bool Relocalize(TrackedImage& image, Track& track);
  std::optional<Twist> VelocitySince(const Rigid3& last_pose, const Rigid3& pose, double time_s) const;
  std::optional<Readout> Rolling() const;
  void Accept(double time_s, const Located& located, Track& track);
  Anchored AnchorOf(const Located& located) const;
  void Describe(const Located& located, Track& track) const;
  std::optional<Track> LocatePhotograph(const Image& image, const CameraModel& camera,
                                        const std::optional<Rigid3>& near) const;
  void TellVelocity(const TrackedImage& image, const Located& located);
  void OfferKeyframe(const TrackedImage& image, const Frame& frame_in, const Located& located, Track& track);
  bool WantsKeyframe(const Located& located, int reference_points) const;

  std::optional<Located> located_;  // of the frame in work
};

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
    const std::lock_guard lock(shared.mutex);
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
  std::optional<Located> located;
  double evidence = 0;
  const auto try_from = [&](const Rigid3& pose, double radius_px) {
    located = locator.Locate(image, pose, radius_px, last.img_of_point, track.stages);
    evidence = located ? PoseEvidence(camera, *located) : 0;
    return evidence > kFollowedEvidence;
  };
  const bool followed = try_from(predicted, near_px) || try_from(predicted, 30 * unit) ||
                        (last.velocity && try_from(last_pose, 40 * unit));
  // Where no prediction says which of several like things this is, only what is unlike them can.
  if (followed && MedianShiftPx(camera, *located, predicted) > near_px) {
    LeftOut left_out;
    LeaveOutTwins(camera, *image.features, *located, left_out);
    evidence = PoseEvidence(camera, *located, left_out) - kFoundEvidence;
  }
  if (evidence <= kFollowedEvidence) {
    spdlog::debug("frame {}: lost: {} points of {:.0f}, evidence {:.1f}, {} known in the frame before", frame,
                  located ? located->matches.size() : 0, located ? located->expected : 0.0, evidence,
                  last.img_of_point.size());
    return false;
  }
  located_ = std::move(located);
  if (rows.rolls())
    rows.Settle(image, *located_, VelocitySince(last_pose, located_->cam_from_world, image.time_s));
  Accept(image.time_s, *located_, track);
  return true;
}

bool Tracker::State::Relocalize(TrackedImage& image, Track& track) {
  const StageTimer timer(&track.stages.relocalization_s);
  auto found = locator.Find(image, index, options.seed + static_cast<unsigned>(frame));
  if (!found) return false;
  last = {};
  rows.Forget();
  located_ = std::move(found);
  if (rows.rolls()) rows.Settle(image, *located_, {});
  Accept(image.time_s, *located_, track);
  track.relocalized = true;
  spdlog::debug("frame {}: found again", frame);
  return true;
}

// The living keyframe that shares most points with these matches. The map's lock is held.
Anchored Tracker::State::AnchorOf(const Located& located) const {
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

// The map's lock is held.
void Tracker::State::Describe(const Located& located, Track& track) const {
  track.cam_from_world = located.cam_from_world;
  track.matched_points = static_cast<int>(located.matches.size());
  std::vector<double> distances;
  for (const PointMatch& match : located.matches)
    distances.push_back(
        (located.cam_from_world * located.candidates[static_cast<std::size_t>(match.candidate)].position)
            .norm());
  const double distance = Median(std::move(distances));
  track.center_sigma = std::hypot(located.center_sigma, unrest.Of(shared.map, distance));
  track.quality = QualityOf(*track.center_sigma, distance);
}

// The frame is tracked: chooses the keyframe to anchor to, counts, and remembers for the next frame.
void Tracker::State::Accept(double time_s, const Located& located, Track& track) {
  LastFrame now;
  now.time_s = time_s;
  std::vector<double> motion_px;
  {
    const std::lock_guard lock(shared.mutex);
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
  track.speed_px = Median(motion_px);
  ++frames_tracked;
}

bool Tracker::State::WantsKeyframe(const Located& located, int reference_points) const {
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
void Tracker::State::TellVelocity(const TrackedImage& image, const Located& located) {
  if (before_keyframe && image.time_s - before_keyframe->time_s < 2 * kLongestStep_s) {
    const std::lock_guard lock(shared.mutex);
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

void Tracker::State::OfferKeyframe(const TrackedImage& image, const Frame& frame_in, const Located& located,
                                   Track& track) {
  StageTimer timer(&track.stages.keyframe_s);
  {
    const std::lock_guard lock(shared.mutex);
    if (!WantsKeyframe(located, shared.map.keyframe(last.anchor.keyframe_id).points_at_birth)) return;
  }
  NewKeyframe offered;
  offered.keyframe.time_s = image.time_s;
  offered.keyframe.cam_from_world = located.cam_from_world;
  offered.keyframe.pyramid = image.pyramid;
  offered.keyframe.velocity = last.between;
  offered.keyframe.color = Srgb8(frame_in.image);
  locator.Describe(*image.features, located, offered);
  timer.Stop();
  const double before_s = ThreadCpuSeconds();
  track.keyframe = mapper.Offer(std::move(offered));
  if (options.deterministic) mapping_cpu_s += ThreadCpuSeconds() - before_s;
  if (track.keyframe) {
    frames_since_keyframe = 0;
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
      attempt.direction_sigma_deg, attempt.runner_up);
  if (!attempt.start) return;
  rows.AtStart(*attempt.start);
  image = attempt.start->second;
  StartMap(*attempt.start, Srgb8(frame_in.image));
  // The map stands or falls by whether this frame can be tracked on it.
  last.anchor = {
      shared.map.LivingKeyframes() > 0 ? static_cast<int>(shared.map.keyframes().size()) - 1 : -1, {}, 1};
  if (last.anchor.keyframe_id >= 0) {
    for (const MapPoint& point : shared.map.points())
      if (point.alive) last.img_of_point[point.id] = point.observations.back().img;
    if (Follow(image, track)) {
      state = TrackState::kTracking;
      frames_since_keyframe = 0;
      track.keyframe = true;
      initializer.Restart();
      return;
    }
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
}

Track Tracker::State::Step(const Frame& frame_in) {
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
  if (frame_in.image.width() != camera.width || frame_in.image.height() != camera.height)
    throw Error(
        "frame {}: its image is {}x{}, the camera's intrinsics are for {}x{}; calibrate for this size",
        frame_in.id, frame_in.image.width(), frame_in.image.height(), camera.width, camera.height);

  if (readout_search) readout_search->Step();
  TrackedImage image;
  image.time_s = frame_in.device_time_s;
  StageTimer pyramid(&track.stages.pyramid_s);
  image.pyramid = std::make_shared<const Pyramid>(BuildPyramid(GrayForTracking(frame_in.image)));
  track.sharpness = sharpness.Step(*image.pyramid);
  pyramid.Stop();
  StageTimer detection(&track.stages.features_s);
  const int features = state == TrackState::kInitializing ? 2 * options.features : options.features;
  image.features = std::make_shared<const FeatureSet>(extractor.Extract(*image.pyramid, features));
  detection.Stop();
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
  if (located_) TellVelocity(image, *located_);
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

std::optional<Track> Tracker::State::LocatePhotograph(const Image& image,
                                                      const CameraModel& photograph_camera,
                                                      const std::optional<Rigid3>& near) const {
  if (state == TrackState::kInitializing) return std::nullopt;  // there is no map yet
  const PhotographLocator photographs(camera, photograph_camera, shared, index,
                                      {.features = 2 * options.features, .seed = options.seed});
  const auto located = photographs.Locate(GrayForTracking(image), near);
  if (!located) return std::nullopt;
  Track track;
  track.state = TrackState::kTracking;
  track.map_id = map_id;
  const std::lock_guard lock(shared.mutex);
  Describe(*located, track);
  track.anchor = AnchorOf(*located);
  return track;
}

Tracker::Tracker(const CameraModel& camera, const TrackerOptions& options) {
  camera.Validate("tracker");
  state_ = std::make_unique<State>(camera, options);
}
Tracker::~Tracker() = default;
Tracker::Tracker(Tracker&&) noexcept = default;
Tracker& Tracker::operator=(Tracker&&) noexcept = default;

Track Tracker::Step(const Frame& frame) { return state_->Step(frame); }

std::optional<Track> Tracker::Locate(const Image& photograph, const CameraModel& camera,
                                     const std::optional<Rigid3>& near) const {
  camera.Validate("photograph");
  if (photograph.width() != camera.width || photograph.height() != camera.height)
    throw Error("a photograph is {}x{}, its camera's intrinsics are for {}x{}; calibrate for this size",
                photograph.width(), photograph.height(), camera.width, camera.height);
  return state_->LocatePhotograph(photograph, camera, near);
}

void Tracker::Finish() {
  state_->mapper.Rest();
  state_->mapper.AdjustAll();
  state_->calibration = CheckCalibration(state_->camera, state_->shared.map);
}

Rigid3 Tracker::PoseOf(const Anchored& anchor) const {
  const std::lock_guard lock(state_->shared.mutex);
  return state_->shared.map.PoseOf(anchor);
}

std::vector<VisiblePoint> Tracker::VisiblePoints() const { return state_->last.visible; }

std::vector<ScenePoint> Tracker::Points() const {
  const std::lock_guard lock(state_->shared.mutex);
  std::vector<ScenePoint> points;
  for (const MapPoint& point : state_->shared.map.points())
    if (point.alive) points.push_back({point.position, point.rgb});
  return points;
}

std::vector<Anchored> Tracker::Keyframes() const {
  const std::lock_guard lock(state_->shared.mutex);
  std::vector<Anchored> anchors;
  for (const int keyframe : state_->shared.map.living())
    anchors.push_back({keyframe, {}, state_->shared.map.keyframe(keyframe).unit});
  return anchors;
}

bool Tracker::SeedMap(std::span<const SeedView> views) {
  State& state = *state_;
  state.mapper.Drain();
  if (views.size() < 2) return false;
  // Tried on a tracker of its own, so that a failure leaves this one as it was.
  auto seeded = std::make_unique<State>(state.camera, state.options);
  for (const SeedView& view : views) {
    if (view.image.width() != state.camera.width || view.image.height() != state.camera.height)
      throw Error(
          "a recorded view is {}x{}, the camera's intrinsics are for {}x{}; resume with the same camera",
          view.image.width(), view.image.height(), state.camera.width, state.camera.height);
    NewKeyframe offered;
    auto pyramid = std::make_shared<const Pyramid>(BuildPyramid(GrayForTracking(view.image)));
    offered.keyframe.cam_from_world = view.cam_from_world;
    offered.keyframe.features =
        std::make_shared<const FeatureSet>(seeded->extractor.Extract(*pyramid, 2 * state.options.features));
    offered.keyframe.pyramid = std::move(pyramid);
    offered.keyframe.color = Srgb8(view.image);
    seeded->mapper.AddSeed(std::move(offered));
  }
  constexpr int kMinPoints = 60;
  Map& map = seeded->shared.map;
  if (map.LivingPoints() < kMinPoints) return false;
  // The views are their points' record: of all that a view should show, most was found in a few views only.
  // Without it the first frame would be expected to find half of everything, and refused.
  for (const Keyframe& keyframe : map.keyframes())
    for (const Candidate& candidate : GatherCandidates(map, state.camera, keyframe.cam_from_world))
      ++map.point(candidate.id).expected;
  for (const MapPoint& point : map.points())
    map.point(point.id).found = static_cast<int>(point.observations.size());
  seeded->state = TrackState::kLost;
  seeded->frames_tracked = 10;  // given, hence proven
  state_ = std::move(seeded);
  return true;
}

void Tracker::SaveMap(const std::filesystem::path& file, std::uint64_t key) const {
  state_->mapper.Drain();
  if (state_->shared.map.LivingPoints() == 0) return;
  WriteFileAtomically(file, MapToBytes(state_->shared.map, key));
}

std::string Tracker::RestoreMap(const std::filesystem::path& file, std::uint64_t key) {
  State& state = *state_;
  state.mapper.Drain();
  auto restored = std::make_unique<State>(state.camera, state.options);
  try {
    const std::string problem = MapFromBytes(ReadWholeFile(file), key, state.camera, restored->shared.map);
    if (!problem.empty()) return problem;
  } catch (const Error& error) {
    return error.what();
  }
  for (const Keyframe& keyframe : restored->shared.map.keyframes())
    if (keyframe.alive) restored->index.Add(keyframe);
  restored->state = TrackState::kLost;
  restored->frames_tracked = 10;  // it proved itself before
  state_ = std::move(restored);
  return {};
}

TrackerStatistics Tracker::Statistics() const {
  const std::lock_guard lock(state_->shared.mutex);
  return {state_->shared.map.LivingKeyframes(),
          state_->shared.map.LivingPoints(),
          state_->keyframes_left_out,
          state_->shared.loops,
          state_->shared.mutex.LongestWaitSeconds(),
          state_->calibration,
          state_->Rolling()};
}

const CameraModel& Tracker::camera() const { return state_->camera; }

}  // namespace ulf
