#include "coverage/operator/instruction.h"

#include <fmt/core.h>

#include <algorithm>
#include <span>

namespace ulf::coverage {
namespace {

// From where on the line names a distance or the row beside; ratios to the wanted value. Guessed.
constexpr double kDistanceOff = 1.05;  // farther or nearer by more than this: "come nearer", "go back"
constexpr double kRowFar = 1.2;        // wider offsets from the row beside: "too far from the last row"
constexpr double kRowNear = 0.5;       // narrower ones: "too near"

struct ReasonWords {
  Reason reason;
  const char* in_hand;  // what to do with a camera in the hand
  const char* taken;    // what is the matter with pictures that are taken already
};

// Where no place that the camera sees now can be recorded; these come before a pause by request.
constexpr ReasonWords kAimWords[]{
    {Reason::kOutsideRectangle, "bring the sphere back into the rectangle",
     "the sphere leaves the rectangle"},
    {Reason::kBehind, "the subject is behind the camera: turn round", "the subject is behind the camera"},
    {Reason::kInsideSphere, "too near: go back from the subject", "the camera is inside the sphere"}};
constexpr ReasonWords kRefusalWords[]{
    {Reason::kSpeed, "too fast: slower", "the camera was too fast here"},
    {Reason::kBlur, "blurred: hold still", "blurred"},
    {Reason::kExposure, "the subject is too bright or too dark: set the exposure",
     "the subject is too bright or too dark"},
    {Reason::kUnsettled, "the exposure is still changing: wait, or lock it",
     "the exposure is still changing"},
    {Reason::kSpool, "the disk is behind: wait", "the disk is behind"},
    {Reason::kDisk, "the disk is full: make room, recording then goes on",
     "the disk is full: make room, recording then goes on"},
    {Reason::kZoomed, "the zoom was moved, or another lens is mounted: put it back, or calibrate",
     "the zoom was moved, or another lens is mounted"},
    {Reason::kTracking, "tracking is poor: show more of what was seen before", "tracking is poor"}};

bool Has(std::span<const ReasonWords> table, Reason reason) {
  return std::ranges::find(table, reason, &ReasonWords::reason) != table.end();
}

const char* WordsFor(std::span<const ReasonWords> table, Reason reason, bool is_taken) {
  const auto found = std::ranges::find(table, reason, &ReasonWords::reason);
  return is_taken ? found->taken : found->in_hand;
}

const char* FinalWords(StoppedBecause why) {
  switch (why) {
    case StoppedBecause::kCovered:
      return "covered: all that was asked for is recorded";
    case StoppedBecause::kDeviceLost:
      return "the device no longer answers";
    case StoppedBecause::kDisk:
      return "the disk takes no more";
    default:
      return "finished";
  }
}

std::string WordsWithoutPose(const Instruction& instruction, const CaptureState& state) {
  if (!state.tracking_words.empty()) return state.tracking_words;
  if (IsTaken(state.source)) return "no pose is known here";
  return instruction.to_do == ToDo::kReturn ? "go back to where the camera was before"
                                            : "move the camera sideways";
}

// While all is well: where to go.
Instruction WayToGo(const CaptureState& state) {
  const double now = (state.cam_from_world->OriginInSource() - state.subject->center_in_world).norm();
  const double wanted = state.guidance.distance;
  if (wanted > 0 && now > kDistanceOff * wanted)
    return {.to_do = ToDo::kComeNearer, .length = LengthToGo::Of(state, now, wanted)};
  if (wanted > 0 && wanted > kDistanceOff * now)
    return {.to_do = ToDo::kGoFarther, .length = LengthToGo::Of(state, now, wanted)};
  if (const auto& row = state.guidance.row; row && row->wanted > 0) {
    if (row->now > kRowFar * row->wanted) return {.to_do = ToDo::kApproachRow};
    if (row->now < kRowNear * row->wanted) return {.to_do = ToDo::kLeaveRow};
  }
  if (state.guidance.toward) return {.to_do = ToDo::kFollowArrow};
  return {};
}

const NoticedMistake* MistakeBehind(const CaptureState& state) {
  const NoticedMistake* mistake = Behind(state.decision.reason, state.mistakes);
  return mistake && mistake->IsSeenAt(state.seconds) ? mistake : nullptr;
}

}  // namespace

Instruction InstructionFor(const CaptureState& state) {
  if (state.ended)
    return {.to_do = ToDo::kFinished,
            .urgent = *state.ended == StoppedBecause::kDeviceLost || *state.ended == StoppedBecause::kDisk};
  if (!state.why_waiting.empty() && !state.device_problem.empty())
    return {.to_do = ToDo::kWaitForDevice, .urgent = true};
  if (!state.cam_from_world)
    return {.to_do = state.tracking == tracking::TrackState::kLost ? ToDo::kReturn : ToDo::kFindPose,
            .urgent = true};
  if (!state.subject && !state.without_subject)
    return state.finding_subject ? Instruction{.to_do = ToDo::kAwaitSubject}
                                 : Instruction{.to_do = ToDo::kFindSubject, .urgent = true};
  if (state.subject_moved) return {.to_do = ToDo::kPlaceSubject, .urgent = true};
  const Reason reason = state.decision.reason;
  if (Has(kAimWords, reason)) return {.to_do = ToDo::kAim, .urgent = true, .reason = reason};
  if (state.waits_to_begin)
    return HoldsInWords(state.preflight).empty() ? Instruction{.to_do = ToDo::kBegin}
                                                 : Instruction{.to_do = ToDo::kMendChecks, .urgent = true};
  if (!state.recording) return {.to_do = ToDo::kGoOn, .urgent = true};
  if (MistakeBehind(state)) return {.to_do = ToDo::kMendMistake, .urgent = true};
  if (Has(kRefusalWords, reason)) return {.to_do = ToDo::kMendFrames, .urgent = true, .reason = reason};
  if (IsTaken(state.source)) return {};
  if (!state.subject) return {.to_do = ToDo::kWalkOn};
  if (state.table_up_in_world) return {.to_do = ToDo::kTurnTable};
  return WayToGo(state);
}

std::string InWords(const Instruction& instruction, const CaptureState& state) {
  const bool is_taken = IsTaken(state.source);
  switch (instruction.to_do) {
    case ToDo::kNothing:
      return {};
    case ToDo::kFinished:
      return FinalWords(*state.ended);
    case ToDo::kWaitForDevice:
      return state.device_problem;
    case ToDo::kReturn:
    case ToDo::kFindPose:
      return WordsWithoutPose(instruction, state);
    case ToDo::kAwaitSubject:
      return is_taken ? "the subject's distance is being found"
                      : "hold the subject in the middle: its distance is being found";
    case ToDo::kFindSubject:
      return is_taken ? "too few trackable points in the middle of the picture: place the subject (S)"
                      : "too few trackable points in the middle of the picture: go nearer, or add texture or "
                        "light";
    case ToDo::kPlaceSubject:
      return is_taken ? "the subject has moved: place it anew (S)"
                      : "the subject has moved: put it back, or place it anew (S)";
    case ToDo::kAim:
      return WordsFor(kAimWords, *instruction.reason, is_taken);
    case ToDo::kMendChecks:
      return "mend what is red in the list; then Space begins";
    case ToDo::kBegin:
      return state.subject ? "place the sphere (S); Space begins to record" : "Space begins to record";
    case ToDo::kGoOn:
      return "paused: Space goes on";
    case ToDo::kMendMistake: {
      const NoticedMistake& mistake = *MistakeBehind(state);
      return fmt::format("{}. {}", Name(mistake.mistake), mistake.cure);
    }
    case ToDo::kMendFrames:
      return WordsFor(kRefusalWords, *instruction.reason, is_taken);
    case ToDo::kWalkOn:
      return "walk on";
    case ToDo::kTurnTable:
      return WayInWords(state);
    case ToDo::kComeNearer:
      return fmt::format("come {} nearer", instruction.length->Text());
    case ToDo::kGoFarther:
      return fmt::format("go {} back", instruction.length->Text());
    case ToDo::kApproachRow:
      return "too far from the last row: follow the arrow";
    case ToDo::kLeaveRow:
      return "too near to the last row: follow the arrow";
    case ToDo::kFollowArrow:
      return "follow the arrow";
  }
  return {};
}

}  // namespace ulf::coverage
