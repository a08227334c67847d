#include "render/proxy/subject_in_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <random>
#include <vector>

namespace ulf::render {
namespace {

// Lengths are shares of the sphere's radius. Guessed; tried on simulated scenes (tests/render/proxy/).
constexpr double kReach = 3;              // from the sphere's centre: farther surfaces are ignored
constexpr double kPlaneThickness = 0.05;  // to either side of the plane
constexpr double kLeastPlane =
    0.15;  // share of the area within reach that lies in the plane; less is no support
constexpr int kPlanesTried = 300;
constexpr double kSubjectInMeshInside =
    1.0;                                // surfaces with their middle nearer than this belong to the subject
constexpr double kLeastSurface = 0.03;  // share of the largest one's area; smaller surfaces are noise
constexpr double kSubjectInMeshLeftOut =
    0.02;                          // share of the area that may stick out of the sphere that is found
constexpr double kMostRadius = 2;  // more is the scene, not the subject

using Eigen::Vector3d;

struct Facet {
  std::size_t triangle = 0;
  Vector3d middle, normal;
  double area = 0;
};

// Returns facets within reach, in units of the sphere.
std::vector<Facet> FacetsNear(const TriangleMesh& mesh, const Subject& sphere, double reach) {
  std::vector<Facet> facets;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    std::array<Vector3d, 3> corners;
    for (std::size_t k = 0; k < 3; ++k)
      corners[k] =
          (mesh.vertices[mesh.triangles[i][k]].cast<double>() - sphere.center_in_world) / sphere.radius;
    const Vector3d middle = (corners[0] + corners[1] + corners[2]) / 3;
    if (middle.norm() > reach) continue;
    const Vector3d normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    const double twice = normal.norm();
    if (twice > 0) facets.push_back({i, middle, normal / twice, 0.5 * twice});
  }
  return facets;
}

double AreaOf(const std::vector<Facet>& facets) {
  double area = 0;
  for (const Facet& facet : facets) area += facet.area;
  return area;
}

struct Plane {
  Vector3d normal = Vector3d::UnitZ();
  double offset = 0;
  double Above(const Vector3d& point) const { return normal.dot(point) - offset; }
};

// Returns the plane with most area, its normal towards the sphere's centre; none if no plane has enough.
std::optional<Plane> Support(const std::vector<Facet>& facets) {
  constexpr double kSameNormal = 0.9;
  std::vector<double> up_to;  // running sum, to draw a facet by its area
  double area = 0;
  for (const Facet& facet : facets) up_to.push_back(area += facet.area);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> any(0, area);
  Plane best;
  double most = 0;
  for (int i = 0; i < kPlanesTried; ++i) {
    const auto drawn = std::ranges::lower_bound(up_to, any(random)) - up_to.begin();
    const Facet& seed = facets[std::min(static_cast<std::size_t>(drawn), facets.size() - 1)];
    const Plane plane{seed.normal, seed.normal.dot(seed.middle)};
    double in_plane = 0;
    for (const Facet& facet : facets)
      if (std::abs(plane.Above(facet.middle)) < kPlaneThickness &&
          std::abs(facet.normal.dot(plane.normal)) > kSameNormal)
        in_plane += facet.area;
    if (in_plane <= most) continue;
    most = in_plane;
    best = plane;
  }
  if (most < kLeastPlane * area) return std::nullopt;
  return best.offset > 0 ? Plane{-best.normal, -best.offset} : best;
}

class Union {
 public:
  explicit Union(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  }
  std::size_t RootOf(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void Join(std::size_t a, std::size_t b) { parent_[RootOf(a)] = RootOf(b); }

 private:
  std::vector<std::size_t> parent_;
};

// Returns the facets of the connected surfaces in the sphere.
std::vector<Facet> SurfacesInside(const TriangleMesh& mesh, const std::vector<Facet>& facets) {
  Union joined(mesh.vertices.size());
  for (const Facet& facet : facets) {
    const auto& corners = mesh.triangles[facet.triangle];
    joined.Join(corners[0], corners[1]);
    joined.Join(corners[0], corners[2]);
  }
  struct Surface {
    double area = 0;
    Vector3d middle = Vector3d::Zero();  // area-weighted sum
  };
  std::map<std::size_t, Surface> surfaces;
  const auto surface_of = [&](const Facet& facet) {
    return joined.RootOf(mesh.triangles[facet.triangle][0]);
  };
  for (const Facet& facet : facets) {
    Surface& surface = surfaces[surface_of(facet)];
    surface.area += facet.area;
    surface.middle += facet.area * facet.middle;
  }
  std::erase_if(surfaces, [&](const auto& surface) {
    return (surface.second.middle / surface.second.area).norm() > kSubjectInMeshInside;
  });
  double largest = 0;
  for (const auto& [id, surface] : surfaces) largest = std::max(largest, surface.area);
  std::vector<Facet> inside;
  for (const Facet& facet : facets)
    if (const auto found = surfaces.find(surface_of(facet));
        found != surfaces.end() && found->second.area >= kLeastSurface * largest)
      inside.push_back(facet);
  return inside;
}

// Returns the smallest ball round all but `left_out` of the area: it moves towards the farthest facet by
// decreasing steps (Badoiu and Clarkson 2003), ignoring the outermost facets.
Subject SmallestBall(std::vector<Facet> facets, double left_out) {
  const double may_stick_out = left_out * AreaOf(facets);
  Vector3d center = Vector3d::Zero();
  for (const Facet& facet : facets) center += facet.area / AreaOf(facets) * facet.middle;
  double radius = 0;
  constexpr int kSteps = 200;
  for (int step = 1; step <= kSteps; ++step) {
    std::ranges::sort(facets, std::greater<>(),
                      [&](const Facet& facet) { return (facet.middle - center).squaredNorm(); });
    double sticks_out = 0;
    auto farthest = facets.begin();
    while (farthest + 1 != facets.end() && sticks_out + farthest->area <= may_stick_out)
      sticks_out += (farthest++)->area;
    radius = (farthest->middle - center).norm();
    if (step < kSteps) center += (farthest->middle - center) / (step + 1);
  }
  return {center, radius};
}

}  // namespace

std::optional<Subject> SubjectInMesh(const TriangleMesh& mesh, const Subject& sphere) {
  std::vector<Facet> facets = FacetsNear(mesh, sphere, kReach);
  if (facets.empty()) return std::nullopt;
  if (const auto support = Support(facets))
    std::erase_if(facets, [&](const Facet& facet) { return support->Above(facet.middle) < kPlaneThickness; });
  const std::vector<Facet> inside = SurfacesInside(mesh, facets);
  if (inside.empty()) return std::nullopt;
  const Subject ball = SmallestBall(inside, kSubjectInMeshLeftOut);
  if (!(ball.radius > 0) || ball.radius > kMostRadius) return std::nullopt;
  return Subject{sphere.center_in_world + sphere.radius * ball.center_in_world, sphere.radius * ball.radius};
}

}  // namespace ulf::render
