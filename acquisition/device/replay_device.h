// Recorded frames as a device: `replay:PATH?fps=30&glob=*.color.jpg&transfer=linear&speed=1`.
//
//   a folder of images   in name order (numbers by value), the first at time 0, frame k at k/fps; mixed sizes
//                        or formats, a truncated file and an empty folder are errors when it is opened;
//   a video file         at the times of its container;
//   a recorded session   (a folder with frames.jsonl, see frame_recording.h) every frame as it was, with its
//                        time, exposure, gain and what the device knew of its camera and pose; a tethered
//                        camera's photographs between the live frames, where they came;
//   a light field        (a folder with journal.jsonl or transforms.json, and no glob) the photographs of its
//                        views with their device times, exposures and poses, and its camera; times that do
//                        not increase, as in imported sets, are replaced by k/fps.
//
// Frames wait until they are asked for, none is dropped, and the same path gives the same frames; host_time_s
// is 0 except in a light field and a recorded session: these frames did not reach this machine now. With
// `speed` they come in time (1: as they were taken, N: so much faster), as from a live camera, and are
// dropped and counted when the reader is slow (photographs never are); speed=0 is as without.
//
// The photographer of a recorded session is the recorded one: its photographs come in their place among the
// live frames, asked for or not, each with the time of its own request. A request is answered by the next one
// that was asked for then; none is left: busy. So a session run again sees the same whatever it asks for, and
// what it would have photographed elsewhere it does without.
//
// A recorded session and a light field say whose they are (maker, model, serial, part of the sensor): a
// calibration is bound to them as to the camera itself, and found for them; of what does not say its part of
// the sensor (older light fields, photographs) a calibration is scaled by size alone, with a warning.
// Intrinsics that they bring themselves go before a stored calibration, so that the same comes out of them
// next year. Of other files nobody knows the camera.
//
// JPEG files are named in Frame::encoded, so that a recording keeps them byte for byte. 8 and 16 bits are
// taken as sRGB and float as linear unless `transfer` says otherwise.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "acquisition/device/device.h"

namespace ulf::acquisition {

std::unique_ptr<Device> OpenReplayDevice(const DeviceUri& uri);

// The URI with what `--speed` of a command says, where it was given. Throws UsageError when that is not a
// recording.
std::string WithReplaySpeed(const std::string& uri, const std::optional<double>& speed);

}  // namespace ulf::acquisition
