#include "coverage/session/record/live_geometry.h"

#include <fmt/format.h>
#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <iterator>
#include <limits>
#include <utility>

#include "core/base/host_time.h"
#include "core/base/signal_stack.h"
#include "core/base/thread_clock.h"
#include "render/proxy/subject_in_mesh.h"
#include "render/stereo/mesh_of_maps.h"

namespace ulf::coverage {
namespace {

// Of the calling thread alone. Where the kernel refuses, the thread competes with the others.
void GiveWay() {
  const sched_param none{};
  pthread_setschedparam(pthread_self(), SCHED_IDLE, &none);
}

}  // namespace

LiveGeometry::LiveGeometry(const Options& options)
    : options_(options), growing_(options.growing), maker_(options.growing.size_px) {
  if (options_.threaded) thread_ = std::thread([this] { Loop(); });
}

LiveGeometry::~LiveGeometry() {
  {
    const MutexLock lock(mutex_);
    over_ = true;
    changed_.notify_all();
  }
  if (thread_.joinable()) thread_.join();
}

void LiveGeometry::Do(std::function<void()> change) {
  to_hand_over_.push_back(std::move(change));
  HandOver();
}

void LiveGeometry::TakeOver() {
  if (!over_) std::ranges::move(to_hand_over_, std::back_inserter(changes_));
  to_hand_over_.clear();
  seen_ = state_;
  if (problem_) problem_seen_ = std::exchange(problem_, std::nullopt);
}

void LiveGeometry::HandOver() {
  if (!mutex_.try_lock()) return;
  TakeOver();
  mutex_.unlock();
  changed_.notify_all();
}

void LiveGeometry::SetSubject(const Subject& subject) {
  Do([this, subject] {
    subject_ = subject;
    growing_.SetSubject(subject);
  });
}

void LiveGeometry::AddView(int id, ReadPicture picture, const CameraModel& camera,
                           const Rigid3& cam_from_world) {
  Do([this, id, picture = std::move(picture), camera, cam_from_world] {
    try {
      growing_.AddView(id, maker_.Make(picture(), camera, cam_from_world));
    } catch (const std::exception& error) {
      LeaveOut(id, error.what());
    }
  });
}

void LiveGeometry::RemoveView(int id) {
  Do([this, id] { growing_.RemoveView(id); });
}

void LiveGeometry::MoveViews(const std::map<int, Rigid3>& cam_from_world) {
  Do([this, cam_from_world] { growing_.MoveViews(cam_from_world); });
}

const LiveGeometryState& LiveGeometry::State() {
  HandOver();
  return seen_;
}

void LiveGeometry::Fail(const std::string& what) {
  if (std::exchange(failed_, true)) return;
  const MutexLock lock(mutex_);
  problem_ = fmt::format("geometry: {}; the capture goes on without it, ulf proxy makes it afterwards", what);
}

// One view's picture cannot be read: the others make the geometry.
void LiveGeometry::LeaveOut(int id, const std::string& why) {
  if (std::exchange(left_out_, true)) return;
  const MutexLock lock(mutex_);
  problem_ = fmt::format("geometry: {}; it is made without view {}, and without others that cannot be read",
                         why, id);
}

std::optional<std::string> LiveGeometry::TakeProblem() {
  HandOver();
  return std::exchange(problem_seen_, std::nullopt);
}

void LiveGeometry::MakeMesh(MeshFor what_for) {
  render::MapsMeshOptions options = options_.growing.mesh;
  options.in_this_thread = what_for == MeshFor::kNow;
  if (what_for == MeshFor::kNow)
    options.most_triangles = std::min(options.most_triangles, options_.live_triangles);
  const std::vector<render::ViewDepth> maps = growing_.Maps();
  maps_of_mesh_ = static_cast<int>(maps.size());
  revision_of_mesh_ = growing_.revision();
  render::MapsMesh made = render::MeshOfMaps(maps, *subject_, options);
  if (made.mesh.triangles.empty()) return;
  auto mesh = std::make_shared<LiveMesh>();
  mesh->subject = *subject_;
  mesh->mesh = std::make_shared<const render::TriangleMesh>(std::move(made.mesh));
  mesh->maps = maps_of_mesh_;
  if (what_for == MeshFor::kNow) mesh->subject_seen = render::SubjectInMesh(*mesh->mesh, *subject_);
  const MutexLock lock(mutex_);
  state_.mesh = std::move(mesh);
}

// One map, or one mesh.
void LiveGeometry::Work() {
  const int maps = growing_.maps();
  const int due = std::max(options_.first_mesh_maps,
                           static_cast<int>(options_.more_maps * static_cast<double>(maps_of_mesh_)));
  if (subject_ && maps >= due)
    MakeMesh(MeshFor::kNow);
  else
    growing_.MakeNextMap(false);
}

void LiveGeometry::Loop() {
  InstallSignalStack();
  GiveWay();
  using Clock = std::chrono::steady_clock;
  Clock::time_point rested = Clock::now();
  bool idle = false;  // nothing to make until something changes
  MutexLock lock(mutex_);
  while (!over_) {
    if (!changes_.empty()) {
      const std::function<void()> change = std::move(changes_.front());
      changes_.pop_front();
      lock.unlock();
      try {
        change();
      } catch (const std::exception& error) {
        Fail(error.what());
      }
      idle = false;
      lock.lock();
      state_.views = growing_.views();
      state_.maps = growing_.maps();
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
    const std::uint64_t before = growing_.revision() + revision_of_mesh_;
    try {
      Work();
    } catch (const std::exception& error) {
      Fail(error.what());
    }
    idle = growing_.revision() + revision_of_mesh_ == before;
    const double took_s = ThreadCpuSeconds() - before_s;
    rested = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                std::chrono::duration<double>(took_s * (1 / options_.processor_share - 1)));
    lock.lock();
    state_.processor_s += took_s;
    state_.maps = growing_.maps();
  }
}

void LiveGeometry::WorkNow() {
  std::deque<std::function<void()>> changes;
  {
    const MutexLock lock(mutex_);
    TakeOver();
    changes.swap(changes_);
  }
  try {
    for (const std::function<void()>& change : changes) change();
    for (std::uint64_t before = ~0ULL; !failed_ && growing_.revision() + revision_of_mesh_ != before;) {
      before = growing_.revision() + revision_of_mesh_;
      Work();
    }
  } catch (const std::exception& error) {
    Fail(error.what());
  }
}

FinishedGeometry LiveGeometry::Finish() {
  const auto start = std::chrono::steady_clock::now();
  std::deque<std::function<void()>> rest;
  {
    const MutexLock lock(mutex_);
    TakeOver();
    over_ = true;
    rest.swap(changes_);
    changed_.notify_all();
  }
  if (thread_.joinable()) thread_.join();
  FinishedGeometry finished;
  try {
    for (const std::function<void()>& change : rest) change();
    if (!subject_ || failed_) return finished;
    growing_.MakeMissingMaps(options_.threaded ? options_.finish_s : std::numeric_limits<double>::infinity());
    finished.maps = growing_.maps();
    finished.missing_maps = growing_.MissingMaps();
    {
      const MutexLock lock(mutex_);
      state_.mesh.reset();
    }
    MakeMesh(MeshFor::kEnd);
    finished.mesh = State().mesh;
  } catch (const std::exception& error) {
    Fail(error.what());
  }
  finished.seconds = SecondsSince(start);
  return finished;
}

}  // namespace ulf::coverage
