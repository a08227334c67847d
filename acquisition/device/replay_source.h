// Reads the frames of a replay in order: of a folder, a video, a light field or a recorded session.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "acquisition/device/frame_recording.h"

namespace ulf::acquisition {

// The URI's options; replay_device.h describes them.
struct ReplayOptions {
  std::string uri;  // for messages
  std::filesystem::path path;
  std::optional<double> fps;
  std::optional<std::string> glob;
  std::optional<Transfer> transfer;
  double speed = 0;  // 0: frames wait for the reader

  // Returns the time, s, of frame `index` if it has none of its own.
  double TimeOf(std::size_t index) const;
  Transfer TransferOf(const cv::Mat& pixels) const {
    return transfer.value_or(pixels.depth() == CV_32F ? Transfer::kLinear : Transfer::kSrgb);
  }
};

class ReplaySource {
 public:
  virtual ~ReplaySource() = default;
  virtual std::string Describe() const = 0;  // for people: "12 images (JPEG), 640x480"
  virtual FrameSource Source() const = 0;
  virtual bool HasLiveFrames() const { return true; }
  // Returns the camera and what is known of it; `device.uri` is not used.
  virtual RecordingHeader Header() const {
    RecordingHeader header;
    header.device.bus = "files";
    return header;
  }
  // Returns whether photographs that the recorded session requested are still to come.
  virtual bool HasRequestedPhotographs() const { return false; }
  virtual void Rewind() = 0;
  // Returns none at the end. Throws Error for a file that cannot be read, or differs in kind from the first.
  virtual std::optional<Frame> Next() = 0;
  virtual double Length() const = 0;  // frames; 0: unknown
};

// Opens what the path holds. Throws Error if it cannot be played, Refusal for options that do not fit it.
std::unique_ptr<ReplaySource> OpenReplaySource(const ReplayOptions& options);

}  // namespace ulf::acquisition
