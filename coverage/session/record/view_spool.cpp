#include "coverage/session/record/view_spool.h"

#include <spdlog/spdlog.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/base/atomic_file.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/stop_signal.h"
#include "core/light_field/folder/light_field_writer.h"
#include "coverage/session/record/kept_photographs.h"

namespace ulf::coverage {
namespace {

// Room for the journal's next lines and the derived files of a light field.
constexpr std::uint64_t kClosingBytes = 256 << 10;
constexpr std::uint64_t kClosingBytesPerView = 2 << 10;
constexpr std::uint64_t kClosingBytesPerSeenPoint = 64;  // of a view, in points.ulf and COLMAP's text
// Views that are written together share the disk's waits, a few milliseconds each.
constexpr std::size_t kViewsTogether = 8;
constexpr int kPictureNiceness = 10;
// No event reports room on a disk, so the spool tries again.
constexpr std::chrono::milliseconds kRetryAfter(300);

// Less moves the subject's image by less than a hundredth of a pixel and need not be journaled.
bool Differ(const Rigid3& a, const Rigid3& b) {
  const Rigid3 b_from_a = b * a.Inverse();
  return RotationAngle(b_from_a.rotation) > 1e-5 ||
         b_from_a.translation.norm() > 1e-5 * (1 + a.translation.norm());
}

// Returns an upper bound of the photograph without its master.
std::uint64_t PictureBytes(const Frame& frame) { return 3 * frame.image.pixels.total(); }

std::size_t Processors() { return std::clamp<std::size_t>(std::thread::hardware_concurrency(), 1, 4); }

double Megabytes(std::uint64_t bytes) { return 1e-6 * static_cast<double>(bytes); }

}  // namespace

ViewSpool::ViewSpool(LightFieldWriter writer, std::size_t capacity, bool threaded)
    : writer_(std::move(writer)),
      root_(writer_.Contents().root),
      folder_(root_),
      capacity_(capacity),
      threaded_(threaded) {
  views_on_disk_ = writer_.Contents().views.size();
  if (!threaded_) return;
  threads_.emplace_back([this] { WriteLoop(); });
  for (std::size_t i = 0; i < Processors(); ++i) {
    threads_.emplace_back([this] { EncodeLoop(); });
    threads_.emplace_back([this] { PictureLoop(); });
  }
}

ViewSpool::~ViewSpool() { StopThreads(); }

void ViewSpool::StopThreads() {
  {
    const MutexLock lock(mutex_);
    finishing_ = true;
  }
  changed_.notify_all();
  for (std::thread& thread : threads_)
    if (thread.joinable()) thread.join();
}

ViewSpool::Outcome ViewSpool::Try(const std::function<void()>& write, std::string& problem) {
  try {
    write();
    return Outcome::kWritten;
  } catch (const DiskFullError& error) {
    problem = error.what();
    const MutexLock lock(mutex_);
    no_room_ = problem;
    return Outcome::kNoRoom;
  } catch (const std::exception& error) {
    problem = error.what();
    return Outcome::kFailed;
  }
}

// Writes one line, one frame for unposed/, or views. Where several views fail together, one of them may be
// the cause: that is no failure yet.
ViewSpool::Outcome ViewSpool::Write(std::span<const Task> tasks) {
  const Task& first = tasks.front();
  std::string problem;
  const Outcome outcome = Try(
      [&] {
        if (first.view) return WriteViews(tasks);
        first.write(writer_);
      },
      problem);
  const MutexLock lock(mutex_);
  if (outcome == Outcome::kWritten) no_room_.reset();
  if (outcome == Outcome::kFailed && tasks.size() == 1) failure_ = folder_.WhyNotInPlace().value_or(problem);
  return outcome;
}

void ViewSpool::WriteViews(std::span<const Task> tasks) {
  std::vector<LightFieldWriter::NewView> added;
  for (const Task& task : tasks) {
    if (!threaded_ && task.view->state == PendingView::kWaiting) {
      task.view->view.files = writer_.Files(task.view->view.frame, MakePictures::kNow);
      task.view->state = PendingView::kEncoded;
    }
    if (task.view->problem) std::rethrow_exception(task.view->problem);
    added.push_back(task.view->view);
  }
  const std::vector<View> views = writer_.AddViews(added);
  views_on_disk_ += views.size();
  const MutexLock lock(mutex_);
  for (std::size_t i = 0; i < views.size(); ++i)
    if (!added[i].files.image) pictures_.push_back(views[i]);
}

// Keeps a frame after a failure; returns false when it found no place at all.
bool ViewSpool::Rescue(const Task& task) {
  if (!task.IsFrame()) return true;
  std::string problem;  // the first one is the failure that is reported
  const auto folder =
      SavePhotograph(&writer_, root_, task.view ? task.view->view.frame : *task.other_frame, problem);
  if (!folder || (task.is_for_unposed && *folder == root_ / "unposed")) return folder.has_value();
  const MutexLock lock(mutex_);
  ++set_aside_[*folder];
  return true;
}

void ViewSpool::RemoveFirst(bool written) {
  if (tasks_.front().IsFrame()) {
    --views_waiting_;
    if (!written) ++unwritten_;
  }
  tasks_.pop_front();
}

// Returns the number of first tasks that can be written together; 0: the first is still being encoded.
std::size_t ViewSpool::BatchSize(std::size_t most_views) const {
  if (!tasks_.empty() && !tasks_.front().view) return 1;
  std::size_t count = 0;
  while (count < tasks_.size() && count < most_views && tasks_[count].view &&
         tasks_[count].view->state == PendingView::kEncoded)
    ++count;
  return count;
}

void ViewSpool::WriteLoop() {
  InstallSignalStack();
  MutexLock lock(mutex_);
  for (std::size_t most = kViewsTogether;;) {
    changed_.wait(
        lock, [&]() ULF_REQUIRES(mutex_) { return (finishing_ && tasks_.empty()) || BatchSize(most) > 0; });
    if (tasks_.empty()) break;
    std::size_t count = BatchSize(most);
    if (!failure_) {
      const std::vector<Task> tasks(tasks_.begin(), tasks_.begin() + static_cast<std::ptrdiff_t>(count));
      lock.unlock();
      const Outcome outcome = Write(tasks);
      lock.lock();
      if (outcome != Outcome::kWritten && count > 1) {
        most = 1;  // there may be room for one, or only one of them may fail
        continue;
      }
      if (outcome == Outcome::kNoRoom && !finishing_) {
        changed_.wait_for(lock, kRetryAfter, [this]() ULF_REQUIRES(mutex_) { return finishing_; });
        continue;
      }
      if (outcome == Outcome::kNoRoom) failure_ = no_room_;
      if (outcome == Outcome::kWritten) most = kViewsTogether;
    }
    bool written = true;
    if (failure_) {
      const Task task = tasks_.front();
      count = 1;
      lock.unlock();
      written = Rescue(task);
      lock.lock();
    }
    for (std::size_t i = 0; i < count; ++i) RemoveFirst(written);
    if (tasks_.size() <= capacity_ / 2) behind_ = false;
    changed_.notify_all();
  }
  all_written_ = true;
  changed_.notify_all();
}

// Encodes the waiting views, also while the disk is full.
void ViewSpool::EncodeLoop() {
  InstallSignalStack();
  MutexLock lock(mutex_);
  for (;;) {
    std::shared_ptr<PendingView> next;
    const auto find = [&]() ULF_REQUIRES(mutex_) {
      const auto found = std::ranges::find_if(
          tasks_, [](const Task& task) { return task.view && task.view->state == PendingView::kWaiting; });
      if (found != tasks_.end()) next = found->view;
      return next != nullptr;
    };
    changed_.wait(lock, [&]() ULF_REQUIRES(mutex_) { return find() || finishing_; });
    if (!next) return;
    next->state = PendingView::kBeingEncoded;
    lock.unlock();
    try {
      next->view.files = writer_.Files(next->view.frame, MakePictures::kLater);
    } catch (...) {
      next->problem = std::current_exception();
    }
    lock.lock();
    next->state = PendingView::kEncoded;
    changed_.notify_all();
  }
}

void ViewSpool::PictureLoop() {
  InstallSignalStack();
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kPictureNiceness);  // of this thread alone
  MutexLock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this]() ULF_REQUIRES(mutex_) { return !pictures_.empty() || all_written_; });
    if (pictures_.empty()) return;
    const View view = std::move(pictures_.front());
    pictures_.pop_front();
    pictures_being_made_.push_back(view.id);
    lock.unlock();
    std::string problem;
    const Outcome outcome = Try(
        [&] {
          folder_.RequireInPlace();
          WritePictureFromMaster(root_, view);
        },
        problem);
    const std::optional<std::string> gone = folder_.WhyNotInPlace();
    lock.lock();
    std::erase(pictures_being_made_, view.id);
    if (outcome == Outcome::kWritten) {
      no_room_.reset();
    } else if (gone) {
      failure_ = gone;
    } else if (outcome == Outcome::kFailed) {
      if (pictures_not_made_++ == 0) spdlog::warn("{}; recording goes on", problem);
    } else {
      pictures_.push_front(view);
      if (all_written_) return;
      changed_.wait_for(lock, kRetryAfter, [this]() ULF_REQUIRES(mutex_) { return all_written_; });
    }
    changed_.notify_all();
  }
}

