#include "coverage/session/record/live_geometry.h"

#include <fmt/format.h>
#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <exception>
#include <iterator>
#include <limits>
#include <utility>

#include "core/base/host_time.h"
#include "core/base/parallel_for.h"
#include "core/base/stop_signal.h"
#include "render/proxy/mesh_file.h"
#include "render/proxy/subject_in_mesh.h"
#include "render/stereo/mesh_of_maps.h"

namespace ulf::coverage {
namespace {

// About, of meshes while the capture goes on: they are drawn at every frame (coverage/measured). Guessed.
constexpr int kLiveTriangles = 30000;

// If the kernel refuses, the thread stays as it is.
void SetPolicy(std::thread& thread, int policy) {
  const sched_param none{};
  pthread_setschedparam(thread.native_handle(), policy, &none);
}

}  // namespace

LiveGeometry::LiveGeometry(const Options& options)
    : options_(options),
      world_{render::GrowingGeometry(options.growing), std::nullopt},
      maker_(options.growing.size_px) {
  if (!options_.threaded) return;
  thread_ = std::thread([this] { Loop(); });
  if (options_.gives_way) SetPolicy(thread_, SCHED_IDLE);
}

LiveGeometry::~LiveGeometry() {
  EndThread(0);
  if (thread_.joinable()) thread_.join();
}

void LiveGeometry::EndThread(double most_s) {
  if (!thread_.joinable()) return;
  // This precedes the lock, which the thread may hold.
  SetPolicy(thread_, SCHED_OTHER);
  given_up_ = true;
  MutexLock lock(mutex_);
  over_ = true;
  changed_.notify_all();
  changed_.wait_for(lock, std::chrono::duration<double>(most_s),
                    [this]() ULF_REQUIRES(mutex_) { return ended_; });
}

void LiveGeometry::Do(PendingChange coming) {
  if (options_.threaded) {
    to_hand_over_.push_back(std::move(coming));
    PassToThread();
  } else if (const Change change = Prepare(coming, maker_)) {
    change(world_);
  }
}

void LiveGeometry::Do(Change change) {
  Do(PendingChange{std::nullopt, [change = std::move(change)](render::StereoViewMaker&) { return change; }});
}

void LiveGeometry::AcceptChanges() {
  if (!over_) std::ranges::move(to_hand_over_, std::back_inserter(changes_));
  to_hand_over_.clear();
  seen_ = state_;
  if (seen_.mesh && seen_.mesh->lens != lens_)
    seen_.mesh.reset();  // the thread has not come to StartAgain() yet
  if (problem_) problem_seen_ = std::exchange(problem_, std::nullopt);
}

void LiveGeometry::PassToThread() {
  if (!mutex_.try_lock()) return;
  AcceptChanges();
  mutex_.unlock();
  changed_.notify_all();
}

void LiveGeometry::SetSubject(const Subject& subject) {
  Do([subject](World& world) {
    world.subject = subject;
    world.growing.SetSubject(subject);
  });
}

void LiveGeometry::AddView(int id, ReadPicture picture, const CameraModel& camera,
                           const Rigid3& cam_from_world, Picture where) {
  first_poses_[id] = cam_from_world;
  const auto shared = std::make_shared<const ReadPicture>(std::move(picture));
  if (where == Picture::kIsHeld && options_.threaded) {
    std::erase_if(held_, [](const auto& held) { return held.expired(); });
    if (held_.size() >= options_.most_waiting) {
      if (left_out_views_.empty())
        problem_seen_ = {
            {},
            fmt::format("geometry: the processor has too little time for it: view {} is left out, and so is "
                        "every view that comes while {} others wait; '{}' makes a mesh of all",
                        id, options_.most_waiting, render::ProxyCommand(options_.light_field))};
      left_out_views_.insert(id);
      return;
    }
    held_.push_back(shared);
  }
  Do(PendingChange{id, [id, shared, camera, cam_from_world](render::StereoViewMaker& maker) -> Change {
                     auto view = std::make_shared<render::StereoView>(
                         maker.Make((*shared)(), camera, cam_from_world));
                     return [id, view](World& world) { world.growing.AddView(id, std::move(*view)); };
                   }});
}

void LiveGeometry::RemoveView(int id) {
  corrected_ = true;
  left_out_views_.erase(id);
  removed_.insert(id);
  Do([id](World& world) { world.growing.RemoveView(id); });
}

void LiveGeometry::MoveViews(const std::map<int, Rigid3>& cam_from_world) {
  constexpr double kRounding = 1e-6;
  for (const auto& [id, pose] : cam_from_world)
    if (const auto first = first_poses_.find(id); first != first_poses_.end())
      corrected_ |= pose.rotation.angularDistance(first->second.rotation) > kRounding ||
                    (pose.translation - first->second.translation).norm() >
                        kRounding * (1 + first->second.translation.norm());
  Do([cam_from_world](World& world) { world.growing.MoveViews(cam_from_world); });
}

void LiveGeometry::AddMaps(std::function<std::vector<KnownMap>()> read) {
  Do(PendingChange{{}, [read = std::move(read)](render::StereoViewMaker&) -> Change {
                     return [maps = read()](World& world) {
                       for (const KnownMap& map : maps)
                         world.growing.TakeMap(map.view_id, map.camera, map.depth, map.plane_step);
                     };
                   }});
}

void LiveGeometry::StartAgain() {
  corrected_ = true;
  left_out_views_.clear();
  seen_.mesh.reset();
  Do([lens = ++lens_](World& world) {
    world.lens = lens;
    world.growing = render::GrowingGeometry(world.growing.options());
    if (world.subject) world.growing.SetSubject(*world.subject);
  });
}

const LiveGeometryState& LiveGeometry::State() {
  PassToThread();
  return seen_;
}

void LiveGeometry::Fail(const std::string& what) {
  if (failed_.exchange(true)) return;
  const MutexLock lock(mutex_);
  problem_ = {{},
              fmt::format("geometry: {}; the capture goes on without it, '{}' makes it afterwards", what,
                          render::ProxyCommand(options_.light_field))};
}

// One view's picture cannot be read: the others make the geometry.
void LiveGeometry::LeaveOut(int id, const std::string& why) {
  const MutexLock lock(mutex_);
  unreadable_.insert(id);
  if (left_out_.exchange(true)) return;
  problem_ = {
      id, fmt::format("geometry: {}; it is made without view {}, and without others that cannot be read", why,
                      id)};
}

std::optional<std::string> LiveGeometry::TakeProblem() {
  PassToThread();
  const std::optional<Problem> problem = std::exchange(problem_seen_, std::nullopt);
  if (!problem) return std::nullopt;
  if (!problem->view || !removed_.contains(*problem->view)) return problem->words;
  left_out_ = false;  // what else cannot be read is still to be said
  return std::nullopt;
}

// It is empty where the view is left out, or geometry has failed.
LiveGeometry::Change LiveGeometry::Prepare(const PendingChange& coming, render::StereoViewMaker& maker) {
  try {
    return coming.prepare(maker);
  } catch (const std::exception& error) {
    if (coming.view)
      LeaveOut(*coming.view, error.what());
    else
      Fail(error.what());
    return nullptr;
  }
}

LiveGeometry::Meshed LiveGeometry::MakeMesh(const World& world, MeshFor what_for) const {
  render::MapsMeshOptions options = options_.growing.mesh;
  options.in_this_thread = what_for == MeshFor::kNow;
  if (what_for == MeshFor::kNow) options.most_triangles = std::min(options.most_triangles, kLiveTriangles);
  const std::vector<render::ViewDepth> maps = world.growing.Maps();
  Meshed meshed{nullptr, world.growing.MapPoses()};
  render::MapsMesh made = render::MeshOfMaps(maps, *world.subject, options);
  if (made.mesh.triangles.empty()) return meshed;
  auto mesh = std::make_shared<LiveMesh>();
  mesh->subject = *world.subject;
  mesh->lens = world.lens;
  mesh->mesh = std::make_shared<const render::TriangleMesh>(std::move(made.mesh));
  mesh->maps = static_cast<int>(maps.size());
  if (what_for == MeshFor::kNow) mesh->subject_seen = render::SubjectInMesh(*mesh->mesh, *world.subject);
  meshed.mesh = std::move(mesh);
  return meshed;
}

bool LiveGeometry::WaitsForMesh() const {
  return poses_of_mesh_ && world_.growing.maps() >= options_.first_mesh_maps &&
         world_.growing.HaveMovedSince(*poses_of_mesh_, kMoved_px);
}

bool LiveGeometry::IsMeshDue() const {
  const int maps = world_.growing.maps();
  if (!world_.subject || maps < options_.first_mesh_maps) return false;
  const double before = poses_of_mesh_ ? static_cast<double>(poses_of_mesh_->size()) : 0;
  return maps >= static_cast<int>(options_.more_maps * before) ||
         (WaitsForMesh() && (!options_.threaded || Clock::now() >= next_mesh_));
}

// Both return false where it is over: the world is Finish()'s then.
bool LiveGeometry::KeepMesh(Meshed made) {
  const MutexLock lock(mutex_);
  if (over_) return false;
  poses_of_mesh_ = std::move(made.poses);
  next_mesh_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                  std::chrono::duration<double>(options_.between_meshes_s));
  state_.mesh = std::move(made.mesh);
  return true;
}

