#include "render/viewpoints/viewpoint_mesh.h"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "core/base/at.h"
#include "core/base/counted.h"
#include "core/base/quantile.h"
#include "core/geometry/angles.h"
#include "render/viewpoints/delaunay.h"
#include "render/viewpoints/near_directions.h"

namespace ulf::render {
namespace {

// A rim triangle whose circumscribed cap has a radius of more than this many local spacings is removed; an
// interior one loses confidence. Guessed.
constexpr double kWideTriangle = 3.0;
// Radians. A gap into which a cap of this radius fits is an opening of the mesh, a smaller one is a hole that
// triangles cover. Guessed.
constexpr double kOpeningRad = 60.0 * 3.14159265358979323846 / 180.0;
// Directions closer than this share of the local spacing share one vertex, others get a vertex each.
// Guessed.
constexpr double kDuplicateShare = 0.1;
// The local spacing is at least this share of the usual one: the tremor of a standing camera is no spacing.
// Guessed.
constexpr double kLeastSpacingShare = 0.2;
// Rank of the neighbour that gives the local spacing: about the valence of a regular mesh.
constexpr int kSpacingNeighbour = 6;
// The mesh is a surface when at least this share of its vertices is interior, else a line. Guessed.
constexpr double kLeastInteriorShare = 0.1;
// Length of the outward tangents over the median distance: further than a picture looks past the rim.
// Guessed.
constexpr double kOutwardOverDistance = 8;
// Cosine. An outward direction away from the cap's middle is used when its cosine with the boundary's
// normal is larger, else the normal itself: the direction would lead back over the mesh. Guessed.
constexpr double kLeastOutwardCosine = 0.2;

using Eigen::Vector3d;

std::vector<Vector3d> Directions(const ViewpointMesh& mesh) {
  std::vector<Vector3d> directions;
  for (const auto& vertex : mesh.vertices)
    directions.push_back((vertex.position_in_world - mesh.center_in_world).normalized());
  return directions;
}

Vector3d Sum(const std::vector<Vector3d>& vectors) {
  Vector3d sum = Vector3d::Zero();
  for (const Vector3d& vector : vectors) sum += vector;
  return sum;
}

// Tolerance of chords between unit vectors, far above rounding.
constexpr double kRounding = 1e-7;

// Returns for each direction the angle to its n-th nearest: about the length of an edge of a triangulation
// there, even with duplicates.
std::vector<double> LocalSpacing(const std::vector<Vector3d>& directions, const NearDirections& near,
                                 int neighbour) {
  std::vector<double> spacing(directions.size(), 0.0);
  const std::size_t rank = std::min(At(neighbour), directions.size() - 1);
  if (rank == 0) return spacing;
  std::vector<double> cosines;
  for (std::size_t i = 0; i < directions.size(); ++i) {
    cosines.clear();
    near.Within(directions[i], near.ChordOfNearest(directions[i], rank + 1) + kRounding, [&](std::size_t j) {
      if (j != i) cosines.push_back(-directions[i].dot(directions[j]));
    });
    const auto nth = cosines.begin() + static_cast<std::ptrdiff_t>(rank - 1);
    std::nth_element(cosines.begin(), nth, cosines.end());
    spacing[i] = std::acos(std::clamp(-*nth, -1.0, 1.0));
  }
  return spacing;
}

// Returns the angle between neighbours if as many directions were spread evenly over the cap that contains
// them.
double EvenSpacing(const std::vector<Vector3d>& directions) {
  const Vector3d middle = Sum(directions);
  double half_angle = 0;
  for (const Vector3d& direction : directions)
    half_angle = std::max(half_angle, AngleBetween(middle, direction));
  return std::sqrt(2 * M_PI * (1 - std::cos(half_angle)) / static_cast<double>(directions.size()));
}

// Groups directions closer than a share of the local spacing.
std::vector<std::vector<std::size_t>> GroupOnce(const std::vector<Vector3d>& directions) {
  constexpr double kSameRad = 1e-6;  // CGAL merges directions that are closer
  const NearDirections near(directions);
  const std::vector<double> spacing = LocalSpacing(directions, near, kSpacingNeighbour);
  // If all cameras stood still the median is only their tremor; the even spacing is then larger.
  const double floor = kLeastSpacingShare * std::max(Median(spacing), EvenSpacing(directions));
  std::vector<std::vector<std::size_t>> groups;
  constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  std::vector<std::size_t> begun_by(directions.size(), kNone);  // the group whose first direction this is
  for (std::size_t i = 0; i < directions.size(); ++i) {
    const double merge_rad = std::max(kSameRad, kDuplicateShare * std::max(spacing[i], floor));
    std::size_t home = kNone;  // the first one within reach; a chord is shorter than its angle
    near.Within(directions[i], merge_rad + kRounding, [&](std::size_t j) {
      if (begun_by[j] < home && AngleBetween(directions[j], directions[i]) < merge_rad) home = begun_by[j];
    });
    if (home == kNone) {
      begun_by[i] = groups.size();
      groups.push_back({i});
    } else {
      groups[home].push_back(i);
    }
  }
  return groups;
}

// Groups views in nearly the same direction; the first of a group is the one nearest to the median distance.
// Grouping makes the directions sparser, so it is repeated until nothing changes.
std::vector<std::vector<int>> GroupDuplicates(const std::vector<int>& views,
                                              const std::vector<Vector3d>& directions,
                                              const std::vector<double>& distances, double median_distance) {
  std::vector<std::vector<std::size_t>> groups(directions.size());
  for (std::size_t i = 0; i < directions.size(); ++i) groups[i] = {i};
  for (std::size_t before = groups.size() + 1; groups.size() < before;) {
    before = groups.size();
    std::vector<Vector3d> heads;
    for (const auto& group : groups) heads.push_back(directions[group.front()]);
    std::vector<std::vector<std::size_t>> merged;
    for (const std::vector<std::size_t>& together : GroupOnce(heads)) {
      auto& out = merged.emplace_back();
      for (const std::size_t group : together)
        out.insert(out.end(), groups[group].begin(), groups[group].end());
    }
    groups = merged;
  }
  std::vector<std::vector<int>> result;
  for (std::vector<std::size_t>& group : groups) {
    const auto off_median = [&](std::size_t i) { return std::abs(distances[i] - median_distance); };
    const auto best = std::ranges::min_element(
        group, [&](std::size_t a, std::size_t b) { return off_median(a) < off_median(b); });
    std::rotate(group.begin(), best, best + 1);
    auto& out = result.emplace_back();
    for (const std::size_t i : group) out.push_back(views[i]);
  }
  return result;
}

double CapRadius(const std::vector<Vector3d>& directions, const Triangle& t) {
  const Vector3d &a = directions[At(t[0])], &b = directions[At(t[1])], &c = directions[At(t[2])];
  const Vector3d pole = (b - a).cross(c - a);
  const double length = pole.norm();
  return length > 0 ? std::acos(std::clamp(pole.dot(a) / length, -1.0, 1.0)) : M_PI;
}

// Returns the median angle of the edges at each triangle's corners: the local spacing of the mesh.
std::vector<double> SpacingOfTriangles(const std::vector<Vector3d>& directions,
                                       const std::vector<Triangle>& triangles) {
  std::vector<std::vector<double>> edges_at(directions.size());
  for (const Triangle& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const int from = t[k], to = t[(k + 1) % 3];
      const double angle = AngleBetween(directions[At(from)], directions[At(to)]);
      edges_at[At(from)].push_back(angle);
      edges_at[At(to)].push_back(angle);
    }
  std::vector<double> at_vertex(directions.size(), 0.0);
  for (std::size_t v = 0; v < directions.size(); ++v)
    if (!edges_at[v].empty()) at_vertex[v] = Median(edges_at[v]);
  std::vector<double> of_triangle;
  for (const Triangle& t : triangles)
    of_triangle.push_back(Median({at_vertex[At(t[0])], at_vertex[At(t[1])], at_vertex[At(t[2])]}));
  return of_triangle;
}

void Keep(std::vector<Triangle>& triangles, std::vector<double>& along, const std::vector<bool>& keep) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < triangles.size(); ++i)
    if (keep[i]) {
      triangles[kept] = triangles[i];
      along[kept++] = along[i];
    }
  triangles.resize(kept);
  along.resize(kept);
}

