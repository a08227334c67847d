// Plays recorded frames as a device: `replay:PATH?fps=30&glob=*.color.jpg&transfer=linear&speed=1`.
//
//   a folder of images   in name order (numbers by value; by time if a camera's numbers began again), frame
//                        k = 0, 1, ... at k/fps seconds; mixed sizes or formats, a truncated file and an
//                        empty folder are errors at opening;
//   a video file         with the times of its container, or k/fps if `fps` is given;
//   a recorded session   (a folder with frames.jsonl, frame_recording.h) every frame with its time (k/fps if
//                        `fps` is given), exposure, gain, and the camera and pose that the device knew; a
//                        tethered camera's photographs at their place between the live frames;
//   a light field        (a folder with journal.jsonl or transforms.json, and no glob) the photographs of its
//                        views with their device times, exposures and poses, and its camera; k/fps replaces
//                        times that do not increase, as in imported sets, or all if `fps` is given.
//
// Without `speed`, or with speed=0, frames wait for Next() and none is dropped: the same path always gives
// the same frames, with host_time_s as recorded (0 in images and videos). With `speed` N they arrive N times
// as fast as they were taken, with host_time_s of their arrival, and are dropped and counted when the reader
// is slow (photographs are never dropped). The default of `fps` is 30.
//
// The photographs of a recorded session keep their place among the live frames and the times of their
// recorded requests, whether or not RequestStill() is called. RequestStill() returns kAsked while a requested
// photograph is still to come, else kBusy. So a session that runs again sees the same frames.
//
// A recorded session and a light field name the camera's maker, model, serial number and the part of the
// sensor that the images show, so that the stored calibration of that camera is found for them. If that part
// is missing (older light fields, photographs), the calibration is scaled by image size alone, with a
// warning. Intrinsics in the recording take precedence over a stored calibration, so that later calibrations
// do not change the result. The camera of other files is unknown.
//
// JPEG files are kept in Frame::encoded, so that a recording keeps them byte for byte. Pixels of 8 and 16
// bits are assumed to be sRGB and float linear unless `transfer` says otherwise.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "acquisition/device/device.h"

namespace ulf::acquisition {

// Throws Error for a path that cannot be played, Refusal for options that are invalid.
std::unique_ptr<Device> OpenReplayDevice(const DeviceUri& uri);

// Returns the URI with this speed, if one is given. Throws Refusal for a speed if the URI is no replay.
std::string WithReplaySpeed(const std::string& uri, const std::optional<double>& speed);

// Plays a recording in time, as a live camera: frames arrive at the intervals at which they were taken,
// `speed` times as fast, whether or not Next() is called. Up to four frames wait for a slow reader (as the
// cameras' default `queue`); then the oldest is dropped and counted. Photographs come before live frames that
// wait, and are never dropped. Next() throws what the recording's Next() throws. `recording`: not started,
// IsLive() is false.
std::unique_ptr<Device> MakePacedDevice(std::unique_ptr<Device> recording, double speed);

}  // namespace ulf::acquisition
