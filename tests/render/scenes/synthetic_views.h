// Viewpoints and photographs made up for the renderer's tests: cameras around a subject at the origin that
// all see one textured plane, or a small square before it as well, so that any view can be computed exactly.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "core/light_field/folder/light_field_io.h"
#include "render/scene/scene.h"
#include "tests/support/floors.h"

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
  bool folds = false;      // a distorted lens would show what lies far beside the picture within it, too
  bool two_sizes = false;  // every third view has a smaller image
  Subject subject{Eigen::Vector3d::Zero(), 0.3};
  bool with_square = false;
  // Half floats of linear light; every fifth photograph has a hole in its middle.
  bool linear_with_gaps = false;
  double unit = 1;  // of what is above: the same scene, a thousand times larger or smaller
  bool operator==(const SceneSpec&) const = default;
};

// The square: |x| and |y| up to kSquareHalf at z = kSquareZ, seen from both sides.
inline constexpr double kSquareHalf = 0.15, kSquareZ = 0.35;
// The plane, as far as anybody sees, and the square.
std::shared_ptr<const TriangleMesh> PlaneAndSquare(double unit = 1);
// Points of the plane's middle and of the square, the same for the same counts.
std::vector<ScenePoint> PointsOfPlaneAndSquare(int on_plane, int on_square, double unit = 1);

// The caller's own scene. Its photographs may be shared with another one of the same spec: whoever changes
// one gives the view another.
std::shared_ptr<RenderScene> MakeScene(const SceneSpec& spec);

// Linear light of the plane z = 0 at a point of it: smooth waves with some hard-edged tiles.
cv::Vec3f PlaneTexture(double x, double y);

// The photograph that a camera takes of the plane: in linear light, CV_32FC3, and as 8-bit sRGB.
cv::Mat LightOfPlane(const CameraModel& camera, const Rigid3& cam_from_world, bool with_square = false);
cv::Mat PhotographOfPlane(const CameraModel& camera, const Rigid3& cam_from_world, bool with_square = false);

// A light field on disk of the same views, without a subject unless asked.
void WriteLightField(const std::filesystem::path& dir, const SceneSpec& spec, bool with_subject);

}  // namespace ulf::test
