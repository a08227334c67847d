// Every frame of a session, so that it can be run again: recorded views alone are what the session came to,
// not what it saw. Written by `ulf record` and `ulf capture --keep-frames`, read by `replay:`.
//
//   DIR/frames.jsonl      {"event": "header", version, device, sensor, camera, flat_field, and the same of
//                         photographs: takes_stills, still_camera, still_flat_field}, then a line per frame
//                         in the order in which they came: {"event": "frame", id, file, times, exposure,
//                         gain,
//                         ...}; of a photograph also still, requested_s, raw, and incomplete where its file
//                         is no whole picture; and {"event": "note", text}
//   DIR/frames/00000001.tif  what the camera gave, not compressed; its own JPEG byte for byte; a
//                         photograph's raw file beside it (00000001.nef)
//
// The header says which camera it was, so that a calibration is held against it as against the camera itself,
// and what the session was run with, so that it can be run again with the same. Incomplete live frames are
// not kept.
//
// Files are synced in batches and named in frames.jsonl only then: a process killed at any moment loses at
// most the last batch (half a second or 64 MB), and what is named is whole. Frames that the disk has no time
// or room for are counted and left out, never waited for; photographs only when there is no room.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/device/device.h"
#include "core/image/flat_field.h"

namespace ulf::acquisition {

// Where the frames came from, and the intrinsics that the session was run with; none: it had none, or they
// were not asked for.
struct RecordingHeader {
  DeviceInfo device = {};
  std::optional<SensorWindow> window = {};  // of the live frames
  bool takes_stills = false;
  std::optional<CameraModel> camera = {}, still_camera = {};
  std::optional<FlatField> flat_field = {}, still_flat_field = {};

  // What the device itself says.
  static RecordingHeader Of(const Device& device);
};

struct FrameRecorderSummary {
  std::uint64_t written = 0;
  std::uint64_t left_out = 0;  // the disk was behind or full
  std::uint64_t bytes = 0;     // of files
  double disk_s = 0;           // the writing thread was at work
  std::string problem;         // what the disk said last; empty: nothing
};

// Throws Error when DIR holds something already: to be asked before the work begins.
void RequireNewRecording(const std::filesystem::path& dir);

class FrameRecorder {
 public:
  // DIR must not exist or be empty. `waiting_bytes`: of frames that may wait for the disk.
  FrameRecorder(const std::filesystem::path& dir, const RecordingHeader& header,
                std::size_t waiting_bytes = 512 << 20);
  ~FrameRecorder();
  FrameRecorder(const FrameRecorder&) = delete;
  FrameRecorder& operator=(const FrameRecorder&) = delete;

  // The pixels are shared, not copied. False when the frame was left out.
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
  RecordingHeader header;
  struct Entry {
    Frame frame;                           // without pixels
    std::filesystem::path file, raw_file;  // empty: there is none
  };
  std::vector<Entry> entries;
};

bool IsFrameRecording(const std::filesystem::path& dir);
// Throws Error naming file, line and key; a torn last line is left out.
FrameRecording ReadFrameRecording(const std::filesystem::path& dir);
// With its pixels, and a photograph's raw file. Throws Error when a file is missing or damaged.
Frame ReadRecordedFrame(const FrameRecording::Entry& entry);

}  // namespace ulf::acquisition