// Removes rim triangles whose cap is wider than `wide_triangle` times the local spacing, widest first within
// a round, and only where the corner behind the rim edge is interior: the rest stays manifold and keeps all
// vertices. `cap_ratio` is the cap's radius over the local spacing; it is kept along with the triangles.
void PeelRim(int vertex_count, double wide_triangle, std::vector<Triangle>& triangles,
             std::vector<double>& cap_ratio) {
  for (bool peeled = true; peeled;) {
    peeled = false;
    const TriangleTopology topology = MakeTopology(vertex_count, triangles);
    std::vector<bool> keep(triangles.size(), true);
    std::vector<bool> on_rim(At(vertex_count), false);
    std::vector<const MeshEdge*> rim;
    for (const MeshEdge& edge : topology.edges) {
      if (!edge.OnBoundary()) continue;
      on_rim[At(edge.from)] = on_rim[At(edge.to)] = true;
      rim.push_back(&edge);
    }
    const auto ratio = [&](const MeshEdge* edge) { return cap_ratio[At(edge->triangle[0])]; };
    std::ranges::stable_sort(rim, [&](auto* a, auto* b) { return ratio(a) > ratio(b); });
    for (const MeshEdge* edge : rim) {
      if (ratio(edge) <= wide_triangle) break;
      if (on_rim[At(edge->opposite[0])]) continue;
      keep[At(edge->triangle[0])] = false;
      on_rim[At(edge->opposite[0])] = true;
      peeled = true;
    }
    Keep(triangles, cap_ratio, keep);
  }
}

