// Where a tethered camera stores its photographs: on its card or in volatile memory.
#pragma once

#include <optional>
#include <string>

#include "acquisition/gphoto2/gphoto_camera.h"

namespace ulf::acquisition {

// Selects card or memory; `to_card` none: the card if there is one with free space. True: photographs go to
// memory. Throws UsageError for a target that the camera does not offer, Error when it refuses one.
bool ChooseTarget(GphotoCamera& camera, const std::string& uri, std::optional<bool> to_card);

// Whether a file is in the camera's volatile memory, from which it is deleted after its download. Files on a
// card are never deleted.
bool IsInCameraMemory(const std::string& folder, bool target_is_memory);

}  // namespace ulf::acquisition
