// Lumigraph weights at the vertices of a triangulation of the image (Buehler et al. 2001, section 4): a
// regular grid and the projected viewpoints, Delaunay. Between vertices weights are interpolated, linearly in
// the image.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "render/fields/lumigraph_field.h"
#include "render/fields/triangle_topology.h"

namespace ulf::render {

struct WeightedImageTriangulation {
  std::vector<Eigen::Vector2d> img;  // covers the image and a little more
  std::vector<std::vector<ViewWeight>> weights;
  std::vector<Triangle> triangles;
};

// How deep the proxy is at a point of the image.
using DepthAt = std::function<double(const Eigen::Vector2d& img)>;
// That of its pixel in `drawn` (CV_32F, or empty), or the plane's where that is 0.
DepthAt DepthFromPicture(const cv::Mat& drawn, const PlaneInCamera& plane, const CameraModel& camera);

// `options`: as FieldThatServes() gives them.
WeightedImageTriangulation TriangulateLumigraph(const RenderScene& scene, const CameraModel& camera,
                                                const Rigid3& cam_from_world, const DepthAt& depth_at,
                                                const FieldOptions& options);

// The same as a field, of rays of this camera only.
std::unique_ptr<FieldFromHere> LumigraphAtVertices(const RenderScene& scene, const CameraModel& camera,
                                                   const Rigid3& cam_from_world, const DepthAt& depth_at,
                                                   const FieldOptions& options);

// A corner of such a triangle as a ray: with unit z what is barycentric is linear in the image.
Eigen::Vector3d CornerRay(const CameraModel& camera, const Eigen::Vector2d& img);

}  // namespace ulf::render
