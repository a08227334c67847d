// Ways of the virtual camera: named ones around the subject, and those that a file gives.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "acquisition/camera_model.h"
#include "acquisition/rigid3.h"
#include "render/renderer.h"
#include "render/scene.h"

namespace ulf {

struct CameraPath {
  std::vector<Rigid3> cam_from_world;
  std::vector<CameraModel> cameras;  // one for each pose where the file gives them, else empty
};

// An ellipse through the viewpoints' directions, shrunk until it stays inside their hull, at their median
// distance, aimed at the subject; a full circle where the views stand all around it; to and fro along a row.
// One frame: the middle.
CameraPath OrbitPath(const RenderScene& scene, int frames);

// From the viewpoints' median distance straight towards the subject, to `nearest_share` of it.
CameraPath DollyPath(const RenderScene& scene, int frames, double nearest_share = 0.5);

// Poses of a file: TUM lines (time tx ty tz qx qy qz qw, world_from_cam), or a light field (folder or
// transforms.json) with its cameras, undistorted. Throws Error naming file and line.
CameraPath PathFromFile(const std::filesystem::path& file);

// The least zoom, 1 to 1.6, at which the photographs fill the pictures along the path: cameras held askew
// leave their corners uncovered from elsewhere. Tried on small pictures of a dozen poses; up to half a
// percent may stay uncovered.
double ZoomThatFills(Renderer& renderer, const CameraPath& path, const CameraModel& camera);

// "orbit", "dolly", or a file; `frames` concerns the named ones.
CameraPath MakePath(const std::string& name, const RenderScene& scene, int frames);

}  // namespace ulf
