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

// Reasons for which no place that the camera sees now can be recorded; they come before a pause by request.
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
  return instruction.kind == InstructionKind::kReturn ? "go back to where the camera was before"
                                                      : "move the camera sideways";
}

// While all is well: where to go.
Instruction WayToGo(const CaptureState& state) {
  const double now = (state.cam_from_world->OriginInSource() - state.subject->center_in_world).norm();
  const double wanted = state.guidance.distance;
  if (wanted > 0 && now > kDistanceOff * wanted)
    return {.kind = InstructionKind::kComeNearer, .length = LengthToGo::Of(state, now, wanted)};
  if (wanted > 0 && wanted > kDistanceOff * now)
    return {.kind = InstructionKind::kGoFarther, .length = LengthToGo::Of(state, now, wanted)};
  if (const auto& row = state.guidance.row; row && row->wanted > 0) {
    if (row->now > kRowFar * row->wanted) return {.kind = InstructionKind::kApproachRow};
    if (row->now < kRowNear * row->wanted) return {.kind = InstructionKind::kLeaveRow};
  }
  if (state.guidance.toward) return {.kind = InstructionKind::kFollowArrow};
  return {};
}

const NoticedMistake* MistakeForState(const CaptureState& state) {
  const NoticedMistake* mistake = MistakeForReason(state.decision.reason, state.mistakes);
  return mistake && mistake->IsSeenAt(state.seconds) ? mistake : nullptr;
}

}  // namespace

Instruction InstructionFor(const CaptureState& state) {
  if (state.ended)
    return {.kind = InstructionKind::kFinished,
            .urgent = *state.ended == StoppedBecause::kDeviceLost || *state.ended == StoppedBecause::kDisk};
  if (!state.why_waiting.empty() && !state.device_problem.empty())
    return {.kind = InstructionKind::kWaitForDevice, .urgent = true};
  if (!state.cam_from_world)
    return {.kind = state.tracking == tracking::TrackState::kLost ? InstructionKind::kReturn
                                                                  : InstructionKind::kFindPose,
            .urgent = true};
  if (!state.subject && !state.without_subject)
    return state.finding_subject ? Instruction{.kind = InstructionKind::kAwaitSubject}
                                 : Instruction{.kind = InstructionKind::kFindSubject, .urgent = true};
  if (state.subject_moved) return {.kind = InstructionKind::kPlaceSubject, .urgent = true};
  const Reason reason = state.decision.reason;
  if (Has(kAimWords, reason)) return {.kind = InstructionKind::kAim, .urgent = true, .reason = reason};
  if (state.waits_to_begin)
    return HoldsInWords(state.preflight).empty()
               ? Instruction{.kind = InstructionKind::kBegin}
               : Instruction{.kind = InstructionKind::kMendChecks, .urgent = true};
  if (!state.recording) return {.kind = InstructionKind::kGoOn, .urgent = true};
  if (MistakeForState(state)) return {.kind = InstructionKind::kMendMistake, .urgent = true};
  if (Has(kRefusalWords, reason))
    return {.kind = InstructionKind::kMendFrames, .urgent = true, .reason = reason};
  if (IsTaken(state.source)) return {};
  if (!state.subject) return {.kind = InstructionKind::kWalkOn};
  if (state.table_up_in_world) return {.kind = InstructionKind::kTurnTable};
  return WayToGo(state);
}

std::string InWords(const Instruction& instruction, const CaptureState& state) {
  const bool is_taken = IsTaken(state.source);
  switch (instruction.kind) {
    case InstructionKind::kNothing:
      return {};
    case InstructionKind::kFinished:
      return FinalWords(*state.ended);
    case InstructionKind::kWaitForDevice:
      return state.device_problem;
    case InstructionKind::kReturn:
    case InstructionKind::kFindPose:
      return WordsWithoutPose(instruction, state);
    case InstructionKind::kAwaitSubject:
      return is_taken ? "the subject's distance is being found"
                      : "hold the subject in the middle: its distance is being found";
    case InstructionKind::kFindSubject:
      return is_taken ? "too few trackable points in the middle of the picture: place the subject (S)"
                      : "too few trackable points in the middle of the picture: go nearer, or add texture or "
                        "light";
    case InstructionKind::kPlaceSubject:
      return is_taken ? "the subject has moved: place it anew (S)"
                      : "the subject has moved: put it back, or place it anew (S)";
    case InstructionKind::kAim:
      return WordsFor(kAimWords, *instruction.reason, is_taken);
    case InstructionKind::kMendChecks:
      return "mend what is red in the list; then Space begins";
    case InstructionKind::kBegin:
      return state.subject ? "place the sphere (S); Space begins to record" : "Space begins to record";
    case InstructionKind::kGoOn:
      return "paused: Space goes on";
    case InstructionKind::kMendMistake: {
      const NoticedMistake& mistake = *MistakeForState(state);
      return fmt::format("{}. {}", Name(mistake.mistake), mistake.cure);
    }
    case InstructionKind::kMendFrames:
      return WordsFor(kRefusalWords, *instruction.reason, is_taken);
    case InstructionKind::kWalkOn:
      return "walk on";
    case InstructionKind::kTurnTable:
      return WayInWords(state);
    case InstructionKind::kComeNearer:
      return fmt::format("come {} nearer", instruction.length->Text());
    case InstructionKind::kGoFarther:
      return fmt::format("go {} back", instruction.length->Text());
    case InstructionKind::kApproachRow:
      return "too far from the last row: follow the arrow";
    case InstructionKind::kLeaveRow:
      return "too near to the last row: follow the arrow";
    case InstructionKind::kFollowArrow:
      return "follow the arrow";
  }
  return {};
}

}  // namespace ulf::coverage
