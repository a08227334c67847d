// The cheapest way to look at a light field (thesis, section 4, the phone prototype): of all photographs the
// one whose direction from the subject is nearest to the virtual camera's, shown as the plane through the
// subject that faces the camera would show it. One homography a picture, no OpenGL; a step, not a blend,
// where the nearest photograph changes. FieldKind::kNearest chooses by pixel, and costs accordingly.
#pragma once

#include <memory>
#include <opencv2/core.hpp>

#include "core/base/progress.h"
#include "render/scene/scene.h"

namespace ulf::render {

class NearestViewRenderer {
 public:
  // Removes every photograph's distortion and brings them to one exposure: a copy of the first pyramid level
  // (SceneOptions::size_limit_px keeps it small).
  explicit NearestViewRenderer(const RenderScene& scene, Progress* progress = nullptr);

  // Index into the scene's views.
  int Nearest(const Rigid3& cam_from_world) const;
  // 8-bit sRGB, black where the photograph ends. `camera` must be free of distortion. Returns the view shown.
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
