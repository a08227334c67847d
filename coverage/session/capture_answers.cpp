// What is asked of a running capture, and how it begins.
#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <variant>

#include "core/base/counted.h"
#include "core/base/error.h"
#include "coverage/session/running_capture.h"

namespace ulf::coverage {
namespace {

std::string NoSubjectToPlace() {
  return fmt::format("this capture has no subject to place ({})", Parameter("no_subject"));
}

}  // namespace

void RunningCapture::AnswerRequests() {
  if (!hooks_.requests) return;
  for (const CaptureRequest& request : hooks_.requests->Take()) {
    std::visit([this](const auto& asked) { Answer(asked); }, request);
    ++requests_answered_;
  }
}

void RunningCapture::Answer(const TakeBackLast& asked) {
  const std::vector<int> ids = record_.views().Ids();
  const int recorded = static_cast<int>(ids.size());
  if (asked.count > 1 && asked.count > recorded)
    return Say(fmt::format("nothing was taken back: {} asked for, there are {}; ask for as many or fewer",
                           Counted(asked.count, "view"), recorded));
  summary_.taken_back +=
      record_.TakeBack({ids.rbegin(), ids.rbegin() + std::clamp(asked.count, 0, recorded)});
}

void RunningCapture::Answer(const TakeBackViews& asked) {
  summary_.taken_back += record_.TakeBack(asked.ids);
}

void RunningCapture::Answer(const PlaceSphere& asked) {
  if (options_.without_subject) return Say(NoSubjectToPlace());
  subject_.Place(asked.subject, latest_.track.cam_from_world);
}

void RunningCapture::Answer(const FindSubject& asked) {
  if (options_.without_subject) return Say(NoSubjectToPlace());
  subject_.Find(asked, latest_.track.cam_from_world);
}

void RunningCapture::BeginWhenPossible() {
  if (!begin_asked_ || reporter_.preflight().empty() || !(subject_.IsPlaced() || options_.without_subject))
    return;
  Begin(std::exchange(begin_asked_, std::nullopt)->although_checks_fail);
}

void RunningCapture::Begin(bool although_checks_fail) {
  const std::string holds = HoldsInWords(reporter_.preflight());
  if (!holds.empty() && !although_checks_fail && options_.checks_hold_start)
    return Say(fmt::format(
        "recording has not begun: {}; or begin all the same: Shift Enter, the request record anyway, {}",
        holds, Parameter("force_start")));
  waits_to_begin_ = false;
  recorder_.SetRecording(true);
  Say(holds.empty() ? "recording begins" : "recording begins all the same: " + holds);
}

void RunningCapture::Answer(const PlaceProposedSphere&) {
  if (!proposer_.proposal())
    return Say(
        "no other sphere is proposed: the subject has the size of its sphere, or geometry cannot tell yet");
  subject_.Place(proposer_.proposal()->subject, latest_.track.cam_from_world);
}

void RunningCapture::Answer(const SetRecording& asked) {
  if (waits_to_begin_) {
    begin_asked_.reset();
    if (!asked.on) return Say("recording has not begun yet");
    begin_asked_ = asked;
    if (!subject_.IsPlaced() && !options_.without_subject) {
      const std::string holds = HoldsInWords(reporter_.preflight());
      Say(fmt::format("recording begins as soon as the subject is found: aim at it{}",
                      holds.empty() ? "" : "; now " + holds));
    }
    return BeginWhenPossible();
  }
  recorder_.SetRecording(asked.on);
  if (meters_.last_time_s()) gaps_.Recording(asked.on, *meters_.last_time_s());
  Say(asked.on ? "recording" : "recording paused, tracking goes on");
}

void RunningCapture::Answer(const FinishCapture&) {
  finish_asked_ = true;
  Say("finishing, as asked");
}

}  // namespace ulf::coverage
