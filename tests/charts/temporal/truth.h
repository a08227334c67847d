// The true pictures of a camera path: from the simulator, which can take a picture from any place, or from a
// folder of pictures of the same path that another program made.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <string>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "render/scene/scene.h"

namespace ulf::test {

class TruthSource {
 public:
  virtual ~TruthSource() = default;
  // Picture `index` of the path: CV_32FC3, B G R, linear light as Rendering::linear. Throws Error.
  virtual cv::Mat Picture(int index, const CameraModel& camera, const Rigid3& cam_from_world) = 0;
  // Depth along the optical axis at the pixels of that picture, CV_32F; empty where it is not known.
  virtual cv::Mat Depth(const CameraModel& /*camera*/, const Rigid3& /*cam_from_world*/) { return {}; }
  virtual bool TakesAnyCamera() const = 0;  // else `camera` must be the one that made the pictures
  // Throws Error unless the light field's photographs show this truth in its own world.
  virtual void RequireSameWorld(const render::RenderScene& scene) = 0;
};

// `name`: "sim:studio?seed=7", the device of a light field that was captured with poses in the simulator's
// world, or a folder of frame_00000.png (8 or 16 bits, sRGB) or .exr (linear light), numbered as by `ulf
// render -o FOLDER`. Throws Error for any other name.
std::unique_ptr<TruthSource> TruthFromName(const std::string& name);

}  // namespace ulf::test
