// Ways of the virtual camera: named ones around the subject, and those that a file gives (path_files.h).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "render/scene/renderer.h"
#include "render/scene/scene.h"

namespace ulf::render {

struct CameraPath {
  std::vector<Rigid3> cam_from_world;
  std::vector<CameraModel> cameras;  // one for each pose where the path gives them, else empty
  std::vector<Aperture> apertures;   // the same

  const CameraModel& CameraOf(std::size_t index, const CameraModel& otherwise) const {
    return cameras.empty() ? otherwise : cameras[index];
  }
};

// An ellipse through the viewpoints' directions, shrunk until it stays inside their hull, at their median
// distance, aimed at the subject; a full circle where the views stand all around it; to and fro along a row.
// One frame: the middle.
CameraPath OrbitPath(const RenderScene& scene, int frames);

// From the viewpoints' median distance straight towards the subject, to `nearest_share` of it.
CameraPath DollyPath(const RenderScene& scene, int frames, double nearest_share = 0.5);

// The same way while the lens zooms out, so that the plane through the subject's centre keeps its size and
// what lies behind it seems to move away (Hitchcock's Vertigo). `camera` takes the first picture.
CameraPath VertigoPath(const RenderScene& scene, int frames, const CameraModel& camera,
                       double nearest_share = 0.5);

// Out from the middle of the viewpoints to their rim and back, three times round, shrunk until it stays
// inside their hull; where the views stand all around, from the lowest to the highest while going round.
CameraPath SpiralPath(const RenderScene& scene, int frames);

// The least zoom, 1 to 1.6, at which the photographs fill the pictures along the path: cameras held askew
// leave their corners uncovered from elsewhere. Tried on small pictures of a dozen poses; half a percent of
// them all may stay uncovered, and two of a single one: more zoom would cut off what the path is to show.
double ZoomThatFills(Renderer& renderer, const CameraPath& path, const CameraModel& camera);

struct PathRequest {
  std::string path = "orbit";  // a name, or a file's
  int frames = 0;              // of a named or keyframed path; 0: 120, or what the keyframes' times come to
  CameraModel camera = {};     // where the path gives none
  double fps = 30;
  std::filesystem::path light_field =
      {};  // that is rendered: what nerfstudio's files leave out stands beside it
};

bool IsNamedPath(const std::string& path);
// UsageError where a number of pictures was asked for (0: it was not) that the path has not: it gives as many
// poses as it gives. `option`: as it stood on the command line.
void RequireFrames(const CameraPath& path, int asked, const std::string& option);
// Throws PathFromFile()'s errors.
CameraPath MakePath(const PathRequest& request, const RenderScene& scene);

}  // namespace ulf::render
