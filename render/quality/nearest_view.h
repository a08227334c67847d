// The cheapest renderer of a light field (thesis, section 4, the phone prototype). It shows the photograph
// whose direction from the subject is nearest to the virtual camera's, projected onto the plane through the
// subject that faces the camera. A picture is one homography, without OpenGL; it jumps when the nearest
// photograph changes. FieldKind::kNearest chooses a view for each pixel, which costs more.
#pragma once

#include <opencv2/core.hpp>

#include "core/base/progress.h"
#include "render/scene/scene.h"

namespace ulf::render {

class NearestViewRenderer {
 public:
  // Copies the finest level of every photograph, without distortion and with a common exposure
  // (SceneOptions::size_limit_px keeps the copies small). Throws Error for a scene without views.
  explicit NearestViewRenderer(const RenderScene& scene, Progress* progress = nullptr);

  // Returns an index into the scene's views.
  int Nearest(const Rigid3& cam_from_world) const;
  // Draws 8-bit sRGB, black beyond the photograph. `camera` must be undistorted. Returns the view shown.
  int Draw(const CameraModel& camera, const Rigid3& cam_from_world, cv::Mat& srgb8) const;

 private:
  struct Flat {
    CameraModel camera;
    Rigid3 cam_from_world;
    Eigen::Vector3d direction;  // from the subject, unit
    cv::Mat srgb8;
  };
  Subject subject_;
  std::vector<Flat> views_;
};

}  // namespace ulf::render
