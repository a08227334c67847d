// What a picture of a camera path really looks like, where that is known: from the simulator, which can take
// a picture from anywhere, or from a folder of pictures of the same path that something else made.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <string>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "render/scene/scene.h"

namespace ulf::render {

class TruthSource {
 public:
  virtual ~TruthSource() = default;
  // CV_32FC3, B G R, linear light as a Rendering's, of picture `index` of the path. Throws Error.
  virtual cv::Mat Picture(int index, const CameraModel& camera, const Rigid3& cam_from_world) = 0;
  virtual bool TakesAnyCamera() const = 0;  // else `camera` is what the pictures were made with
  // Throws Error unless the light field's photographs show this truth in its own world.
  virtual void RequireSameWorld(const RenderScene& scene) = 0;
};

// A folder of frame_00000.png (8 or 16 bits, sRGB) or .exr (linear), as `ulf render -o FOLDER` numbers them.
std::unique_ptr<TruthSource> TruthFromFolder(const std::string& folder);

}  // namespace ulf::render