bool Folds(const ViewpointMesh& mesh, double subject_radius) {
  return std::ranges::any_of(mesh.triangles, [&](const Triangle& t) {
    const Vector3d& a = mesh.vertices[At(t[0])].position_in_world;
    const Vector3d& b = mesh.vertices[At(t[1])].position_in_world;
    const Vector3d& c = mesh.vertices[At(t[2])].position_in_world;
    const Vector3d normal = (b - a).cross(c - a).normalized();
    return normal.dot(a - mesh.center_in_world) <= subject_radius;
  });
}

void SmoothWhileFolding(ViewpointMesh& mesh, const TriangleTopology& topology, double subject_radius,
                        int most_rounds) {
  std::vector<double> distance(mesh.vertices.size());
  std::vector<Vector3d> direction(mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Vector3d arm = mesh.vertices[i].position_in_world - mesh.center_in_world;
    distance[i] = arm.norm();
    direction[i] = arm / distance[i];
  }
  mesh.folds_remain = Folds(mesh, subject_radius);
  while (mesh.folds_remain && mesh.smoothing_rounds < most_rounds) {
    std::vector<double> smoothed = distance;
    for (std::size_t i = 0; i < distance.size(); ++i) {
      const std::vector<int>& ring = topology.neighbours[i];
      if (ring.empty()) continue;
      double sum = 0;
      for (const int j : ring) sum += distance[At(j)];
      smoothed[i] = 0.75 * distance[i] + 0.25 * sum / static_cast<double>(ring.size());
    }
    distance = smoothed;
    for (std::size_t i = 0; i < distance.size(); ++i)
      mesh.vertices[i].position_in_world = mesh.center_in_world + distance[i] * direction[i];
    ++mesh.smoothing_rounds;
    mesh.folds_remain = Folds(mesh, subject_radius);
  }
}

// Outward tangents point away from the middle of the cap, so that the strips between them do not cross. Where
// that direction leads back over the mesh, the tangent is the boundary's normal.
void FindOutward(ViewpointMesh& mesh, const TriangleTopology& topology) {
  const Vector3d middle = Sum(Directions(mesh)).normalized();
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const auto [before, behind] = topology.boundary_neighbours[i];
    if (before < 0 || behind < 0) continue;
    ViewpointMesh::Vertex& vertex = mesh.vertices[i];
    const Vector3d radial = (vertex.position_in_world - mesh.center_in_world).normalized();
    const Vector3d along =
        mesh.vertices[At(behind)].position_in_world - mesh.vertices[At(before)].position_in_world;
    const Vector3d normal = along.cross(radial).normalized();
    Vector3d fan = radial.dot(middle) * radial - middle;
    fan = fan.norm() > 1e-6 ? Vector3d(fan.normalized()) : normal;
    vertex.outward_in_world =
        kOutwardOverDistance * mesh.median_distance * (fan.dot(normal) > kLeastOutwardCosine ? fan : normal);
    ++mesh.boundary_vertices;
  }
}

