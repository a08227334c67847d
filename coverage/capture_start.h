// What a camera gives before there is a light field to put it in.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "acquisition/device.h"
#include "acquisition/light_field_io.h"

namespace ulf {

// Takes from a started device what comes up to its first complete live frame, which is the last of `taken`;
// photographs that are released on the body meanwhile come before it. False when a stop was asked for first.
// Throws Error when no live frame comes; `taken` holds what came all the same.
bool TakeFirstFrames(Device& device, const std::string& uri, const std::function<bool()>& stop,
                     std::vector<Frame>& taken);

// A capture that could not begin has photographs in hand: they, and those on their way, go to the light
// field's unposed/ where there is one (`writer`), else beside `dir` (kept_photographs.h). Says where on
// stderr, and what could not be kept. Stops the device.
void KeepPhotographs(Device& device, const std::vector<Frame>& taken, LightFieldWriter* writer,
                     const std::filesystem::path& dir);

}  // namespace ulf
