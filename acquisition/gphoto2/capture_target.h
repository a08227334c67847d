// Where a tethered camera puts its photographs: its card, or memory that forgets.
#pragma once

#include <optional>
#include <string>

#include "acquisition/gphoto2/gphoto_camera.h"

namespace ulf::acquisition {

// To the card or not; without a word to the card, where there is one with room. True when photographs go to
// memory. Throws UsageError for what the camera does not offer, Error for what it refuses.
bool ChooseTarget(GphotoCamera& camera, const std::string& uri, std::optional<bool> to_card);

// The camera's own memory, which forgets: there the file is taken away after its download. Never from a card.
bool IsInCameraMemory(const std::string& folder, bool target_is_memory);

}  // namespace ulf::acquisition
