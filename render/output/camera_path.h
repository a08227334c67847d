// Camera paths, and the named ones around the subject (path_files.h has those in files). Poses in the light
// field's world.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "render/renderer/renderer.h"
#include "render/scene/scene.h"

namespace ulf::render {

struct CameraPath {
  std::vector<Rigid3> cam_from_world;
  std::vector<CameraModel> cameras;  // one for each pose, or empty where the path has none
  std::vector<Aperture> apertures;   // one for each pose, or empty where the path has none

  const CameraModel& CameraOf(std::size_t index, const CameraModel& otherwise) const {
    return cameras.empty() ? otherwise : cameras[index];
  }
};

// An ellipse through the viewpoints' directions, shrunk until it stays inside their hull, at their median
// distance, aimed at the subject; a full circle where the views stand all around the subject; to and fro
// along a row of views. One frame: the middle.
CameraPath OrbitPath(const RenderScene& scene, int frames);

// From the viewpoints' median distance straight towards the subject, down to `nearest_share` of that
// distance.
CameraPath DollyPath(const RenderScene& scene, int frames, double nearest_share = 0.5);

// The dolly while the lens zooms out, so that the plane through the subject's centre keeps its size and the
// background seems to move away (Hitchcock's Vertigo). `camera`: of the first picture.
CameraPath VertigoPath(const RenderScene& scene, int frames, const CameraModel& camera,
                       double nearest_share = 0.5);

// Three turns from the middle of the viewpoints to their rim and back, shrunk until the path stays inside
// their hull; where the views stand all around, three turns from the lowest to the highest view and back.
CameraPath SpiralPath(const RenderScene& scene, int frames);

// From the lowest to the highest of the viewpoints and back at their middle azimuth, across the rows of
// a scan; and from side to side at their middle elevation, along a row. Shrunk until the path stays
// inside their hull.
CameraPath RisePath(const RenderScene& scene, int frames);
CameraPath SweepPath(const RenderScene& scene, int frames);

// The smallest zoom, from 1 on, at which the photographs fill the pictures along the path. Cameras that were
// not held level leave the corners of pictures from other places uncovered.
double FillingZoom(Renderer& renderer, const CameraPath& path, const CameraModel& camera);

bool IsNamedPath(const std::string& path);
// Throws Refusal where `asked` pictures (0: any number) differ from the path's number of poses. `frames`: as
// it was asked for, such as "0:2/7".
void RequireFrames(const CameraPath& path, int asked, const std::string& frames);

// Which pictures of a path are rendered: a number of them, or a part of all, so that several machines can
// share the work.
struct FrameRange {
  int count = 0;  // pictures of the whole path; 0: the path's own number
  int first = 0;
  std::optional<int> end = {};  // one past the last; none: all
  bool operator==(const FrameRange&) const = default;
};

// "N": a path of N pictures; "A:B": the pictures A to B - 1, counted from 0, where A or B may be left out;
// "A:B/N": both. Throws Refusal.
FrameRange ParseFrames(const std::string& text);

}  // namespace ulf::render
