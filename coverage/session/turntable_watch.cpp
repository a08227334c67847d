#include "coverage/session/turntable_watch.h"

#include <fmt/format.h>

#include "core/geometry/angles.h"

namespace ulf::coverage {
namespace {

// All guessed.
constexpr double kTableUnseen_s = 2, kTableStill_s = 4;  // so long, and it is said
constexpr double kTableStillTurn = Radians(1);           // less than this is no turn
constexpr double kTableSampledTurn = Radians(2);         // between two poses that tell the axis
constexpr double kTableMoved_s = 0.5;                    // so long elsewhere: one wrong pose is no move
constexpr std::size_t kTableMostPoses = 240, kTableFewestPoses = 8;

double TurnFrom(const Rigid3& a, const Rigid3& b) {
  return RotationAngle(a.rotation * b.rotation.conjugate());
}

}  // namespace

std::string TurntableWatch::Update(double time_s, const std::optional<Rigid3>& cam_from_board) {
  std::string words = IfUnseen(time_s, cam_from_board.has_value());
  if (!cam_from_board) return words;
  if (words.empty()) words = IfStill(time_s, *cam_from_board);
  const std::string moved = IfMoved(time_s, *cam_from_board);
  return words.empty() ? moved : words;
}

std::string TurntableWatch::IfUnseen(double time_s, bool seen) {
  if (seen) {
    unseen_since_s_.reset();
    said_unseen_ = false;
    return {};
  }
  if (!unseen_since_s_) unseen_since_s_ = time_s;
  if (said_unseen_ || time_s - *unseen_since_s_ < kTableUnseen_s) return {};
  said_unseen_ = true;
  return fmt::format(
      "the board {} is not seen, and without it there is no pose: {}check that it is the one that was "
      "printed",
      board_,
      IsTaken(source_)
          ? ""
          : "aim at it from higher up, leave more of it free round the subject, light it evenly, and ");
}

std::string TurntableWatch::IfStill(double time_s, const Rigid3& pose) {
  if (!still_pose_ || TurnFrom(*still_pose_, pose) > kTableStillTurn) {
    still_pose_ = pose;
    still_since_s_ = time_s;
    said_still_ = false;
    return {};
  }
  if (said_still_ || time_s - *still_since_s_ < kTableStill_s) return {};
  said_still_ = true;
  return fmt::format(
      "the subject does not turn: less than {:.0f}° in {:.0f} s{}", Degrees(kTableStillTurn), kTableStill_s,
      IsTaken(source_) ? "" : "; start the turntable, and lay the board on it, under the subject");
}

std::string TurntableWatch::IfMoved(double time_s, const Rigid3& pose) {
  const bool elsewhere =
      axis_ && !stand_.empty() && !IsSameStand(ShiftBetween(*axis_, stand_[stand_.size() / 2], pose));
  if (!elsewhere) {
    moved_since_s_.reset();
    if (stand_.empty() || TurnFrom(stand_.back(), pose) > kTableSampledTurn) {
      stand_.push_back(pose);
      if (stand_.size() > kTableMostPoses) stand_.erase(stand_.begin());
      // The axis is the table's; it does not change with the camera's place.
      if (stand_.size() >= kTableFewestPoses && (!axis_ || stand_.size() % kTableFewestPoses == 0))
        if (const auto fitted = FitTurnAxis(stand_)) axis_ = fitted;
    }
    return {};
  }
  if (!moved_since_s_) moved_since_s_ = time_s;
  if (time_s - *moved_since_s_ < kTableMoved_s) return {};
  const StandShift shift = ShiftBetween(*axis_, stand_[stand_.size() / 2], pose);
  stand_ = {pose};
  moved_since_s_.reset();
  return fmt::format(
      "the camera has been moved, by {:.1f}° and {:.1f} % of its distance: {}the background is learnt anew "
      "from here",
      Degrees(shift.direction), 100 * shift.place_share,
      IsTaken(source_) ? "" : "let it stand now for a whole turn, because ");
}

}  // namespace ulf::coverage
