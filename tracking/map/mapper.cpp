#include "tracking/map/mapper.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "core/base/signal_stack.h"
#include "tracking/map/loop_closer.h"
#include "tracking/map/map_adjustment.h"
#include "tracking/tracker/readout_estimator.h"

namespace ulf::tracking {
namespace {

using Eigen::Vector3d;

constexpr int kTriangulateWith = 8;  // neighbours
constexpr int kFuseWith = 12;
constexpr int kLocalKeyframes = 14;
constexpr int kHeldKeyframes = 20;
// Of the whole map's adjustments: while it grows each takes up the one before, a loop and the end start far.
const BundleOptions kAtWork{.robust_iterations = 5, .iterations = 10};
const BundleOptions kAtRest{.robust_iterations = 10, .iterations = 40};
// A map in the making needs even the measurements that are a little off; a finished one does not.
const BundleOptions kAtTheEnd{.robust_iterations = 10, .iterations = 40, .cauchy_scales = 2};

}  // namespace

Mapper::Mapper(const CameraModel& camera, SharedMap& shared, KeyframeIndex& index, bool synchronous,
               const MapperOptions& options, unsigned seed)
    : camera_(camera),
      shared_(shared),
      map_(shared.ReadByOwner()),
      index_(index),
      synchronous_(synchronous),
      loops_(std::make_unique<LoopCloser>(camera, shared, index, LoopOptions{.seed = seed})),
      options_(options) {
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

void Mapper::Rest() {
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

void Mapper::AdjustSoon() {
  after_loop_ = true;  // as much has moved
  if (synchronous_) return AdjustInBackground();
  {
    const MutexLock lock(work_mutex_);
    owed_ = true;
  }
  changed_.notify_all();
}

void Mapper::Run() {
  HaveSignalStack();
  shared_.owner = std::this_thread::get_id();
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
  const int newest = Insert(offered);
  CullRecentPoints(newest);
  Triangulate(newest, Neighbours(newest, kTriangulateWith));
  const auto triangulated = Clock::now();
  Fuse(newest, Neighbours(newest, kFuseWith));
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

void Mapper::StartFromTwoViews(const TwoViewStart& start, double scale, const cv::Mat& color) {
  const auto keyframe_of = [](const TrackedImage& image, const Rigid3& pose,
                              const std::optional<Twist>& velocity) {
    Keyframe keyframe;
    keyframe.velocity = velocity;
    keyframe.time_s = image.time_s;
    keyframe.features = image.features;
    keyframe.pyramid = image.pyramid;
    keyframe.cam_from_world = pose;
    // The map's unit is not the corners' yet: where rows had to be shifted nobody knows how far.
    if (image.fiducials && !image.pyramid->rows) keyframe.corners = image.fiducials->corners;
    return keyframe;
  };
  int first, second;
  {
    const MapLock lock(shared_);
    first = shared_.map.AddKeyframe(keyframe_of(start.first, Rigid3{}, start.first_velocity));
    Rigid3 second_from_first = start.second_from_first;
    second_from_first.translation *= scale;
    second = shared_.map.AddKeyframe(keyframe_of(start.second, second_from_first, start.second_velocity));
    shared_.map.keyframe(second).color = color;
    for (std::size_t i = 0; i < start.matches.size(); ++i) {
      const FeatureMatch& match = start.matches[i];
      const Feature &a = (*start.first.features)[match.first], &b = (*start.second.features)[match.second];
      CommitPoint(scale * start.points[i], {second, match.second, b.img, DetectedSigmaPx(b.level)},
                  {first, match.first, a.img, DetectedSigmaPx(a.level)});
    }
  }
  AdjustMap(camera_, shared_, {first, second}, {}, {.robust_iterations = 15, .iterations = 15});
  // Adjustment changes depths: normalise again so that the median is one.
  const double again = 1 / MedianDepth(first);
  {
    const MapLock lock(shared_);
    shared_.map.keyframe(second).cam_from_world.translation *= again;
    for (const int point : std::vector<int>(map_.keyframe(first).point_of_feature)) {
      if (point < 0) continue;
      shared_.map.point(point).position *= again;
      shared_.map.Update(point);
    }
  }
  for (const int keyframe : {first, second}) {
    const MapLock lock(shared_);
    shared_.map.keyframe(keyframe).points_at_birth = map_.keyframe(keyframe).points;
  }
  index_.Add(map_.keyframe(first));
  index_.Add(map_.keyframe(second));
}

void Mapper::AddSeed(NewKeyframe keyframe) {
  keyframe.keyframe.pinned = true;
  const int newest = Insert(keyframe);
  const std::vector<int> neighbours = NeighboursByPose(newest, kTriangulateWith);
  Triangulate(newest, neighbours);
  Fuse(newest, neighbours);
  // Only points move, and now and then is enough for matching: it is what costs most.
  constexpr int kSeedsBetween = 8;
  if (newest % kSeedsBetween == kSeedsBetween - 1) AdjustLocal(newest, false);
  index_.Add(map_.keyframe(newest));
}

void Mapper::FinishSeeds() {
  AdjustMap(camera_, shared_, {}, map_.living(), {.robust_iterations = 10, .iterations = 10});
}

void Mapper::MoveWorld(const Similarity3& given_from_map) {
  const MapLock lock(shared_);
  std::vector<std::pair<int, Similarity3>> moved;
  for (const int id : map_.living())
    moved.emplace_back(id,
                       Similarity3::FromRigid(map_.keyframe(id).cam_from_world) * given_from_map.Inverse());
  MoveMap(shared_.map, moved);
  loops_->Reset();
  shared_.world_given = true;
}

void Mapper::Reset() {
  const MapLock lock(shared_);
  shared_.map.Clear();
  shared_.world_given = false;
  index_.Clear();
  recent_points_.clear();
  loops_->Reset();
  adjust_all_at_ = 0;
  after_loop_ = false;
}

std::vector<int> Mapper::Neighbours(int keyframe, int most) const {
  std::vector<int> chosen;
  for (const Map::Neighbour& neighbour : map_.Covisible(keyframe, 12)) {
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
    if (cosine < 0.5) continue;
    ranked.emplace_back((other.cam_from_world.OriginInSource() - pose.OriginInSource()).norm(), other.id);
  }
  std::sort(ranked.begin(), ranked.end());
  std::vector<int> chosen;
  for (const auto& [distance, keyframe] : ranked)
    if (static_cast<int>(chosen.size()) < most) chosen.push_back(keyframe);
  return chosen;
}

void Mapper::CullRecentPoints(int newest) {
  const MapLock lock(shared_);
  std::erase_if(recent_points_, [&](int id) ULF_REQUIRES(shared_.mutex) {
    const MapPoint& point = map_.point(id);
    if (!point.alive) return true;
    const int age = newest - point.first_keyframe;
    const bool seldom_found = point.expected >= 8 && point.found < options_.min_found_share * point.expected;
    const bool never_confirmed = age >= 3 && point.observations.size() <= 2;
    if (seldom_found || never_confirmed) {
      shared_.map.RemovePoint(id);
      return true;
    }
    return age >= 4;
  });
}

void Mapper::AdjustLocal(int newest, bool poses_too) {
  std::vector<int> local{newest};
  for (const int neighbour : Neighbours(newest, kLocalKeyframes - 1)) local.push_back(neighbour);
  std::unordered_map<int, int> shares;
  const std::unordered_set<int> in_local(local.begin(), local.end());
  std::unordered_set<int> visited;
  for (const int keyframe : local)
    for (const int point : map_.keyframe(keyframe).point_of_feature) {
      if (point < 0 || !visited.insert(point).second) continue;
      for (const Observation& o : map_.point(point).observations)
        if (!in_local.contains(o.keyframe)) ++shares[o.keyframe];
    }
  std::vector<std::pair<int, int>> ranked;
  for (const auto& [keyframe, count] : shares) ranked.emplace_back(-count, keyframe);
  std::sort(ranked.begin(), ranked.end());
  std::vector<int> held;
  for (const auto& [count, keyframe] : ranked)
    if (static_cast<int>(held.size()) < kHeldKeyframes) held.push_back(keyframe);
  if (!poses_too) {
    held.insert(held.end(), local.begin(), local.end());
    local.clear();
  }
  AdjustMap(camera_, shared_, local, held, {.robust_iterations = 4, .iterations = 6});
}

// Whether it is time for another adjustment of everything.
bool Mapper::IsDue() {
  const int now = map_.LivingKeyframes();
  if (now <= 3 || (now < adjust_all_at_ && !after_loop_)) return false;
  adjust_all_at_ = std::max(now + 1, static_cast<int>(std::lround(now * options_.adjust_all_growth)));
  return true;
}

// A closed loop moves much: its poses are worth asking for again when they have settled.
void Mapper::AdjustInBackground() {
  if (!after_loop_) {
    AdjustWhole(kAtWork);
    return;
  }
  AdjustWhole(kAtRest);
  if (cut_short_) return;
  after_loop_ = false;
  ++shared_.revision;
}

void Mapper::AdjustAll() {
  cut_short_ = false;
  AdjustWhole(kAtTheEnd);
}

void Mapper::AdjustWhole(const BundleOptions& options) {
  const std::vector<int> all = map_.living();
  if (all.size() < 2) return;
  BundleOptions stoppable = options;
  stoppable.stop = &cut_short_;
  AdjustMap(camera_, shared_, all, {}, stoppable);
  if (!shared_.measure_readout || cut_short_) return;
  const auto readout = EstimateReadout(camera_, map_);
  const MapLock lock(shared_);
  shared_.readout = readout;
  ++shared_.readouts_measured;
}

// A keyframe is superfluous when nine tenths of its points are seen as well by three others.
void Mapper::CullKeyframes(int newest) {
  for (const int id : Neighbours(newest, kLocalKeyframes)) {
    const Keyframe& keyframe = map_.keyframe(id);
    if (id == map_.FirstKeyframe() || id >= newest - 2 || keyframe.pinned) continue;
    int total = 0, redundant = 0;
    for (int i = 0; i < keyframe.features->size(); ++i) {
      const int point = keyframe.point_of_feature[static_cast<std::size_t>(i)];
      if (point < 0) continue;
      ++total;
      const int level = (*keyframe.features)[i].level;
      int others = 0;
      for (const Observation& o : map_.point(point).observations)
        if (o.keyframe != id && (*map_.keyframe(o.keyframe).features)[o.feature].level <= level + 1) ++others;
      redundant += others >= 3;
    }
    if (redundant <= options_.superfluous_share * total) continue;
    index_.Remove(id);
    const MapLock lock(shared_);
    shared_.map.RemoveKeyframe(id);
  }
}

}  // namespace ulf::tracking
