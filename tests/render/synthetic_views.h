// Viewpoints and photographs made up for the renderer's tests: cameras around a subject at the origin that
// all see one textured plane, so that any view can be computed exactly.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "render/scene.h"

namespace ulf::test {

// Evenly spread directions (a Fibonacci spiral) within `half_angle` of +z, at `distance` with relative
// jitter.
std::vector<Eigen::Vector3d> CapViewpoints(int count, double half_angle, double distance,
                                           double radial_jitter = 0, unsigned seed = 1);
// Around the z axis at an elevation, positions perturbed by `noise`.
std::vector<Eigen::Vector3d> RingViewpoints(int count, double elevation, double distance, double noise = 0,
                                            unsigned seed = 1);
// columns x rows in the plane z = distance.
std::vector<Eigen::Vector3d> GridViewpoints(int columns, int rows, double spacing, double distance);

struct SceneSpec {
  std::vector<Eigen::Vector3d> viewpoints;
  int width = 96, height = 72;
  double focal_px = 80;
  Distortion distortion = Distortion::kNone;
  bool two_sizes = false;  // every third view has a smaller image
  Subject subject{Eigen::Vector3d::Zero(), 0.3};
};

std::shared_ptr<RenderScene> MakeScene(const SceneSpec& spec);

// Linear light of the plane z = 0 at a point of it: smooth waves with some hard-edged tiles.
cv::Vec3f PlaneTexture(double x, double y);

// The photograph that a camera takes of the plane.
cv::Mat PhotographOfPlane(const CameraModel& camera, const Rigid3& cam_from_world);

// A light field on disk of the same views, without a subject unless asked.
void WriteLightField(const std::filesystem::path& dir, const SceneSpec& spec, bool with_subject);

}  // namespace ulf::test
