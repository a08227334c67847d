// Determines what the proxy hides from a recorded view, by a shadow map: a small depth map of the proxy from
// the view's place.
//
// A point is compared with the four texels around it (percentage closer filtering, Reeves et al. 1987), so
// that visibility fades over one texel. It fades one texel before an edge, where a photograph mixes the
// colours of both sides. Inverse depths are compared, because they are linear in the image over a plane, so
// that the tolerance for a slanted surface is exactly the change of its inverse depth over a texel.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "render/proxy/triangle_mesh.h"
#include "render/proxy/view_depth_map.h"

namespace ulf::render {

struct ShadowMap {
  CameraModel camera;           // without distortion, covering the view's image
  cv::Mat least_inverse_depth;  // CV_32F: points with a smaller inverse depth are hidden

  // Returns 0 for hidden to 1 for visible. Points outside the map are visible.
  double Visibility(const Eigen::Vector3d& point_in_view) const;
};

// Width and height of all maps, whatever the shape of the photographs. Guessed.
inline constexpr int kShadowMapPx = 256;

// A point behind the proxy by less than this share of its depth is visible: proxies are rough. Guessed.
inline constexpr double kShadowMapTolerance = 0.01;

// Returns the camera of a view's map: it covers what the view sees, without the view's distortion.
CameraModel ShadowMapCamera(const CameraModel& view);
ShadowMap MakeShadowMap(const TriangleMesh& occluder, const CameraModel& view_camera,
                        const Rigid3& view_from_world, double tolerance = kShadowMapTolerance);

using LazyShadowMap = Lazy<ShadowMap>;

}  // namespace ulf::render
