// Converts a buffer of the library to a Frame: pixels, times, and the camera's chunk data.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "acquisition/aravis/aravis_configuration.h"
#include "core/frames/frame.h"

namespace ulf::acquisition {

// Returns why the frame in a buffer of this status is incomplete, for messages.
std::string BufferStatusText(ArvBufferStatus status);

class AravisFrames {
 public:
  AravisFrames(const AravisSession& session, AravisConfigured configured);
  ~AravisFrames();
  AravisFrames(const AravisFrames&) = delete;
  AravisFrames& operator=(const AravisFrames&) = delete;

  // Returns a frame of status kIncomplete if pixels are missing or the image is not the configured one; its
  // image shows what arrived over the buffer's previous content, or is empty.
  Frame Read(ArvBuffer* buffer);
  // Sets exposure, gain and black level of the following frames.
  void SetLight(const AravisConfigured& now) {
    configured_.exposure_s = now.exposure_s;
    configured_.gain = now.gain;
    configured_.black_level = now.black_level;
  }
  // Sets Frame::on_shared_clock of the following frames.
  void SetSharedClock(bool is_shared) { on_shared_clock_ = is_shared; }
  // Returns messages about problems with the camera's data, each once.
  std::vector<std::string> TakeNotes() { return std::exchange(notes_, {}); }

 private:
  bool FillComplete(ArvBuffer* buffer, Frame& frame);
  void FillIncomplete(ArvBuffer* buffer, Frame& frame);
  void ReadChunks(ArvBuffer* buffer, Frame& frame);

  AravisConfigured configured_;
  ArvChunkParser* chunks_ = nullptr;
  double tick_s_ = 1e-9;          // of the chunk timestamp
  double chunk_exposure_us_ = 1;  // microseconds in one of the chunk's
  bool chunk_gain_is_factor_ = false, chunk_gain_is_known_ = true;
  std::vector<std::string> notes_;
  bool on_shared_clock_ = false;
  bool said_unexpected_ = false, said_no_chunks_ = false;
};

}  // namespace ulf::acquisition
