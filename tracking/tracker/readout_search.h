// Decides whether the camera has a rolling shutter, from what the mapper measures as the map grows, says so,
// and, where asked to, has it compensated: the keyframes get their rows, the map is adjusted, and it is
// measured again until it stays.
#pragma once

#include <optional>

#include "tracking/estimation/row_motion.h"
#include "tracking/map/map.h"
#include "tracking/map/mapper.h"
#include "tracking/tracker/tracker.h"

namespace ulf::tracking {

class ReadoutSearch {
 public:
  // To compensate, changes `rows` when something was found; the map then, too.
  ReadoutSearch(const CameraModel& camera, RowMotion& rows, SharedMap& shared, Mapper& mapper,
                bool compensate);

  void Step();  // between frames
  const std::optional<Readout>& found() const { return found_; }

 private:
  void Judge(const ReadoutEstimate& estimate);
  void Apply(double readout_s);
  void End();

  CameraModel camera_;
  RowMotion& rows_;
  SharedMap& shared_;
  Mapper& mapper_;
  bool compensate_;
  std::optional<Readout> found_;
  int judged_ = 0;   // measurements
  int certain_ = 0;  // of these one after the other said that it rolls
  int applied_ = 0;
};

}  // namespace ulf::tracking
