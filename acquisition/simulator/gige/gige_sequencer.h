// The sequencer of the simulated camera (SFNC, "Sequencer Control"): sets of exposure times that the camera goes through
// by itself, one a frame. A set is saved with the exposure time that the camera has then; each names the next. While the
// sequencer runs, the register of the exposure time has no effect.
//
// All but BeforeRequest() belongs to the thread that takes frames; Aravis's camera answers requests in that thread, too.
#pragma once

#include <cstdint>

#include "acquisition/simulator/gige/gige_transport.h"

namespace ulf::acquisition {

class GigeSequencer {
 public:
  explicit GigeSequencer(RegisterAccess registers) : registers_(std::move(registers)) {}
  // Before Aravis gets a valid request.
  void BeforeRequest(const GvcpAccess& access);
  // Of the next frame, in microseconds: the running set's, else `otherwise`.
  std::uint32_t NextExposureUs(std::uint32_t otherwise);

 private:
  RegisterAccess registers_;
  bool runs_ = false;
  std::uint32_t set_ = 0;  // of the next frame
};

}  // namespace ulf::acquisition
