// Makes camera paths around the subject, which have names; path_files.h reads those in files. Poses are in
// the light field's world. The named paths throw Error if all views stand at the subject's centre.
#pragma once

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
  std::vector<CameraModel> cameras;  // one for each pose, or empty if the path has none
  std::vector<Aperture> apertures;   // one for each pose, or empty if the path has none

  const CameraModel& CameraOf(std::size_t index, const CameraModel& otherwise) const {
    return cameras.empty() ? otherwise : cameras[index];
  }
};

// Goes along an ellipse through the viewpoints' directions, shrunk until it stays inside their hull, at their
// median distance, aimed at the subject; along a full circle if the views stand all around the subject; to
// and fro along a row of views. If `frames` is 1, the pose is in the middle.
CameraPath OrbitPath(const RenderScene& scene, int frames);

// Goes straight towards the subject, from the viewpoints' median distance to `nearest_share` of it.
CameraPath DollyPath(const RenderScene& scene, int frames, double nearest_share = 0.5);

// Zooms out while the camera approaches, so that the plane through the subject's centre keeps its size and
// the background seems to recede (Hitchcock's Vertigo). `camera` is that of the first picture.
CameraPath VertigoPath(const RenderScene& scene, int frames, const CameraModel& camera,
                       double nearest_share = 0.5);

// Makes three turns from the middle of the viewpoints to their rim and back, shrunk until the path stays
// inside their hull; if the views stand all around, three turns from the lowest to the highest view and back.
CameraPath SpiralPath(const RenderScene& scene, int frames);

// RisePath goes from the lowest to the highest of the viewpoints and back at their middle azimuth, across the
// rows of a scan; SweepPath from side to side at their middle elevation, along a row. Both are shrunk until
// the path stays inside their hull.
CameraPath RisePath(const RenderScene& scene, int frames);
CameraPath SweepPath(const RenderScene& scene, int frames);

// Passes smoothly through the places of some of the views, in their order, and looks where they look.
CameraPath WalkPath(const RenderScene& scene, int frames);

struct FillingLens {
  double zoom = 1;            // factor of the focal length
  double black_at_worst = 0;  // share of the pixels of a tried picture that no photograph fills
};

// Returns the smallest zoom from 1 to 1.6 at which photographs fill the pictures along the path: the field's
// own views but for half a per cent, all views everywhere. If black stays at 1.6, the smallest with the half
// per cent alone; 1.6 if none has that. Cameras that were not held level leave the corners of pictures from
// other places uncovered. Renders small pictures at some poses.
FillingLens FillingZoom(Renderer& renderer, const CameraPath& path, const CameraModel& camera);

bool IsNamedPath(const std::string& path);
// Throws Refusal if `asked` pictures (0: any number) differ from the path's number of poses. `frames` quotes
// the request, such as "0:2/7".
void RequireFrames(const CameraPath& path, int asked, const std::string& frames);

// Selects the pictures of a path that are rendered: their number, or a part for one of several machines.
struct FrameRange {
  int count = 0;  // pictures of the whole path; 0: the path's own number
  int first = 0;
  std::optional<int> end = {};  // one past the last; none: all
  bool operator==(const FrameRange&) const = default;
};

// Parses "N", a path of N pictures; "A:B", the pictures A to B - 1, counted from 0, where A or B may be left
// out; or "A:B/N" for both. Throws Refusal.
FrameRange ParseFrames(const std::string& text);

}  // namespace ulf::render