// Azimuth counts from the middle of the viewpoints, so that the seam lies opposite of them.
std::vector<Triangle> AzimuthElevationDelaunay(const std::vector<Vector3d>& directions, const Vector3d& up) {
  const Vector3d middle = Sum(directions);
  Vector3d front = middle - middle.dot(up) * up;
  if (front.norm() < 1e-6) front = up.unitOrthogonal();
  front.normalize();
  const Vector3d east = up.cross(front);
  std::vector<Eigen::Vector2d> points;
  for (const Vector3d& d : directions)
    points.emplace_back(std::atan2(d.dot(east), d.dot(front)), std::asin(std::clamp(d.dot(up), -1.0, 1.0)));
  std::vector<Triangle> triangles = PlanarDelaunay(points);
  std::erase_if(triangles, [&](const Triangle& t) {
    return directions[At(t[0])].dot(directions[At(t[1])].cross(directions[At(t[2])])) <=
           kLeastDirectionVolume;
  });
  return triangles;
}

// Makes the triangles, trimmed and manifold, and their confidence. A vertex where two parts of the mesh only
// touch is repeated.
void Triangulate(ViewpointMesh& mesh, const ViewpointMeshOptions& options) {
  const std::vector<Vector3d> directions = Directions(mesh);
  mesh.triangles = options.in_plane ? AzimuthElevationDelaunay(directions, options.up_in_world.normalized())
                                    : SphericalDelaunay(directions);
  const std::vector<double> spacing = SpacingOfTriangles(directions, mesh.triangles);
  std::vector<double> cap_ratio;
  std::vector<bool> keep;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const double cap = CapRadius(directions, mesh.triangles[t]);
    cap_ratio.push_back(cap / spacing[t]);
    keep.push_back(cap < kOpeningRad);
  }
  Keep(mesh.triangles, cap_ratio, keep);
  for (const int old : SplitPinches(static_cast<int>(mesh.vertices.size()), mesh.triangles))
    mesh.vertices.push_back(mesh.vertices[At(old)]);
  PeelRim(static_cast<int>(mesh.vertices.size()), kWideTriangle, mesh.triangles, cap_ratio);
  for (const double ratio : cap_ratio) mesh.confidence.push_back(std::min(1.0, kWideTriangle / ratio));
}

// Returns the number of groups that stand at least the widest opening apart.
int CountGroups(const ViewpointMesh& mesh) {
  const std::vector<Vector3d> directions = Directions(mesh);
  const double least_cosine = std::cos(kOpeningRad);
  std::vector<Vector3d> apart = directions;  // from all reached ones
  int groups = 0;
  while (!apart.empty()) {
    ++groups;
    std::vector<Vector3d> next{apart.back()};
    apart.pop_back();
    while (!next.empty()) {
      const Vector3d from = next.back();
      next.pop_back();
      const auto reached = std::partition(apart.begin(), apart.end(),
                                          [&](const Vector3d& to) { return from.dot(to) <= least_cosine; });
      next.insert(next.end(), reached, apart.end());
      apart.erase(reached, apart.end());
    }
  }
  return groups;
}

std::string GroupsText(const ViewpointMesh& mesh) {
  if (mesh.groups < 2) return {};
  return fmt::format(
      "; they stand in {} groups, {:.0f} deg or more apart: pictures from between them are a guess",
      mesh.groups, Degrees(kOpeningRad));
}

}  // namespace

int ViewpointMesh::ViewAt(int vertex, double distance, const std::vector<Vector3d>& centers_in_world) const {
  const std::vector<int>& candidates = vertices[At(vertex)].views;
  const auto off = [&](int view) {
    return std::abs((centers_in_world[At(view)] - center_in_world).norm() - distance);
  };
  return *std::ranges::min_element(candidates, [&](int a, int b) { return off(a) < off(b); });
}