bool LiveGeometry::KeepMap(render::GrowingGeometry::NewMap map) {
  const MutexLock lock(mutex_);
  if (over_) return false;
  world_.growing.Keep(std::move(map));
  return true;
}

// Makes one map or one mesh. Returns false when there is nothing to make.
bool LiveGeometry::Work() {
  if (IsMeshDue()) return KeepMesh(MakeMesh(world_, MeshFor::kNow));
  auto map = world_.growing.NextMap(false, &given_up_);
  return map && KeepMap(std::move(*map));
}

void LiveGeometry::NoteWorld() {
  state_.views = world_.growing.views();
  state_.maps = world_.growing.maps();
  if (state_.maps > 0) return;
  state_.mesh.reset();  // whatever it showed has been taken back
  poses_of_mesh_.reset();
}

void LiveGeometry::Loop() {
  InstallSignalStack();
  Clock::time_point rested = Clock::now();
  bool idle = false;  // nothing to make until something changes
  MutexLock lock(mutex_);
  while (!over_) {
    if (!changes_.empty()) {
      const PendingChange coming =
          changes_.front();  // stays there until it is done: Finish() may have to do it
      lock.unlock();
      const Change change = Prepare(coming, maker_);
      lock.lock();
      if (over_) break;
      changes_.pop_front();
      if (change) change(world_);
      NoteWorld();
      idle = false;
      continue;
    }
    if (idle || failed_) {
      changed_.wait(lock, [this]() ULF_REQUIRES(mutex_) { return over_ || !changes_.empty(); });
      continue;
    }
    if (Clock::now() < rested) {
      changed_.wait_until(lock, rested, [this]() ULF_REQUIRES(mutex_) { return over_ || !changes_.empty(); });
      continue;
    }
    lock.unlock();
    const double before_s = ThreadCpuSeconds();
    bool worked = false;
    try {
      worked = Work();
    } catch (const std::exception& error) {
      Fail(error.what());
    }
    const double took_s = ThreadCpuSeconds() - before_s;
    rested = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                std::chrono::duration<double>(took_s * (1 / options_.processor_share - 1)));
    if (!worked) {
      idle = !WaitsForMesh();
      if (!idle) rested = std::max(rested, next_mesh_);
    }
    lock.lock();
    state_.processor_s += took_s;
    state_.maps = world_.growing.maps();
  }
  ended_ = true;
  changed_.notify_all();
}

