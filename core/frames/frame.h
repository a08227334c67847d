// An image as a device delivered it, with what is known about how it was taken.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "core/geometry/rigid3.h"
#include "core/image/image.h"

namespace ulf {

// kIncomplete: pixels are missing; such a frame is counted and displayed, but never tracked or recorded.
enum class FrameStatus { kComplete, kIncomplete };

// kStill is a photograph of a tethered camera in full resolution, which has its own intrinsics.
enum class FrameKind { kLive, kStill };

// The file as the camera wrote it. A light field keeps a camera's JPEG byte for byte.
struct EncodedImage {
  std::string extension;  // ".jpg", ".nef", ...: lower case
  std::shared_ptr<const std::string> bytes;
};

struct Frame {
  Image image;
  std::uint64_t id = 0;      // the device's own counter
  double device_time_s = 0;  // by the device's clock, at mid-exposure if the device tells it, else its start
  double host_time_s = 0;    // seconds since the epoch when the frame reached this machine
  double exposure_s = 0;     // 0: unknown
  double gain = 1;           // as a factor: 10^(dB/20)
  double black_level = 0;    // as a share of full scale
  std::optional<double> f_number;
  std::optional<double> focal_mm;  // of the lens, mm
  std::string lens = {};           // the lens model as its maker names it, ASCII; empty if unknown
  // The frame's number and the states of the camera's input and output lines, one bit each, if the camera
  // sends them with the picture (GenICam's chunk data).
  std::optional<std::uint64_t> told_id, line_status;
  bool on_shared_clock = false;  // device_time_s is by a clock that IEEE 1588 sets
  FrameStatus status = FrameStatus::kComplete;
  FrameKind kind = FrameKind::kLive;
  // If Device::RequestExposures() asked for this exposure: by how many stops it is longer than the usual one.
  std::optional<double> asked_stops = {};
  // The time on the device's clock at which the program released the shutter for a photograph; none if it
  // was released on the camera.
  std::optional<double> requested_s;
  std::optional<EncodedImage> encoded;  // the file of which `image` was decoded, if there is one
  std::optional<EncodedImage> raw;      // the raw file beside that, or alone: then `image` is its light
  // The pose, if the simulator or a replayed light field knows it. The tracker never uses it.
  std::optional<Rigid3> known_cam_from_world;
};

// Says where frames come from, by what the user of the program can still change about them: all advice names
// only what can be changed (tests/commands/capture/advice_test.cpp checks it).
enum class FrameSource {
  kSettableCamera,  // a camera in the hand, whose settings `ulf features` and the URI change
  kCamera,          // a camera in the hand, whose settings its URI changes, if anything does (the simulator)
  kRecording,       // frames of one motion that are taken already: a video, a recorded session
  kPhotographs,     // pictures that are taken already: the files of a folder, a light field's views
};
inline constexpr std::array kFrameSources{FrameSource::kSettableCamera, FrameSource::kCamera,
                                          FrameSource::kRecording, FrameSource::kPhotographs};

// Returns whether the pictures are taken already: neither camera, lamp nor subject can be changed any more.
inline bool IsTaken(FrameSource source) {
  return source == FrameSource::kRecording || source == FrameSource::kPhotographs;
}

// Says where a camera's settings are changed: "set the exposure (...)".
inline const char* WhereToSet(FrameSource source) {
  return source == FrameSource::kSettableCamera ? "in the URI, by ulf features, or at the camera"
                                                : "in the URI, or at the camera";
}

}  // namespace ulf
