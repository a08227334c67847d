// Defines the scenes' solids: ray intersection, and flat charts of their surfaces for baked textures.
//
// Each primitive has its own frame ("local", metres):
//   sphere   centre at the origin, radius size[0]
//   box      centred at the origin, half sizes size[0..2]
//   room     a box seen from inside, which encloses the scene
//   frustum  round the z axis from z = 0 to size[2], radius size[0] below and size[1] above (equal radii: a
//            cylinder)
//   torus    round the z axis, radius size[0], tube radius size[1]
//   bust     a smooth head on shoulders, 0.6 size[0] high; its origin is in the neck, from where all of its
//            surface can be seen, z is up, -y the way it looks
#pragma once

#include <array>
#include <vector>

#include "acquisition/simulator/scene/lanes.h"
#include "core/geometry/rigid3.h"

namespace ulf::acquisition {

enum class Shape { kSphere, kBox, kRoom, kFrustum, kTorus, kBust };

// Describes what a surface does with light besides scattering it evenly (surface_light.h).
enum class Finish {
  kMatte,     // nothing
  kGlazed,    // mirrors the lamps and a plain room
  kPolished,  // mirrors the lamps and the scene
  kGlass,     // mirrors both, and lets the rest through: solid glass, which casts no shadow
};

struct Primitive {
  Shape shape = Shape::kSphere;
  std::array<float, 3> size{};
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // of the origin, world
  int material = 0;                                    // material::Name (materials.h)
  float texel_m = 0.001f;                              // side of a texel on the surface
  float light_m = 0.003f;          // distance between the points at which the incident light is computed
  bool of_subject = true;          // part of the subject, not of its surroundings
  Finish finish = Finish::kMatte;  // others: only spheres, frusta and busts; kGlass: no busts
  float mirrored = 0.045f;         // share of light that is mirrored at right angles; 0.045: index 1.54
  float glow = 1;       // its light over what the lamps give it: in a light box above 1, behind glass below
  bool thin = false;    // may be thinner than a pixel, which then gets more rays
  bool moves = false;   // moves with the scene's Sway
  int main_chart = -1;  // the only chart that needs full resolution; -1: all of them
  Eigen::Quaterniond world_from_local = Eigen::Quaterniond::Identity();
  // Set by SceneBuilder: the pose above as a transform, and the index of its first chart among the scene's.
  Rigid3 local_from_world = {};
  int first_chart = 0;

  int ChartCount() const;
  // Return centre and radius of the bounding sphere in the local frame.
  Vec3<float> BoundCenter() const;
  float BoundRadius() const;
  // Returns the largest distance of a point of the surface from `point_in_world`.
  double FarthestFrom(const Eigen::Vector3d& point_in_world) const;
};

// A point of the surface: its chart, coordinates (u, v) on the chart, 0 to 1, and normal (local; outward, in
// a room inward).
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
  bool wrap_u = false, wrap_v = false;  // whether opposite edges meet on the surface
};
ChartSize SizeOfChart(const Primitive& primitive, int chart);

// Returns the distance along a unit direction `d` from `o` (both local) to the surface ahead; infinity for a
// miss. From inside a torus or bust: 0.
template <typename T>
T Intersect(const Primitive& primitive, const Vec3<T>& o, const Vec3<T>& d);

extern template F8 Intersect<F8>(const Primitive&, const Vec3<F8>&, const Vec3<F8>&);
extern template double Intersect<double>(const Primitive&, const Vec3<double>&, const Vec3<double>&);

}  // namespace ulf::acquisition