void LiveGeometry::WorkNow() {
  try {
    while (!failed_ && Work()) {
    }
  } catch (const std::exception& error) {
    Fail(error.what());
  }
  const MutexLock lock(mutex_);
  NoteWorld();
}

FinishedGeometry LiveGeometry::Finish() {
  const auto start = Clock::now();
  constexpr double kWaitForThread_s = 1;
  EndThread(kWaitForThread_s);
  FinishedGeometry finished;
  finished.views_left_out = left_out_views_;
  std::deque<PendingChange> rest;
  World world;
  {
    const MutexLock lock(mutex_);
    over_ = true;
    rest.swap(changes_);
    world = world_;
  }
  std::ranges::move(to_hand_over_, std::back_inserter(rest));
  to_hand_over_.clear();
  const double most_s = options_.threaded ? options_.finish_s : std::numeric_limits<double>::infinity();
  try {
    std::vector<Change> changes(rest.size());
    std::vector<char> no_time(rest.size());  // not bool: each of its own thread
    ParallelFor(rest.size(), [&](std::size_t i) {
      if (rest[i].view && SecondsSince(start) > most_s / 2) {
        no_time[i] = true;
        return;
      }
      render::StereoViewMaker maker(options_.growing.size_px);
      changes[i] = Prepare(rest[i], maker);
    });
    for (std::size_t i = 0; i < rest.size(); ++i)
      if (no_time[i]) finished.views_left_out.insert(*rest[i].view);
    for (const Change& change : changes)
      if (change) change(world);
    if (!world.subject || failed_) return finished;
    world.growing.MakeMissingMaps(std::max(most_s - SecondsSince(start), most_s / 2));
    finished.maps = world.growing.maps();
    finished.missing_maps = world.growing.MissingMaps();
    Meshed meshed = MakeMesh(world, MeshFor::kEnd);
    finished.mesh = std::move(meshed.mesh);
    finished.map_poses = std::move(meshed.poses);
    {
      const MutexLock lock(mutex_);
      state_.mesh = finished.mesh;
    }
    if (finished.mesh) finished.maps_for_rendering = world.growing.MapsForRendering(*finished.mesh->mesh);
  } catch (const std::exception& error) {
    Fail(error.what());
  }
  {
    const MutexLock lock(mutex_);
    std::ranges::set_difference(unreadable_, removed_,
                                std::inserter(finished.unreadable_views, finished.unreadable_views.end()));
  }
  finished.seconds = SecondsSince(start);
  return finished;
}

}  // namespace ulf::coverage
