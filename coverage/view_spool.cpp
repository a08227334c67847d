#include "coverage/view_spool.h"

#include <map>
#include <utility>

namespace ulf {
namespace {

// What moves a pixel of the subject by less than a hundredth need not be written down.
bool Differ(const Rigid3& a, const Rigid3& b) {
  const Rigid3 b_from_a = b * a.Inverse();
  return RotationAngle(b_from_a.rotation) > 1e-5 ||
         b_from_a.translation.norm() > 1e-5 * (1 + a.translation.norm());
}

}  // namespace

ViewSpool::ViewSpool(LightFieldWriter writer, std::size_t capacity, bool threaded)
    : writer_(std::move(writer)) {
  for (const View& view : writer_.Contents().views) {
    view_ids_.push_back(view.id);
    journaled_.push_back(view.cam_from_world);
  }
  if (!threaded) return;
  queue_ = std::make_unique<BoundedQueue<Task>>(capacity, WhenFull::kBlock);
  thread_ = std::thread([this] { Loop(); });
}

ViewSpool::~ViewSpool() {
  if (queue_) queue_->Close();
  if (thread_.joinable()) thread_.join();
}

void ViewSpool::Loop() {
  while (!queue_->IsClosed() || queue_->Size() > 0)
    if (const auto task = queue_->Pop(std::chrono::milliseconds(100))) Run(*task);
}

void ViewSpool::Run(const Task& task) {
  if (Failure()) return;
  try {
    task(writer_);
  } catch (const std::exception& error) {
    const std::lock_guard lock(mutex_);
    failure_ = error.what();
  }
}

std::optional<std::string> ViewSpool::Failure() const {
  const std::lock_guard lock(mutex_);
  return failure_;
}

bool ViewSpool::Submit(Task task, bool wait) {
  if (!queue_) {
    Run(task);
    return true;
  }
  return wait ? queue_->Push(std::move(task)) : queue_->TryPush(task);
}

bool ViewSpool::TryAddView(const Frame& frame, const View& view) {
  return Submit(
      [this, frame, view](LightFieldWriter& writer) {
        view_ids_.push_back(writer.AddView(frame, view).id);
        journaled_.push_back(view.cam_from_world);
      },
      false);
}

bool ViewSpool::TryUpdatePoses(std::vector<Rigid3> cam_from_world) {
  return Submit(
      [this, poses = std::move(cam_from_world)](LightFieldWriter& writer) {
        std::map<int, Rigid3> changed;
        for (std::size_t i = 0; i < poses.size() && i < view_ids_.size(); ++i)
          if (Differ(poses[i], journaled_[i])) {
            changed[view_ids_[i]] = poses[i];
            journaled_[i] = poses[i];
          }
        writer.UpdatePoses(changed);
      },
      false);
}

void ViewSpool::SetSubject(const Subject& subject) {
  Submit([subject](LightFieldWriter& writer) { writer.SetSubject(subject); }, true);
}

void ViewSpool::NoteGap(double from_s, double to_s, const std::string& reason) {
  Submit([=](LightFieldWriter& writer) { writer.NoteGap(from_s, to_s, reason); }, true);
}

LightFieldWriter ViewSpool::Finish() {
  if (queue_) queue_->Close();
  if (thread_.joinable()) thread_.join();
  return std::move(writer_);
}

}  // namespace ulf
