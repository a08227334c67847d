// Restores the tracker's map when a capture is resumed: from the file that the last session left under the
// light field's cache/, or from the recorded views with their poses. The file is a cache: one that is
// missing, damaged, of another version, or of other views or poses is not used.
#pragma once

#include "core/light_field/light_field.h"
#include "tracking/tracker/pose_source.h"

namespace ulf::coverage {

// `tracked`: the lens of the images that the tracker gets; `poses`: the tracker, before its first frame.
// Throws Error when the views show too little in common. Logs when the map is made again, why, and about how
// long that takes.
void RestoreOrSeedMap(const LightField& light_field, const CameraModel& tracked, tracking::PoseSource& poses);

// Saves the map for the next session; says on stderr when it cannot be written.
void SaveMapCache(const LightField& light_field, const CameraModel& tracked,
                  const tracking::PoseSource& poses);

}  // namespace ulf::coverage
