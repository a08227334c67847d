// Decides whether the camera has a rolling shutter, from what the mapper measures as the map grows
// (readout_estimator.h), and reports it. On request it has the shutter compensated: the mapper removes the
// shift from the keyframes, adjusts the map and measures again until the readout no longer changes. A readout
// that was given stays; the search says when images contradict it.
#pragma once

#include <optional>

#include "tracking/map/map.h"
#include "tracking/map/mapper.h"
#include "tracking/tracker/readout.h"
#include "tracking/tracker/row_motion.h"

namespace ulf::tracking {

enum class ReadoutUse {
  kCompensate,  // a readout that is found is compensated in frames and in the map
  kReport,      // a readout that is found is reported only
  kGiven        // the readout was given and stays
};

class ReadoutSearch {
 public:
  // `rows` has the given readout for kGiven; otherwise the search sets it when it finds one.
  ReadoutSearch(RowMotion& rows, Mapper& mapper, ReadoutUse use);

  void Step();     // call it before every frame
  void Restart();  // call it after the lens was replaced
  // Returns the readout that was found or given; none if the shutter is global as far as is known.
  const std::optional<Readout>& found() const { return found_; }
  // Returns the magnitude, s, of a readout that may be there and is not compensated: what was measured, if
  // that is likely, or a usual one before anything was measured; 0: none.
  double Suspected() const;
  // Makes Suspected() return 0 until a readout is measured. Call it for a map of an earlier session, which
  // would have found a rolling shutter.
  void AssumeGlobalShutter() { last_ = ReadoutEstimate{}; }

 private:
  void Judge(const ReadoutEstimate& estimate, bool lens_is_doubted);
  void JudgeGiven(const ReadoutEstimate& estimate, double needed_sigmas);
  void Apply(double readout_s);
  void End() { mapper_.MeasureReadout(false); }

  RowMotion& rows_;
  Mapper& mapper_;
  ReadoutUse use_;
  std::optional<Readout> found_;
  std::optional<ReadoutEstimate> last_;
  int judged_ = 0;   // number of measurements
  int certain_ = 0;  // number of measurements in a row that found one, or contradict the given one
  int applied_ = 0;  // number of readouts
};

}  // namespace ulf::tracking