std::uint64_t ViewSpool::MostBytes(const Frame& frame) {
  return PictureBytes(frame) + frame.image.pixels.elemSize() * frame.image.pixels.total() +
         (frame.raw ? frame.raw->bytes->size() : 0);
}

std::size_t ViewSpool::ViewsWaiting() const {
  const MutexLock lock(mutex_);
  return views_waiting_;
}

std::size_t ViewSpool::PicturesWaiting() const {
  const MutexLock lock(mutex_);
  return pictures_.size() + pictures_being_made_.size();
}

// Returns false when the last one had no room and was not accepted.
bool ViewSpool::WriteInCaller(bool only_if_room) {
  MutexLock lock(mutex_);
  while (!tasks_.empty()) {
    const Task task = tasks_.front();
    Outcome outcome = Outcome::kFailed;
    if (!failure_) {
      lock.unlock();
      outcome = Write({&task, 1});
      lock.lock();
    }
    if (outcome == Outcome::kNoRoom && !finishing_) {
      if (!only_if_room) return true;  // it waits
      views_waiting_ -= tasks_.back().IsFrame();
      tasks_.pop_back();
      return false;
    }
    if (outcome == Outcome::kNoRoom) failure_ = no_room_;
    bool written = true;
    if (failure_) {
      lock.unlock();
      written = Rescue(task);
      lock.lock();
    }
    RemoveFirst(written);
  }
  return true;
}

