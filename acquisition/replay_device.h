// Recorded frames as a device: `replay:PATH?fps=30&glob=*.color.jpg&transfer=linear&speed=1`.
//
//   a folder of images   in name order (numbers by value), the first at time 0, frame k at k/fps; mixed sizes
//                        or formats, a truncated file and an empty folder are errors when it is opened;
//   a video file         at the times of its container;
//   a recorded session   (a folder with frames.jsonl, see frame_recording.h) every frame as it was, with its
//                        time, exposure, gain and what the device knew of its camera and pose;
//   a light field        (a folder with journal.jsonl or transforms.json, and no glob) the photographs of its
//                        views with their device times, exposures and poses, and its camera; times that do
//                        not increase, as in imported sets, are replaced by k/fps.
//
// Frames wait until they are asked for, none is dropped, and the same path gives the same frames; host_time_s
// is 0 except in a light field and a recorded session: these frames did not reach this machine now. With
// `speed` they come in time (1: as they were taken, N: so much faster), as from a live camera, and are
// dropped and counted when the reader is slow; speed=0 is as without. JPEG files are named in Frame::encoded,
// so that a recording keeps them byte for byte. 8 and 16 bits are taken as sRGB and float as linear unless
// `transfer` says otherwise.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "acquisition/device.h"

namespace ulf {

std::unique_ptr<Device> OpenReplayDevice(const DeviceUri& uri);

// The URI with what `--speed` of a command says, where it was given. Throws UsageError when that is not a
// recording.
std::string WithReplaySpeed(const std::string& uri, const std::optional<double>& speed);

// Name order as people count: frame_2 before frame_10.
bool NameOrder(const std::string& a, const std::string& b);

}  // namespace ulf
