// Determines what the proxy hides from a recorded view by a shadow map: a small depth map from the view.
//
// A point is compared with the four texels around it (percentage closer filtering, Reeves et al. 1987), so
// that visibility fades over one texel. The fade lies outside the proxy's outline, because a photograph
// mixes the colours of both sides there. Inverse depths are compared, because they are linear in the image
// over a plane, so that the tolerance for a slanted surface follows from their change per texel.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "render/proxy/triangle_mesh.h"
#include "render/proxy/view_depth_map.h"

namespace ulf::render {

struct ShadowMap {
  CameraModel camera;  // without distortion, covering the view's image
  // CV_32F, 1 / (depth along the optical axis) with tolerance: points of smaller inverse depth are hidden.
  cv::Mat least_inverse_depth;

  // Returns 0 (hidden) to 1 (visible). Points outside the map or behind the camera are visible.
  double Visibility(const Eigen::Vector3d& point_in_view) const;
};

// Width and height of all maps, whatever the shape of the photographs. Guessed.
inline constexpr int kShadowMapPx = 256;

// A point behind the proxy by less than this share of its depth is visible: proxies are rough. Guessed.
inline constexpr double kShadowMapTolerance = 0.01;

// Returns the camera of a view's map, without distortion: it covers what the view sees up to 71 degrees to
// each side of its axis.
CameraModel ShadowMapCamera(const CameraModel& view);
// Draws the map on the processor. `tolerance` is a share of the depth (kShadowMapTolerance).
ShadowMap MakeShadowMap(const TriangleMesh& occluder, const CameraModel& view_camera,
                        const Rigid3& view_from_world, double tolerance = kShadowMapTolerance);

using LazyShadowMap = Lazy<ShadowMap>;

}  // namespace ulf::render
