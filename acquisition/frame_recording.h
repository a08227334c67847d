// Every frame of a session, so that it can be run again: recorded views alone are what the session came to,
// not what it saw. Written by `ulf record` and `ulf capture --keep-frames`, read by `replay:`.
//
//   DIR/frames.jsonl      {"event": "header", version, device, camera}, then a line per frame in order:
//                         {"event": "frame", id, file, times, exposure, gain, ...}; and {"event": "note",
//                         text}
//   DIR/frames/00000001.tif  what the camera gave, not compressed; its own JPEG byte for byte
//
// Files are synced in batches and named in frames.jsonl only then: a process killed at any moment loses at
// most the last batch (half a second or 64 MB), and what is named is whole. Frames that the disk has no time
// or room for are counted and left out, never waited for.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/device.h"

namespace ulf {

struct FrameRecorderSummary {
  std::uint64_t written = 0;
  std::uint64_t left_out = 0;       // the disk was behind or full
  std::uint64_t bytes = 0;          // of files
  double encode_s = 0, disk_s = 0;  // of the writing thread
  std::string problem;              // what the disk said last; empty: nothing
};

// Throws Error when DIR holds something already: to be asked before the work begins.
void RequireNewRecording(const std::filesystem::path& dir);

class FrameRecorder {
 public:
  // DIR must not exist or be empty. `waiting_bytes`: of frames that may wait for the disk.
  FrameRecorder(const std::filesystem::path& dir, const DeviceInfo& device,
                const std::optional<CameraModel>& camera, std::size_t waiting_bytes = 512 << 20);
  ~FrameRecorder();
  FrameRecorder(const FrameRecorder&) = delete;
  FrameRecorder& operator=(const FrameRecorder&) = delete;

  // The pixels are copied. False when the frame was left out.
  bool TryAdd(const Frame& frame);
  // A line for whoever reads the recording: a fault, a gap.
  void Note(const std::string& text);
  // Why frames are left out at the moment; none: they are not.
  std::optional<std::string> Pause() const;
  // Writes what waits.
  FrameRecorderSummary Finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

struct FrameRecording {
  std::filesystem::path dir;
  DeviceInfo device;
  std::optional<CameraModel> camera;
  struct Entry {
    Frame frame;  // without pixels
    std::filesystem::path file;
  };
  std::vector<Entry> entries;
};

bool IsFrameRecording(const std::filesystem::path& dir);
// Throws Error naming file, line and key; a torn last line is left out.
FrameRecording ReadFrameRecording(const std::filesystem::path& dir);
// With its pixels. Throws Error when the file is missing or damaged.
Frame ReadRecordedFrame(const FrameRecording::Entry& entry);

}  // namespace ulf
