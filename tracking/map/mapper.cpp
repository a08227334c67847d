#include "tracking/map/mapper.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "core/base/at.h"
#include "core/base/stop_signal.h"
#include "tracking/map/loop_closer.h"
#include "tracking/map/map_adjustment.h"
#include "tracking/map/map_matching.h"
#include "tracking/map/map_rows.h"
#include "tracking/map/readout_estimator.h"

namespace ulf::tracking {
namespace {

using Eigen::Vector3d;

// A keyframe is superfluous when most of its points (MapperOptions::superfluous_share) are seen by so many
// others, on the same pyramid level, a finer one, or the next coarser one. The newest keyframes stay.
// Guessed.
constexpr int kMapperSuperfluousOthers = 3;
constexpr int kMapperNewestKept = 2;
// A point is removed within its first keyframes when it is found too seldom (MapperOptions::min_found_share)
// in the frames that should show it, once those are enough to tell, or when no third keyframe sees it at the
// first of these ages. Ages are keyframes since the point was made. Guessed.
constexpr int kMapperMinExpected = 8;
constexpr int kMapperConfirmedAge = 3, kMapperSettledAge = 4;
// Neighbours that points are made with, and merged with: the keyframes that share most points, at least so
// many. More cost time. Guessed.
constexpr int kMapperTriangulateWith = 8, kMapperFuseWith = 12, kMapperMinShared = 12;
// The adjustment of a new keyframe's neighbourhood: keyframes that hold the ones that move, and its effort.
// Guessed.
constexpr int kMapperHeldKeyframes = 20;
constexpr AdjustmentEffort kLocalAdjustment = {4, 6};
// The whole map is adjusted when it has grown by this factor since it last was. Guessed.
constexpr double kMapperAdjustAllGrowth = 1.1;
// The efforts of the adjustments of a map's two first views; of a growing map, where each adjustment
// continues the one before; after a closed loop and at the end, which start far off; of a map made from given
// poses. Guessed.
constexpr AdjustmentEffort kTwoViewsAdjustment = {15, 15}, kGrowingAdjustment = {5, 10},
                           kMovedAdjustment = {10, 40}, kSeededAdjustment = {10, 10};
// A growing map needs even measurements that are a little off; a finished one does not: at the end
// Cauchy's loss begins to doubt at so many times the errors' own scale. Measured (docs/measured/tracking.md,
// "Cauchy's loss").
constexpr double kMapperFinalCauchyScales = 2;
// A map made from given poses: neighbours look the same way (as a cosine), and points are adjusted after so
// many views. Guessed.
constexpr double kMapperSeedMinCosine = 0.5;
constexpr int kMapperSeedsBetweenAdjustments = 8;

}  // namespace

Mapper::Mapper(const CameraModel& camera, Map map, bool synchronous, const MapperOptions& options,
               unsigned seed)
    : camera_(camera),
      owned_(std::move(map)),
      index_(seed),
      synchronous_(synchronous),
      loops_(std::make_unique<LoopCloser>(camera, owned_, index_, seed)),
      options_(options) {
  for (const int id : map_.living()) index_.Add(map_.keyframe(id));
  if (!synchronous_) thread_ = std::thread([this] { Run(); });
}

Mapper::~Mapper() {
  {
    const MutexLock lock(work_mutex_);
    ending_ = true;
    cut_short_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

bool Mapper::Take(FrameReport report) {
  {
    const MapLock lock(owned_.shared);
    Map& map = owned_.map;
    for (const int point : report.expected) ++map.point(point).expected;
    for (const int point : report.found) ++map.point(point).found;
    if (report.velocity && !map.living().empty())
      if (Keyframe& newest = map.keyframe(map.living().back()); newest.time_s == report.velocity->time_s)
        newest.velocity = report.velocity->velocity;
  }
  return !report.keyframe || Offer(std::move(*report.keyframe));
}

void Mapper::NoteView(int view_id, std::span<const MapObservation> seen) {
  const MapLock lock(owned_.shared);
  for (const MapObservation& o : seen)
    // The point may have been merged or removed since.
    if (const int point = map_.Resolve(o.point); point >= 0) owned_.map.AddView(point, {view_id, o.img});
}

void Mapper::SetReadout(double readout_s) {
  WaitUntilIdle();
  {
    const MapLock lock(owned_.shared);
    GiveRows(camera_, owned_.map, readout_s);
    ++owned_.shared.revision;
  }
  RequestFullAdjustment();
}

bool Mapper::Offer(NewKeyframe keyframe) {
  if (synchronous_) {
    Process(keyframe);
    if (IsDue()) AdjustInBackground();
    return true;
  }
  {
    const MutexLock lock(work_mutex_);
    ThrowFailure();
    if (next_ || (working_ && !in_background_)) return false;
    next_ = std::move(keyframe);
    cut_short_ = in_background_;
  }
  changed_.notify_all();
  return true;
}

void Mapper::Drain() {
  MutexLock lock(work_mutex_);
  changed_.wait(lock, [this]() ULF_REQUIRES(work_mutex_) { return !next_ && !working_ && !owed_; });
  ThrowFailure();
}

void Mapper::WaitUntilIdle() {
  MutexLock lock(work_mutex_);
  changed_.wait(lock, [this]() ULF_REQUIRES(work_mutex_) {
    if (!next_) owed_ = false;
    cut_short_ = in_background_;
    return !next_ && !working_;
  });
  ThrowFailure();
}

void Mapper::ThrowFailure() {
  if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
}

void Mapper::RequestFullAdjustment() {
  after_loop_ = true;  // as after a loop, much has moved
  if (synchronous_) return AdjustInBackground();
  {
    const MutexLock lock(work_mutex_);
    owed_ = true;
  }
  changed_.notify_all();
}

void Mapper::Run() {
  InstallSignalStack();
  owned_.shared.owner = std::this_thread::get_id();
  MutexLock lock(work_mutex_);
  while (true) {
    changed_.wait(lock, [this]() ULF_REQUIRES(work_mutex_) { return ending_ || next_ || owed_; });
    if (ending_) return;
    std::optional<NewKeyframe> keyframe = std::exchange(next_, std::nullopt);
    working_ = true;
    in_background_ = !keyframe;
    cut_short_ = false;
    lock.unlock();
    std::exception_ptr failure;
    bool due = false;
    try {
      if (keyframe)
        Process(*keyframe);
      else
        AdjustInBackground();
      due = keyframe && IsDue();
    } catch (...) {
      failure = std::current_exception();
    }
    lock.lock();
    if (failure) failure_ = failure;
    if (keyframe)
      owed_ = owed_ || due;
    else
      owed_ = owed_ && cut_short_ && !failure;
    working_ = in_background_ = false;
    changed_.notify_all();
  }
}

void Mapper::Process(NewKeyframe& offered) {
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  if (offered.joins != owned_.shared.joins) return;
  const int newest = Insert(offered);
  CullRecentPoints(newest);
  Triangulate(newest, Neighbours(newest, kMapperTriangulateWith));
  const auto triangulated = Clock::now();
  Fuse(newest, Neighbours(newest, kMapperFuseWith));
  const auto fused = Clock::now();
  AdjustLocal(newest, true);
  const auto adjusted = Clock::now();
  CullKeyframes(newest);
  if (const auto loop = loops_->Examine(newest)) {
    for (const int recent : loop->recent) Fuse(recent, loop->old);
    after_loop_ = true;
  }
  index_.Add(map_.keyframe(newest));
  const auto ms = [](auto from, auto to) {
    return std::chrono::duration<double, std::milli>(to - from).count();
  };
  spdlog::debug("keyframe {}: {:.1f} ms to triangulate, {:.1f} to merge, {:.1f} to adjust, {:.1f} to clean",
                newest, ms(start, triangulated), ms(triangulated, fused), ms(fused, adjusted),
                ms(adjusted, Clock::now()));
}

int Mapper::StartFromTwoViews(const TwoViewStart& start, double scale, const cv::Mat& color) {
  int part;
  {
    const MapLock lock(owned_.shared);
    part = owned_.map.BeginPart();
    if (map_.living().empty()) owned_.map.SetMainPart(part);
  }
  const auto keyframe_of = [&](const TrackedImage& image, const Rigid3& pose,
                               const std::optional<Twist>& velocity) {
    Keyframe keyframe;
    keyframe.part = part;
    keyframe.velocity = velocity;
    keyframe.time_s = image.time_s;
    keyframe.features = image.features;
    keyframe.pyramid = image.pyramid;
    keyframe.cam_from_world = pose;
    // With rows, corners are left out: their unit is not the map's, so the rows' motion cannot be removed.
    if (image.fiducials && !image.pyramid->rows) keyframe.corners = image.fiducials->corners;
    return keyframe;
  };
  int first, second;
  {
    const MapLock lock(owned_.shared);
    first = owned_.map.AddKeyframe(keyframe_of(start.first, Rigid3{}, start.first_velocity));
    Rigid3 second_from_first = start.second_from_first;
    second_from_first.translation *= scale;
    second = owned_.map.AddKeyframe(keyframe_of(start.second, second_from_first, start.second_velocity));
    owned_.map.keyframe(second).color = color;
    for (std::size_t i = 0; i < start.matches.size(); ++i) {
      const FeatureMatch& match = start.matches[i];
      const Feature &a = (*start.first.features)[match.first], &b = (*start.second.features)[match.second];
      CommitPoint(scale * start.points[i], {second, match.second, b.img, DetectedSigmaPx(b.level)},
                  {first, match.first, a.img, DetectedSigmaPx(a.level)});
    }
  }
  AdjustMap(camera_, owned_, {first, second}, {}, BundleOptionsFor(kTwoViewsAdjustment));
  // The adjustment has changed depths: scale the median to one again.
  const double again = 1 / map_.MedianDepth(first);
  {
    const MapLock lock(owned_.shared);
    owned_.map.keyframe(second).cam_from_world.translation *= again;
    for (const int point : map_.PointsSeenBy(first)) {
      owned_.map.point(point).position *= again;
      owned_.map.Update(point);
    }
    for (const int id : {first, second}) {
      Keyframe& keyframe = owned_.map.keyframe(id);
      keyframe.points_at_birth = keyframe.points;
      if (keyframe.velocity) keyframe.velocity->tail<3>() *= again;
      if (keyframe.expected_twist) keyframe.expected_twist->tail<3>() *= again;
      if (keyframe.rows) keyframe.rows = std::make_shared<const RowShift>(keyframe.rows->Scaled(again));
    }
  }
  index_.Add(map_.keyframe(first));
  index_.Add(map_.keyframe(second));
  return part;
}

void Mapper::AddSeed(NewKeyframe keyframe) {
  keyframe.keyframe.pinned = true;
  if (map_.living().empty()) {
    const MapLock lock(owned_.shared);
    keyframe.keyframe.part = owned_.map.BeginPart();
    owned_.map.SetMainPart(keyframe.keyframe.part);
  } else {
    keyframe.keyframe.part = map_.main_part();
  }
  const int newest = Insert(keyframe);
  const std::vector<int> neighbours = NeighboursByPose(newest, kMapperTriangulateWith);
  Triangulate(newest, neighbours);
  Fuse(newest, neighbours);
  // Adjusts the points alone: matching needs no more, and adjustments cost most of the time.
  if (const int between = kMapperSeedsBetweenAdjustments; newest % between == between - 1)
    AdjustLocal(newest, false);
  index_.Add(map_.keyframe(newest));
}

bool Mapper::FinishSeeds(int min_points) {
  AdjustMap(camera_, owned_, {}, map_.living(), BundleOptionsFor(kSeededAdjustment));
  if (map_.LivingPoints() < min_points) return false;
  // Derive the points' find rates from the views. Without them every point would have a rate of one half, and
  // the tracker would refuse the first frame, which shows fewer.
  const MapLock lock(owned_.shared);
  for (const Keyframe& keyframe : map_.keyframes())
    for (const Candidate& candidate :
         GatherCandidates(map_, camera_, keyframe.cam_from_world, map_.main_part()))
      ++owned_.map.point(candidate.id).expected;
  for (const MapPoint& point : map_.points())
    owned_.map.point(point.id).found = static_cast<int>(point.observations.size());
  return true;
}

void Mapper::MoveWorld(const Similarity3& given_from_map) {
  const MapLock lock(owned_.shared);
  std::vector<std::pair<int, Similarity3>> moved;
  for (const int id : map_.living())
    moved.emplace_back(id,
                       Similarity3::FromRigid(map_.keyframe(id).cam_from_world) * given_from_map.Inverse());
  MoveMap(owned_.map, moved);
  loops_->Reset();
  owned_.shared.world_given = true;
}

void Mapper::SetMainPart(int part) {
  const MapLock lock(owned_.shared);
  owned_.map.SetMainPart(part);
}

void Mapper::RemovePart(int part) {
  for (const int id : map_.LivingOf(part)) index_.Remove(id);
  {
    const MapLock lock(owned_.shared);
    owned_.map.RemovePart(part);
  }
  std::erase_if(recent_points_, [&](int id) { return !map_.point(id).alive; });
  adjust_all_at_.erase(part);
  if (map_.living().empty()) Reset();
}

void Mapper::Reset() {
  const MapLock lock(owned_.shared);
  owned_.shared.world_given = false;
  index_.Clear();
  recent_points_.clear();
  loops_->Reset();
  lens_.Reset();
  owned_.shared.wrong_lens.reset();
  owned_.shared.lens_is_due = false;
  adjust_all_at_.clear();
  after_loop_ = false;
}

std::vector<int> Mapper::Neighbours(int keyframe, int most) const {
  std::vector<int> chosen;
  for (const Map::Neighbour& neighbour : map_.Covisible(keyframe, kMapperMinShared)) {
    if (static_cast<int>(chosen.size()) >= most) break;
    chosen.push_back(neighbour.keyframe);
  }
  return chosen;
}

std::vector<int> Mapper::NeighboursByPose(int id, int most) const {
  const Rigid3& pose = map_.keyframe(id).cam_from_world;
  std::vector<std::pair<double, int>> ranked;
  for (const int other_id : map_.living()) {
    if (other_id == id) continue;
    const Keyframe& other = map_.keyframe(other_id);
    const double cosine = other.cam_from_world.DirectionInSource(Vector3d::UnitZ())
                              .dot(pose.DirectionInSource(Vector3d::UnitZ()));
    if (cosine < kMapperSeedMinCosine) continue;
    ranked.emplace_back((other.cam_from_world.OriginInSource() - pose.OriginInSource()).norm(), other.id);
  }
  std::ranges::sort(ranked);
  std::vector<int> chosen;
  for (const auto& [distance, keyframe] : ranked)
    if (static_cast<int>(chosen.size()) < most) chosen.push_back(keyframe);
  return chosen;
}

void Mapper::CullRecentPoints(int newest) {
  const MapLock lock(owned_.shared);
  std::erase_if(recent_points_, [&](int id) ULF_REQUIRES(owned_.shared.mutex) {
    const MapPoint& point = map_.point(id);
    if (!point.alive) return true;
    const int age = newest - point.first_keyframe;
    const bool seldom_found =
        point.expected >= kMapperMinExpected && point.found < options_.min_found_share * point.expected;
    const bool never_confirmed = age >= kMapperConfirmedAge && point.observations.size() <= 2;
    if (seldom_found || never_confirmed) {
      owned_.map.RemovePoint(id);
      return true;
    }
    return age >= kMapperSettledAge;
  });
}

void Mapper::AdjustLocal(int newest, bool poses_too) {
  std::vector<int> local{newest};
  for (const int neighbour : Neighbours(newest, options_.local_keyframes - 1)) local.push_back(neighbour);
  std::unordered_map<int, int> shares;
  const std::unordered_set<int> in_local(local.begin(), local.end());
  std::unordered_set<int> visited;
  for (const int keyframe : local)
    for (const int point : map_.PointsSeenBy(keyframe)) {
      if (!visited.insert(point).second) continue;
      for (const Observation& o : map_.point(point).observations)
        if (!in_local.contains(o.keyframe)) ++shares[o.keyframe];
    }
  std::vector<std::pair<int, int>> ranked;
  for (const auto& [keyframe, count] : shares) ranked.emplace_back(-count, keyframe);
  std::ranges::sort(ranked);
  std::vector<int> held;
  for (const auto& [count, keyframe] : ranked)
    if (static_cast<int>(held.size()) < kMapperHeldKeyframes) held.push_back(keyframe);
  if (!poses_too) {
    held.insert(held.end(), local.begin(), local.end());
    local.clear();
  }
  AdjustMap(camera_, owned_, local, held, BundleOptionsFor(kLocalAdjustment));
}

// Returns the part that the camera is in.
int Mapper::PartInWork() const { return map_.keyframe(map_.living().back()).part; }

// Returns whether another adjustment of everything is due.
bool Mapper::IsDue() {
  if (map_.living().empty()) return false;
  const int part = PartInWork(), now = static_cast<int>(map_.LivingOf(part).size());
  if (now <= 3 || (now < adjust_all_at_[part] && !after_loop_)) return false;
  adjust_all_at_[part] = std::max(now + 1, static_cast<int>(std::lround(now * kMapperAdjustAllGrowth)));
  return true;
}

// A closed loop moves much: after its adjustment, users should ask for kept poses again (revision).
void Mapper::AdjustInBackground() {
  const bool moved = after_loop_;
  if (map_.living().empty()) return;
  AdjustWhole(PartInWork(), BundleOptionsFor(moved ? kMovedAdjustment : kGrowingAdjustment));
  if (cut_short_) return;
  if (moved) {
    after_loop_ = false;
    ++owned_.shared.revision;
  }
  CheckLens();
}

BundleOptions Mapper::BundleOptionsFor(const AdjustmentEffort& effort) const {
  return {.robust_iterations = effort.robust_iterations,
          .iterations = effort.iterations,
          .dense_cameras = options_.dense_cameras};
}

void Mapper::AdjustAll() {
  cut_short_ = false;
  BundleOptions last = BundleOptionsFor(kMovedAdjustment);
  last.cauchy_scales = kMapperFinalCauchyScales;
  for (const int part : map_.Parts()) AdjustWhole(part, last);
}

void Mapper::AdjustWhole(int part, const BundleOptions& options) {
  const std::vector<int> all = map_.LivingOf(part);
  if (all.size() < 2) return;
  BundleOptions stoppable = options;
  stoppable.stop = &cut_short_;
  AdjustMap(camera_, owned_, all, {}, stoppable, true);
  if (!measure_readout_ || cut_short_) return;
  const auto readout = EstimateReadout(camera_, map_);
  const MapLock lock(owned_.shared);
  owned_.shared.readout = readout;
  ++owned_.shared.readouts_measured;
}

void Mapper::CullKeyframes(int newest) {
  for (const int id : Neighbours(newest, options_.local_keyframes)) {
    const Keyframe& keyframe = map_.keyframe(id);
    if (id == map_.FirstKeyframe(keyframe.part) || id >= newest - kMapperNewestKept || keyframe.pinned)
      continue;
    int total = 0, redundant = 0;
    for (int i = 0; i < keyframe.features->size(); ++i) {
      const int point = keyframe.point_of_feature[At(i)];
      if (point < 0) continue;
      ++total;
      const int level = (*keyframe.features)[i].level;
      int others = 0;
      for (const Observation& o : map_.point(point).observations)
        if (o.keyframe != id && (*map_.keyframe(o.keyframe).features)[o.feature].level <= level + 1) ++others;
      redundant += others >= kMapperSuperfluousOthers;
    }
    if (redundant <= options_.superfluous_share * total) continue;
    index_.Remove(id);
    const MapLock lock(owned_.shared);
    owned_.map.RemoveKeyframe(id);
  }
}

}  // namespace ulf::tracking