bool ViewSpool::Submit(Task task, bool only_if_room) {
  {
    const MutexLock lock(mutex_);
    if (threaded_ && tasks_.size() >= capacity_) {
      behind_ = true;
      if (only_if_room) return false;
    }
    if (task.view) task.view->view.view.id = writer_.ReserveViewId();
    views_waiting_ += task.IsFrame();
    tasks_.push_back(std::move(task));
  }
  if (!threaded_) return WriteInCaller(only_if_room);
  changed_.notify_all();
  return true;
}

std::uint64_t ViewSpool::NeededBytes(std::uint64_t views) const {
  return views * largest_view_bytes_ +
         (pictures_.size() + pictures_being_made_.size()) * largest_picture_bytes_ + kClosingBytes +
         (kClosingBytesPerView + kClosingBytesPerSeenPoint * most_seen_points_) * (views_on_disk_ + views);
}

std::optional<SpoolPause> ViewSpool::Pause() {
  MutexLock lock(mutex_);
  if (failure_) return std::nullopt;
  const std::uint64_t free = FreeBytes(root_), needed = NeededBytes(views_waiting_ + 1);
  if (no_room_ || free < needed)
    return SpoolPause{
        true, fmt::format("disk full ({:.1f} MB free, {:.1f} needed); free some space on the disk of {}",
                          Megabytes(free), Megabytes(std::max(needed, free + 1)), root_.string())};
  if (behind_)
    return SpoolPause{false, fmt::format("disk slow ({} to be written)", Counted(views_waiting_, "view"))};
  return std::nullopt;
}

ViewSpool::Task ViewSpool::Adding(const Frame& frame, const View& view) {
  largest_view_bytes_ = std::max<std::uint64_t>(largest_view_bytes_, MostBytes(frame));
  largest_picture_bytes_ = std::max<std::uint64_t>(largest_picture_bytes_, PictureBytes(frame));
  auto pending = std::make_shared<PendingView>();
  pending->view = {frame, view, {}};
  return {{}, std::move(pending)};
}

