// The solids that scenes are built of: where a ray meets them, and how their surface unrolls into flat charts
// that textures are baked on.
//
// Each primitive lives in its own frame ("local", metres):
//   sphere   centre at the origin, radius size[0]
//   box      centred at the origin, half sizes size[0..2]
//   room     the same, seen from inside: the last thing that any ray meets
//   frustum  round the z axis from z = 0 to size[2], radius size[0] below and size[1] above (equal: a
//   cylinder) torus    round the z axis, radius size[0], tube radius size[1]
#pragma once

#include <array>
#include <vector>

#include "acquisition/simulator/scene/lanes.h"
#include "core/geometry/rigid3.h"

namespace ulf::acquisition {

enum class Shape { kSphere, kBox, kRoom, kFrustum, kTorus };

struct Primitive {
  Shape shape = Shape::kSphere;
  Rigid3 local_from_world;
  std::array<float, 3> size{};
  int material = 0;
  float texel_m = 0.002f;  // side of a texel on the surface
  float light_m = 0.003f;  // light that falls on it is computed every so far
  int main_chart = -1;     // the only chart that is looked at closely; -1: all of them
  bool glossy = false;
  bool of_subject = false;  // part of what is captured, not of its surroundings
  int first_chart = 0;      // into the scene's charts

  int ChartCount() const;
  // Bounding sphere, local.
  Vec3<float> BoundCenter() const;
  float BoundRadius() const;
  // The farthest that any point of the surface is from `point_in_world`.
  double FarthestFrom(const Eigen::Vector3d& point_in_world) const;
};

// A chart's place on the surface: local position and outward normal, and which chart at which (u, v).
struct SurfacePoint {
  int chart = 0;  // within the primitive
  float u = 0, v = 0;
  Vec3<float> normal{0, 0, 1};
};
SurfacePoint SurfaceAt(const Primitive& primitive, const Vec3<float>& local);

struct ChartPoint {
  Eigen::Vector3f local, normal;
};
ChartPoint PointOnChart(const Primitive& primitive, int chart, float u, float v);

struct ChartSize {
  float width_m = 0, height_m = 0;
  bool wrap_u = false, wrap_v = false;
};
ChartSize SizeOfChart(const Primitive& primitive, int chart);

// The distance along a unit direction `d` from `o` (both local) to the surface; infinity where it is missed.
template <typename T>
T Intersect(const Primitive& primitive, const Vec3<T>& o, const Vec3<T>& d);

extern template F8 Intersect<F8>(const Primitive&, const Vec3<F8>&, const Vec3<F8>&);
extern template double Intersect<double>(const Primitive&, const Vec3<double>&, const Vec3<double>&);

}  // namespace ulf::acquisition
