// Detects mistakes with a turntable while they can still be corrected: the board is not seen, the subject
// does not turn, the camera was moved. Each is reported once, when it begins.
//
// World: the board's frame. A camera that stands sees the turntable's axis in one place
// (core/geometry/turn_axis.h).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/frames/frame.h"
#include "core/geometry/rigid3.h"
#include "core/geometry/turn_axis.h"

namespace ulf::coverage {

class TurntableWatch {
 public:
  // `board`: its name in messages.
  TurntableWatch(std::string board, FrameSource source) : board_(std::move(board)), source_(source) {}

  // Call it after every frame, with the device's time and the pose (none: the board is not seen). Returns
  // what to report; empty: nothing.
  std::string Update(double time_s, const std::optional<Rigid3>& cam_from_board);

 private:
  std::string IfUnseen(double time_s, bool seen);
  std::string IfStill(double time_s, const Rigid3& pose);
  std::string IfMoved(double time_s, const Rigid3& pose);

  std::string board_;
  FrameSource source_;
  std::optional<double> unseen_since_s_, still_since_s_, moved_since_s_;
  bool said_unseen_ = false, said_still_ = false;
  std::optional<Rigid3> still_pose_;
  std::vector<Rigid3> stand_;  // poses since the camera was set up
  std::optional<TurnAxis> axis_;
};

}  // namespace ulf::coverage
