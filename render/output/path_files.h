// Camera paths out of files.
//
//   TUM lines        time tx ty tz qx qy qz qw, world_from_cam
//   a light field    its folder or transforms.json: its views' poses and cameras, undistorted
//   keyframes        ours, JSON: {"keyframes": [{"time", "eye" and "target" or "rotation", ...}]}
//   camera path      nerfstudio's viewer's export, JSON: {"camera_path": [{"camera_to_world", "fov"}], ...}
// docs/rendering.md describes the JSON files key by key.
#pragma once

#include <filesystem>

#include "render/output/camera_path.h"

namespace ulf::render {

// Throws Error naming the file and the line, frame or key for whatever is missing, not finite, not a rotation
// or not supported, and for a path without a pose.
CameraPath PathFromFile(const std::filesystem::path& file, const PathRequest& request,
                        const RenderScene& scene);

}  // namespace ulf::render
