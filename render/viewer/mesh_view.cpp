#include "render/viewer/mesh_view.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "core/base/at.h"
#include "core/geometry/pinhole.h"
#include "core/image/image.h"

namespace ulf::render {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

const Rgba kCoarse{255, 255, 255, 230}, kFine{255, 255, 255, 120}, kStrip{255, 200, 70, 110};

// Directions with a smaller z are far outside any picture.
double NearestShown(const Vector3d& p) {
  constexpr double kLeastCosine = 0.02;
  return kLeastCosine * p.norm();
}

// Returns the part of an edge that lies in front of the camera.
std::optional<std::pair<Vector2d, Vector2d>> Shown(const CameraModel& camera, Vector3d a, Vector3d b) {
  const double near = std::max(NearestShown(a), NearestShown(b));
  if (a.z() < near && b.z() < near) return std::nullopt;
  if (a.z() < near) a += (near - a.z()) / (b.z() - a.z()) * (b - a);
  if (b.z() < near) b += (near - b.z()) / (a.z() - b.z()) * (a - b);
  return std::pair(PinholeImg(camera, a), PinholeImg(camera, b));
}

// The sign of a triangle's corners depends on the side of the camera: an edge between triangles of both signs
// is drawn twice.
struct DrawnEdge {
  int from, to;
  bool negated;
  auto operator<=>(const DrawnEdge&) const = default;
};

class Drawing {
 public:
  Drawing(const CameraModel& camera, const Rigid3& cam_from_world)
      : camera_(camera),
        cam_from_world_r_(cam_from_world.RotationMatrix()),
        place_(cam_from_world.OriginInSource()) {}

  void AddEdges(const MeshField& field, double width, const Rgba& color) {
    const FieldMesh& mesh = field.field_mesh();
    const PlacedMesh placed = field.Place(place_);
    std::set<DrawnEdge> drawn;
    // Begins at the last triangle, so that an edge of mesh and strip is drawn as the mesh's.
    for (std::size_t t = mesh.triangles.size(); t-- > 0;) {
      if (placed.cone_from_ray[t].isZero(0)) continue;
      const Triangle& triangle = mesh.triangles[t];
      const Matrix3d corners = cam_from_world_r_ * placed.corners[t];
      const Vector3d first = mesh.positions[At(triangle[0])] - placed.virtual_center_in_world;
      const bool negated = first.dot(placed.corners[t].col(0)) < 0;
      for (int k = 0; k < 3; ++k) {
        const int next = (k + 1) % 3, a = triangle[At(k)], b = triangle[At(next)];
        if (!drawn.insert({std::min(a, b), std::max(a, b), negated}).second) continue;
        const auto shown = Shown(camera_, corners.col(k), corners.col(next));
        const bool strip = t < mesh.strips;
        if (shown)
          shapes_.emplace_back(
              Polyline{{shown->first, shown->second}, strip ? 1 : width, strip ? kStrip : color});
      }
    }
  }

  void AddViewpoints(const MeshField& field, const RenderScene& scene) {
    const PlacedMesh placed = field.Place(place_);
    std::set<DrawnEdge> drawn;
    for (std::size_t t = 0; t < field.field_mesh().triangles.size(); ++t) {
      if (placed.cone_from_ray[t].isZero(0) || t < field.field_mesh().strips) continue;
      for (int k = 0; k < 3; ++k) {
        const int vertex = field.field_mesh().triangles[t][At(k)];
        const Vector3d corner = cam_from_world_r_ * placed.corners[t].col(k);
        if (corner.z() < NearestShown(corner) || !drawn.insert({vertex, vertex, false}).second) continue;
        const int view = placed.view_of_vertex[At(vertex)];
        const cv::Vec3f bgr = ViewColor(scene.views[At(view)].id);
        const auto srgb = [](float linear) {
          return static_cast<std::uint8_t>(std::lround(255 * SrgbFromLinear(linear)));
        };
        shapes_.emplace_back(Spot{PinholeImg(camera_, corner), 6, {255, 255, 255}});
        shapes_.emplace_back(
            Spot{PinholeImg(camera_, corner), 5, {srgb(bgr[2]), srgb(bgr[1]), srgb(bgr[0])}});
      }
    }
  }

  Overlay Take() { return std::move(shapes_); }

 private:
  const CameraModel& camera_;
  Matrix3d cam_from_world_r_;
  Vector3d place_;
  Overlay shapes_;
};

}  // namespace

Overlay MeshView(const MeshField& coarse, const MeshField* fine, const RenderScene& scene,
                 const CameraModel& camera, const Rigid3& cam_from_world) {
  Drawing drawing(camera, cam_from_world);
  if (fine) drawing.AddEdges(*fine, 1, kFine);
  drawing.AddEdges(coarse, 2, kCoarse);
  drawing.AddViewpoints(coarse, scene);
  return drawing.Take();
}

}  // namespace ulf::render
