// How far a recorded view sees: what lies behind the proxy is hidden from it.
//
// A small depth map of the proxy from the view's own place, as a shadow map. A point is compared with the
// four texels around it (percentage closer filtering, Reeves et al. 1987), so that visibility fades over a
// texel instead of breaking off; it does so a texel before an edge, whose colours a photograph mixes.
// Distances are compared as inverse depths, which are linear in the image over a plane: what a surface that
// is seen at a slant changes over a texel is allowed for exactly.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <mutex>
#include <opencv2/core.hpp>
#include <optional>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "render/proxy/triangle_mesh.h"

namespace ulf::render {

struct ShadowMap {
  CameraModel camera;           // without distortion, and wide enough for the view's own
  cv::Mat least_inverse_depth;  // CV_32F: points with a smaller one are hidden

  // 0 hidden to 1 seen. Points that fall outside the map are seen.
  double Visibility(const Eigen::Vector3d& point_in_view) const;
};

// Width and height of the maps of all views, whatever the shape of their images.
inline constexpr int kShadowMapPx = 256;
// A point may lie behind the proxy by this share of its depth: proxies are rough.
inline constexpr double kShadowMapTolerance = 0.01;

// Of the map of a view with this camera: what it sees, without its distortion.
CameraModel ShadowMapCamera(const CameraModel& view);
ShadowMap MakeShadowMap(const TriangleMesh& occluder, const CameraModel& view_camera,
                        const Rigid3& view_from_world);

// Made when it is first asked for, by whichever thread: of many views a picture needs few.
class LazyShadowMap {
 public:
  LazyShadowMap(std::shared_ptr<const TriangleMesh> occluder, const CameraModel& view_camera,
                const Rigid3& view_from_world)
      : occluder_(std::move(occluder)), view_camera_(view_camera), view_from_world_(view_from_world) {}
  const ShadowMap& Get() const {
    std::call_once(made_,
                   [this] { shadow_map_ = MakeShadowMap(*occluder_, view_camera_, view_from_world_); });
    return *shadow_map_;
  }

 private:
  std::shared_ptr<const TriangleMesh> occluder_;
  CameraModel view_camera_;
  Rigid3 view_from_world_;
  mutable std::once_flag made_;
  mutable std::optional<ShadowMap> shadow_map_;
};

}  // namespace ulf::render
