// Records every frame of a session, so that the session can be run again (`replay:`).
//
//   DIR/frames.jsonl         {"event": "header", version, device, sensor, camera, flat_field, color_profile,
//                             takes_stills, still_camera, still_flat_field, still_color_profile}
//                            then one line per frame, in the order of arrival:
//                            {"event": "frame", id, file, times, exposure, gain, ...}
//                            of a photograph also still, requested_s, raw, and incomplete where its file
//                            is not a whole picture
//                            {"event": "note", text}
//   DIR/frames/00000001.tif  the pixels of the camera, not compressed; or its own JPEG byte for byte; a
//                            photograph's raw file stands beside it (00000001.nef)
//
// The header identifies the camera, so that a calibration is checked against it, and holds the intrinsics
// with which the session was run.
//
// Files are synced in batches and then named in frames.jsonl: a process killed at any moment loses at most
// the last batch, and a file that is named is whole. Frames that the disk has no time or room for are counted
// and left out; photographs only when there is no room.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/device/device.h"
#include "core/image/color_profile.h"
#include "core/image/flat_field.h"

namespace ulf::acquisition {

// Says from which device the frames come, and holds the intrinsics of the session; none if it had none.
struct RecordingHeader {
  DeviceInfo device = {};
  std::optional<SensorWindow> window = {};  // of the live frames
  bool takes_stills = false;
  std::optional<CameraModel> camera = {}, still_camera = {};
  std::optional<FlatField> flat_field = {}, still_flat_field = {};
  std::optional<ColorProfile> color_profile = {}, still_color_profile = {};

  // Makes the header from what the device itself knows.
  static RecordingHeader Of(const Device& device);
};

struct FrameRecorderSummary {
  std::uint64_t written = 0;
  std::uint64_t left_out = 0;  // the disk was behind or full
  std::uint64_t bytes = 0;     // of files
  double disk_s = 0;           // seconds in which the writing thread worked
  std::string problem;         // the last problem of the disk; empty: none
};

// Throws Error if DIR is not empty or cannot be written. Commands call it before the work begins.
void RequireNewRecording(const std::filesystem::path& dir);

struct FrameRecorderOptions {
  // The most bytes of frames that wait for the disk; with more, live frames are left out. Guessed.
  std::size_t waiting_bytes = 512 << 20;
};

// Writes in a thread of its own. Any thread may call TryAdd(), Note() and Pause().
class FrameRecorder {
 public:
  // DIR must not exist or be empty. Throws DiskFullError, Error.
  FrameRecorder(const std::filesystem::path& dir, const RecordingHeader& header,
                const FrameRecorderOptions& options = {});
  ~FrameRecorder();
  FrameRecorder(const FrameRecorder&) = delete;
  FrameRecorder& operator=(const FrameRecorder&) = delete;

  // The pixels are shared, not copied. Returns false if too many frames wait, and this one is left out.
  bool TryAdd(const Frame& frame);
  // Adds a line of text for readers of the recording: a fault, a gap.
  void Note(const std::string& text);
  // Returns why frames are left out at this moment, for people; none if they are kept.
  std::optional<std::string> Pause() const;
  // Writes the frames that wait and ends.
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
// Ignores a truncated last line. Throws Error that names file, line and key, or if there are no frames.
FrameRecording ReadFrameRecording(const std::filesystem::path& dir);
// Returns the frame with its pixels and any raw file. Throws Error when a file is missing or damaged.
Frame ReadRecordedFrame(const FrameRecording::Entry& entry);

}  // namespace ulf::acquisition
