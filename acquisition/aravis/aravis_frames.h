// From a buffer of the library to a Frame: pixels, times, and what the camera's chunk data say of them.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "acquisition/aravis/aravis_configuration.h"
#include "core/image/frame.h"

namespace ulf::acquisition {

// Why a frame is not whole, for people.
std::string BufferStatusText(ArvBufferStatus status);

class AravisFrames {
 public:
  AravisFrames(const AravisSession& session, std::string who, AravisConfigured configured);
  ~AravisFrames();
  AravisFrames(const AravisFrames&) = delete;
  AravisFrames& operator=(const AravisFrames&) = delete;

  // kIncomplete when pixels are missing or it is not the image that was configured; then the picture is what
  // arrived over what the buffer held before.
  Frame Read(ArvBuffer* buffer);
  // Of the frames from here on.
  void SetLight(const AravisConfigured& now) {
    configured_.exposure_s = now.exposure_s;
    configured_.gain = now.gain;
    configured_.black_level = now.black_level;
  }
  // What is wrong with what the camera sends, once.
  std::vector<std::string> TakeNotes() { return std::exchange(notes_, {}); }

 private:
  bool FillComplete(ArvBuffer* buffer, Frame& frame);
  void FillIncomplete(ArvBuffer* buffer, Frame& frame);
  void ReadChunks(ArvBuffer* buffer, Frame& frame);

  std::string who_;
  AravisConfigured configured_;
  ArvChunkParser* chunks_ = nullptr;
  double tick_s_ = 1e-9;  // of the chunk timestamp
  std::vector<std::string> notes_;
  bool said_unexpected_ = false, said_no_chunks_ = false;
};

}  // namespace ulf::acquisition
