// Makes camera paths by name or from files.
//
//   TUM lines        time tx ty tz qx qy qz qw, world_from_cam
//   a light field    its folder or transforms.json: its views' poses and cameras, undistorted
//   keyframes        JSON of this program: {"keyframes": [{"time", "eye" and "target" or "rotation", ...}]}
//   camera path      JSON of nerfstudio's viewer: {"camera_path": [{"camera_to_world", "fov"}], ...}
//
// docs/rendering.md describes the keys of the JSON files.
#pragma once

#include <filesystem>
#include <string>

#include "render/output/camera_path.h"

namespace ulf::render {

struct PathRequest {
  std::string path = "orbit";  // a name or a file
  int frames = 0;              // of a named or keyframed path; 0: 120, or by the keyframes' times and `fps`
  CameraModel camera = {};     // for paths without cameras
  double fps = 30;             // for keyframed paths
  // The light field that is rendered: its transforms.json completes nerfstudio's files.
  std::filesystem::path light_field = {};
};

// Reads `file`, not request.path. Throws Error that names the file and the line, frame or key of a value that
// is missing, not finite, not a rotation or not supported, and for a path without a pose.
CameraPath PathFromFile(const std::filesystem::path& file, const PathRequest& request,
                        const RenderScene& scene);
// Makes the path of request.path, a name or a file. Throws as PathFromFile() does.
CameraPath MakePath(const PathRequest& request, const RenderScene& scene);

}  // namespace ulf::render
