// Computes lumigraph weights at the vertices of a Delaunay triangulation of the image (Buehler et al. 2001,
// section 4). The vertices are a regular grid and the projected viewpoints; weights are linear between them.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "render/fields/blending_field.h"
#include "render/fields/field_options.h"
#include "render/fields/lumigraph_field.h"
#include "render/viewpoints/triangle_topology.h"

namespace ulf::render {

struct WeightedImageTriangulation {
  std::vector<Eigen::Vector2d> img;  // the vertices, px; they span the image and a margin of one pixel
  std::vector<std::vector<ViewWeight>> weights;  // per vertex; they sum to one, or are empty
  std::vector<Triangle> triangles;
};

// Returns the proxy's depth at a point of the image, world units.
using DepthAt = std::function<double(const Eigen::Vector2d& img)>;
// Reads depths from `drawn` (CV_32F: the proxy's triangles); where that is 0 or empty they are the plane's.
DepthAt DepthFromPicture(const cv::Mat& drawn, const PlaneInCamera& plane, const CameraModel& camera);

// `options` must be the result of FieldThatServes(); `camera` has no distortion.
WeightedImageTriangulation TriangulateLumigraph(const RenderScene& scene, const CameraModel& camera,
                                                const Rigid3& cam_from_world, const DepthAt& depth_at,
                                                const FieldOptions& options);

// Returns the same as a field for this camera's rays.
std::unique_ptr<PlacedField> LumigraphAtVertices(const RenderScene& scene, const CameraModel& camera,
                                                 const Rigid3& cam_from_world, const DepthAt& depth_at,
                                                 const FieldOptions& options);
}  // namespace ulf::render