std::optional<int> ViewSpool::TryAddView(const Frame& frame, const View& view) {
  const Task adding = Adding(frame, view);
  if (Pause() || !Submit(adding, true)) return std::nullopt;
  return adding.view->view.view.id;
}

int ViewSpool::AddView(const Frame& frame, const View& view) {
  const Task adding = Adding(frame, view);
  Submit(adding, false);
  return adding.view->view.view.id;
}

void ViewSpool::KeepUnposed(const Frame& frame, const std::string& problem) {
  Submit({[=](LightFieldWriter& writer) { writer.KeepUnposed(frame, problem); }, nullptr, frame, true},
         false);
}

void ViewSpool::AddExposure(int view_id, const Frame& frame, const Rigid3& exposure_from_view,
                            bool pose_is_between) {
  const auto add = [=](LightFieldWriter& writer) {
    writer.AddExposure(view_id, frame, exposure_from_view, pose_is_between);
  };
  Submit({add, nullptr, frame}, false);
}

void ViewSpool::RemoveViews(std::set<int> ids) {
  Submit({[this, ids = std::move(ids)](LightFieldWriter&) { Remove(ids); }}, false);
}

// Waits while a thread makes one of the photographs from its master, because that thread writes the view's
// files.
void ViewSpool::Remove(const std::set<int>& ids) {
  {
    MutexLock lock(mutex_);
    changed_.wait(lock, [&]() ULF_REQUIRES(mutex_) {
      return std::ranges::none_of(pictures_being_made_, [&](int id) { return ids.contains(id); });
    });
    std::erase_if(pictures_, [&](const View& view) { return ids.contains(view.id); });
  }
  writer_.RemoveViews(ids);
  views_on_disk_ -= ids.size();
}

bool ViewSpool::TryUpdatePoses(std::map<int, Rigid3> cam_from_world) {
  return Submit({[this, poses = std::move(cam_from_world)](LightFieldWriter&) { UpdatePoses(poses, {}); }},
                true);
}

void ViewSpool::UpdateLens(const CameraModel& camera, const std::string& source,
                           std::map<int, Rigid3> cam_from_world) {
  Submit({[this, camera, source, poses = std::move(cam_from_world)](const LightFieldWriter& writer) {
           UpdatePoses(poses, {{writer.CameraInUse(), {camera, source}}});
         }},
         false);
}

void ViewSpool::UpdatePoses(const std::map<int, Rigid3>& cam_from_world,
                            const std::map<int, CorrectedLens>& cameras) {
  std::map<int, Rigid3> changed;
  for (const View& on_disk : writer_.Contents().views)
    if (const auto now = cam_from_world.find(on_disk.id);
        now != cam_from_world.end() && Differ(now->second, on_disk.cam_from_world))
      changed.insert(*now);
  writer_.UpdatePoses(changed, cameras);
}

void ViewSpool::SetSubject(const Subject& subject) {
  Submit({[subject](LightFieldWriter& writer) { writer.SetSubject(subject); }}, false);
}

void ViewSpool::NoteGap(double from_s, double to_s, const std::string& reason) {
  Submit({[=](LightFieldWriter& writer) { writer.NoteGap(from_s, to_s, reason); }}, false);
}

std::optional<std::string> ViewSpool::Failure() const {
  const MutexLock lock(mutex_);
  return failure_;
}

std::size_t ViewSpool::Unwritten() const {
  const MutexLock lock(mutex_);
  return unwritten_;
}

std::map<std::filesystem::path, std::size_t> ViewSpool::SetAside() const {
  const MutexLock lock(mutex_);
  return set_aside_;
}

LightFieldWriter ViewSpool::Finish() {
  StopThreads();
  if (!threaded_) WriteInCaller(false);
  const MutexLock lock(mutex_);
  if (pictures_not_made_ > 0 && !folder_.WhyNotInPlace())
    spdlog::warn(
        "{} of images/ could not be made now and will be made from masters/ when the light field is next "
        "opened",
        Counted(pictures_not_made_, "photograph"));
  if (!failure_ && !pictures_.empty())
    spdlog::warn("{} of images/ did not fit on the disk and will be made from masters/ when there is room",
                 Counted(pictures_.size(), "photograph"));
  return std::move(writer_);
}

}  // namespace ulf::coverage
