#include "coverage/operator/pending_requests.h"

namespace ulf::coverage {

void PendingRequests::Record(bool on) { record_ = {on, requests_.Push(SetRecording{on})}; }

void PendingRequests::BeginAlthoughChecksFail() {
  requests_.Push(SetRecording{.on = true, .although_checks_fail = true});
}

void PendingRequests::Place(const Subject& subject) {
  subject_ = {subject, requests_.Push(PlaceSphere{subject})};
}

void PendingRequests::FindSubject() {
  requests_.Push(ulf::coverage::FindSubject{});
  subject_ = {};  // its place is not known yet
}

void PendingRequests::TakeBack(int view_id) {
  taken_back_.insert(view_id);
  requests_.Push(TakeBackViews{{view_id}});
}

void PendingRequests::Finish() { requests_.Push(FinishCapture{}); }

bool PendingRequests::Records(const CaptureState& state) const {
  return record_.IsOpen(state) ? record_.value : state.recording;
}

std::optional<Subject> PendingRequests::SubjectOf(const CaptureState& state) const {
  return subject_.IsOpen(state) ? subject_.value : state.subject;
}

std::optional<int> PendingRequests::LastView(const CaptureState& state) const {
  for (auto id = state.view_ids.rbegin(); id != state.view_ids.rend(); ++id)
    if (!IsTakenBack(*id)) return *id;
  return std::nullopt;
}

}  // namespace ulf::coverage