bool ViewpointMesh::OnBoundary(int vertex) const { return !vertices[At(vertex)].outward_in_world.isZero(0); }

std::string ViewpointMesh::Description() const {
  if (vertices.empty()) return "no view stands off the subject's centre: the nearest view is shown";
  std::size_t views = 0;
  for (const Vertex& vertex : vertices) views += vertex.views.size();
  switch (span) {
    case Span::kPlace:
      return Counted(views, "view") + " in one place: the nearest view is shown";
    case Span::kLine:
      return Counted(views, "view") + " that span no surface (a row, a ring, or too few): lumigraph weights" +
             GroupsText(*this);
    default:
      return fmt::format("{}, {}, {} on the rim, {:.2f} deg apart{}{}", Counted(vertices.size(), "viewpoint"),
                         Counted(triangles.size(), "triangle"), boundary_vertices, Degrees(mean_edge_rad),
                         smoothing_rounds == 0
                             ? std::string()
                             : fmt::format(", {} of smoothing{}", Counted(smoothing_rounds, "round"),
                                           folds_remain ? " and still folding" : ""),
                         GroupsText(*this));
  }
}

bool InsideHull(const ViewpointMesh& mesh, const Vector3d& direction) {
  return std::ranges::any_of(mesh.triangles, [&](const Triangle& t) {
    std::array<Vector3d, 3> arm;
    for (std::size_t k = 0; k < 3; ++k)
      arm[k] = mesh.vertices[At(t[k])].position_in_world - mesh.center_in_world;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3d side = arm[k].cross(arm[(k + 1) % 3]);
      if (direction.dot(side) < -1e-12 * side.norm() * direction.norm()) return false;
    }
    return true;
  });
}

ViewpointMesh MakeViewpointMesh(const std::vector<Vector3d>& centers_in_world, const Subject& subject,
                                const ViewpointMeshOptions& options) {
  constexpr double kSamePlaceShare = 1e-6;  // of the median distance: rounding
  ViewpointMesh mesh;
  mesh.center_in_world = subject.center_in_world;

  std::vector<int> views;
  std::vector<Vector3d> directions;
  std::vector<double> distances;
  for (std::size_t i = 0; i < centers_in_world.size(); ++i) {
    const Vector3d arm = centers_in_world[i] - subject.center_in_world;
    if (IsAtCenter(subject, centers_in_world[i])) continue;
    views.push_back(static_cast<int>(i));
    directions.push_back(arm.normalized());
    distances.push_back(arm.norm());
  }
  if (views.empty()) return mesh;
  mesh.median_distance = Median(distances);
  double extent = 0;
  for (const int view : views)
    extent = std::max(extent, (centers_in_world[At(view)] - centers_in_world[At(views[0])]).norm());
  for (const auto& group : GroupDuplicates(views, directions, distances, mesh.median_distance))
    mesh.vertices.push_back({.position_in_world = centers_in_world[At(group.front())], .views = group});
  if (extent <= kSamePlaceShare * mesh.median_distance) return mesh;
  mesh.groups = CountGroups(mesh);

  mesh.span = Span::kLine;
  const std::size_t viewpoints = mesh.vertices.size();
  Triangulate(mesh, options);
  const TriangleTopology topology = MakeTopology(static_cast<int>(mesh.vertices.size()), mesh.triangles);
  std::size_t inside = 0;
  for (std::size_t i = 0; i < viewpoints; ++i)
    inside += !topology.neighbours[i].empty() && topology.boundary_neighbours[i][0] < 0;
  if (static_cast<double>(inside) < kLeastInteriorShare * static_cast<double>(viewpoints) || inside == 0)
    return mesh;

  mesh.span = Span::kSurface;
  SmoothWhileFolding(mesh, topology, subject.radius, kMostSmoothingRounds);
  FindOutward(mesh, topology);
  double sum = 0;
  for (const MeshEdge& edge : topology.edges)
    sum += AngleBetween(mesh.vertices[At(edge.from)].position_in_world - mesh.center_in_world,
                        mesh.vertices[At(edge.to)].position_in_world - mesh.center_in_world);
  mesh.mean_edge_rad = sum / static_cast<double>(topology.edges.size());
  return mesh;
}

}  // namespace ulf::render
