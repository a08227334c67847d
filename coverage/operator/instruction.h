// Derives the operator's next action from a capture's state: a value, which the display shows as a short line
// and a simulated operator follows.
#pragma once

#include <optional>
#include <string>

#include "coverage/bound/view_decision.h"
#include "coverage/session/capture_state.h"

namespace ulf::coverage {

enum class InstructionKind {
  kNothing,
  kFinished,       // the capture is closing (CaptureState::ended)
  kWaitForDevice,  // CaptureState::device_problem
  kReturn,         // the pose was lost: go back to where it was known
  kFindPose,       // there is no pose yet
  kAwaitSubject,   // the subject's distance is being found
  kFindSubject,    // the subject cannot be found: there are too few points
  kPlaceSubject,   // the subject has moved
  kAim,            // the subject cannot be recorded from here (Instruction::reason)
  kMendChecks,     // a check fails that holds the start
  kBegin,          // all is ready: ask for recording
  kGoOn,           // recording was paused by request
  kMendMistake,    // a mistake keeps frames from being recorded (CaptureState::mistakes)
  kMendFrames,     // frames are not recorded (Instruction::reason)
  kWalkOn,         // the capture has no subject: go where nothing is recorded yet
  kTurnTable,      // turn the table or move the camera, as WayInWords() says
  kComeNearer,
  kGoFarther,
  kApproachRow,  // the last row is too far away
  kLeaveRow,     // the last row is too near
  kFollowArrow,
};

struct Instruction {
  InstructionKind kind = InstructionKind::kNothing;
  bool urgent = false;  // nothing is recorded until it is done; of kFinished: device or disk failed
  std::optional<Reason> reason = std::nullopt;      // of kAim and kMendFrames
  std::optional<LengthToGo> length = std::nullopt;  // of kComeNearer and kGoFarther
};

Instruction InstructionFor(const CaptureState& state);
// Returns a short line; empty if nothing is to be done. `state`: the one that `instruction` was made for.
std::string InWords(const Instruction& instruction, const CaptureState& state);

}  // namespace ulf::coverage
