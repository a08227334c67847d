#include "coverage/view_spool.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <utility>

#include "acquisition/atomic_file.h"
#include "acquisition/error.h"

namespace ulf {
namespace {

// For the journal's next lines and the derived files of a light field.
constexpr std::uint64_t kClosingBytes = 256 << 10;
constexpr std::uint64_t kClosingBytesPerView = 2 << 10;
// Nothing tells when room appears on a disk: it is asked for.
constexpr std::chrono::milliseconds kRetryAfter(300);

// What moves a pixel of the subject by less than a hundredth need not be written down.
bool Differ(const Rigid3& a, const Rigid3& b) {
  const Rigid3 b_from_a = b * a.Inverse();
  return RotationAngle(b_from_a.rotation) > 1e-5 ||
         b_from_a.translation.norm() > 1e-5 * (1 + a.translation.norm());
}

// At most: photograph and master as they are in memory.
std::uint64_t BytesInMemory(const Frame& frame) {
  const std::uint64_t pixels = frame.image.pixels.total();
  return 3 * pixels + frame.image.pixels.elemSize() * pixels + (frame.raw ? frame.raw->bytes->size() : 0);
}

std::string Megabytes(std::uint64_t bytes) {
  return fmt::format("{:.1f} MB", 1e-6 * static_cast<double>(bytes));
}

}  // namespace

ViewSpool::ViewSpool(LightFieldWriter writer, std::size_t capacity, bool threaded)
    : writer_(std::move(writer)), root_(writer_.Contents().root), capacity_(capacity), threaded_(threaded) {
  for (const View& view : writer_.Contents().views) {
    view_ids_.push_back(view.id);
    journaled_.push_back(view.cam_from_world);
  }
  views_on_disk_ = view_ids_.size();
  if (threaded_) thread_ = std::thread([this] { Loop(); });
}

ViewSpool::~ViewSpool() {
  {
    const std::lock_guard lock(mutex_);
    finishing_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

ViewSpool::Outcome ViewSpool::Write(const Task& task) {
  std::string problem;
  bool full = false;
  try {
    task.write(writer_);
    return Outcome::kWritten;
  } catch (const DiskFullError& error) {
    problem = error.what();
    full = true;
  } catch (const std::exception& error) {
    problem = error.what();
  }
  const std::lock_guard lock(mutex_);
  (full ? no_room_ : failure_) = problem;
  return full ? Outcome::kNoRoom : Outcome::kFailed;
}

void ViewSpool::Loop() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [&] { return finishing_ || !tasks_.empty(); });
    if (tasks_.empty()) return;
    if (!failure_) {
      const Task& task = tasks_.front();  // others only append
      lock.unlock();
      const Outcome outcome = Write(task);
      lock.lock();
      if (outcome == Outcome::kNoRoom && !finishing_) {
        changed_.wait_for(lock, kRetryAfter, [&] { return finishing_; });
        continue;  // the same again
      }
      if (outcome == Outcome::kNoRoom) failure_ = no_room_;
      if (outcome == Outcome::kWritten) no_room_.reset();
    }
    if (tasks_.front().is_view) {
      --views_waiting_;
      if (failure_) ++unwritten_;
    }
    tasks_.pop_front();
    if (tasks_.size() <= capacity_ / 2) behind_ = false;
    changed_.notify_all();
  }
}

// What did not fit before comes first.
bool ViewSpool::WriteHere(Task task, bool only_if_room) {
  tasks_.push_back(std::move(task));
  while (!tasks_.empty() && !Failure()) {
    if (Write(tasks_.front()) == Outcome::kNoRoom) {
      if (!only_if_room) return true;  // kept
      tasks_.pop_back();
      return false;
    }
    tasks_.pop_front();
    const std::lock_guard lock(mutex_);
    no_room_.reset();
  }
  return true;
}

bool ViewSpool::Submit(Task task, bool only_if_room) {
  if (Failure()) return true;  // nothing is written any more, and that has been said
  if (!threaded_) return WriteHere(std::move(task), only_if_room);
  {
    const std::lock_guard lock(mutex_);
    if (tasks_.size() >= capacity_) {
      behind_ = true;
      if (only_if_room) return false;  // else it is a line, which may wait beyond the capacity
    }
    views_waiting_ += task.is_view;
    tasks_.push_back(std::move(task));
  }
  changed_.notify_all();
  return true;
}

std::uint64_t ViewSpool::NeededBytes(std::uint64_t views) const {
  return views * largest_view_bytes_ + kClosingBytes + kClosingBytesPerView * (views_on_disk_ + views);
}

std::optional<std::string> ViewSpool::Pause() {
  std::unique_lock lock(mutex_);
  if (failure_) return std::nullopt;
  const std::uint64_t free = FreeBytes(root_), needed = NeededBytes(views_waiting_ + 1);
  if (no_room_ || free < needed)
    return fmt::format("the disk is full: {} left, {} needed; free some space on the disk of {}",
                       Megabytes(free), Megabytes(std::max(needed, free + 1)), root_.string());
  if (behind_) return fmt::format("the disk is slow: {} views wait to be written", views_waiting_);
  return std::nullopt;
}

ViewSpool::Task ViewSpool::Adding(const Frame& frame, const View& view) {
  largest_view_bytes_ = std::max<std::uint64_t>(largest_view_bytes_, BytesInMemory(frame));
  return {[this, frame, view](LightFieldWriter& writer) {
            view_ids_.push_back(writer.AddView(frame, view).id);
            journaled_.push_back(view.cam_from_world);
            ++views_on_disk_;
          },
          true};
}

bool ViewSpool::TryAddView(const Frame& frame, const View& view) {
  Task adding = Adding(frame, view);
  if (Pause()) return false;
  return Submit(std::move(adding), true);
}

void ViewSpool::AddView(const Frame& frame, const View& view) { Submit(Adding(frame, view), false); }

void ViewSpool::KeepUnposed(const Frame& frame) {
  Submit({[frame](LightFieldWriter& writer) { writer.KeepUnposed(frame); }, true}, false);
}

bool ViewSpool::TryUpdatePoses(std::vector<Rigid3> cam_from_world) {
  return Submit({[this, poses = std::move(cam_from_world)](LightFieldWriter& writer) {
                  std::map<int, Rigid3> changed;
                  for (std::size_t i = 0; i < poses.size() && i < view_ids_.size(); ++i)
                    if (Differ(poses[i], journaled_[i])) changed[view_ids_[i]] = poses[i];
                  writer.UpdatePoses(changed);
                  for (std::size_t i = 0; i < poses.size() && i < view_ids_.size(); ++i)
                    if (changed.count(view_ids_[i])) journaled_[i] = poses[i];
                }},
                true);
}

void ViewSpool::SetSubject(const Subject& subject) {
  Submit({[subject](LightFieldWriter& writer) { writer.SetSubject(subject); }}, false);
}

void ViewSpool::NoteGap(double from_s, double to_s, const std::string& reason) {
  Submit({[=](LightFieldWriter& writer) { writer.NoteGap(from_s, to_s, reason); }}, false);
}

std::optional<std::string> ViewSpool::Failure() const {
  const std::lock_guard lock(mutex_);
  return failure_;
}

LightFieldWriter ViewSpool::Finish() {
  {
    const std::lock_guard lock(mutex_);
    finishing_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
  if (!threaded_)
    for (; !tasks_.empty(); tasks_.pop_front()) {
      if (!failure_ && Write(tasks_.front()) == Outcome::kNoRoom) failure_ = no_room_;
      if (failure_ && tasks_.front().is_view) ++unwritten_;
    }
  return std::move(writer_);
}

}  // namespace ulf
