// From what was asked for to a capture that can run: device, intrinsics, poses and folder that fit together,
// or a refusal that has written nothing; and what becomes of what a camera gives before there is a light
// field to put it in.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "acquisition/device/device.h"
#include "acquisition/device/frame_recording.h"
#include "core/light_field/light_field_io.h"
#include "coverage/session/capture_arguments.h"
#include "coverage/simulated_operator/simulated_operator.h"
#include "tracking/sources/pose_source.h"

namespace ulf::coverage {

// Takes from a started device what comes up to its first complete live frame, which is the last of `taken`;
// photographs that are released on the body meanwhile come before it. False when a stop was asked for first.
// Throws Error when no live frame comes; `taken` holds what came all the same.
bool TakeFirstFrames(acquisition::Device& device, const std::string& uri, const std::function<bool()>& stop,
                     std::vector<Frame>& taken);

// A capture that could not begin has photographs in hand: they, and those on their way, go to the light
// field's unposed/ where there is one (`writer`), else beside `dir` (kept_photographs.h). Says where on
// stderr, and what could not be kept. Stops the device.
void KeepPhotographs(acquisition::Device& device, const std::vector<Frame>& taken, LightFieldWriter* writer,
                     const std::filesystem::path& dir);

struct PreparedCapture {
  std::unique_ptr<acquisition::Device> device;
  std::shared_ptr<SimulatedOperator> person;  // who holds a simulated camera, if anybody
  std::vector<Frame> first;                   // what came until the first live frame, which is the last
  CameraModel camera;                         // of live frames
  acquisition::RecordingHeader recording;     // what --keep-frames says of the session
  std::unique_ptr<tracking::PoseSource> poses;
  std::unique_ptr<LightFieldWriter> writer;
};

// False when a signal came before the first frame: then nothing has been written. Photographs that came
// before it, or before a refusal, are kept (KeepPhotographs). `options` is completed by what device and
// folder say.
bool PrepareCapture(const CaptureArgs& args, CaptureOptions* options, PreparedCapture& prepared);

}  // namespace ulf::coverage
