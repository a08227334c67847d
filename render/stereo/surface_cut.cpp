#include "render/stereo/surface_cut.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc/detail/gcgraph.hpp>

#include "core/base/at.h"
#include "core/base/parallel_for.h"
#include "render/stereo/tetrahedra.h"

namespace ulf::render {
namespace {

constexpr int kSightLines = 6;  // largest number per point. Guessed.
constexpr double kSoftness =
    0.25;  // distance from a point, in its spreads, at which evidence is weaker. Guessed.
constexpr double kBehind = 1.0;  // distance behind a point, in its spreads, where space is filled. Guessed.
constexpr double kRegularity =
    0.1;  // weight against thin tetrahedra at the surface, in lines of sight. Guessed.
// Triangles with a longer edge (in pixels at its points) are left out: no view saw what lies between.
// Guessed.
constexpr double kLongestEdgePx = 60;
// Triangles with shorter edges are always kept. For those between, some view that saw a corner must stand in
// front. Guessed.
constexpr double kNeighboursPx = 10;

using Eigen::Vector3d;
using Cell = std::uint32_t;

constexpr int kSightLine = 1000;  // weight of a line of sight; sums of integers do not depend on their order

double Det(const Vector3d& a, const Vector3d& b, const Vector3d& c) { return a.dot(b.cross(c)); }

void Add(std::int32_t& sum, double weight) {
  std::atomic_ref<std::int32_t>(sum).fetch_add(static_cast<std::int32_t>(std::lround(weight)),
                                               std::memory_order_relaxed);
}

// The evidence of the lines of sight.
struct Evidence {
  explicit Evidence(std::size_t cells) : crossing(cells, {0, 0, 0, 0}), empty(cells, 0), filled(cells, 0) {}
  // Evidence against this cell being empty while its neighbour k is not.
  std::vector<std::array<std::int32_t, 4>> crossing;
  std::vector<std::int32_t> empty, filled;
};

// The cells at each point.
class CellsAtPoints {
 public:
  explicit CellsAtPoints(const Tetrahedra& space) : first_(space.points.size() + 1, 0) {
    for (const auto& corners : space.corners)
      for (const std::uint32_t corner : corners)
        if (corner != Tetrahedra::kAtInfinity) ++first_[corner + 1];
    for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
    cells_.resize(first_.back());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (Cell cell = 0; cell < space.corners.size(); ++cell)
      for (const std::uint32_t corner : space.corners[cell])
        if (corner != Tetrahedra::kAtInfinity) cells_[next[corner]++] = cell;
  }
  const Cell* begin(std::uint32_t point) const { return cells_.data() + first_[point]; }
  const Cell* end(std::uint32_t point) const { return cells_.data() + first_[point + 1]; }

 private:
  std::vector<std::uint32_t> first_;
  std::vector<Cell> cells_;
};

int IndexOf(const std::array<std::uint32_t, 4>& of, std::uint32_t value) {
  return static_cast<int>(std::ranges::find(of, value) - of.begin());
}

// Walks through the cells from a vertex along `way`. Calls crossed(cell, k, share) for every face k through
// which it leaves a cell, after `share` of the way. Returns the last cell: an outer one outside the hull.
class Walk {
 public:
  Walk(const Tetrahedra& space, const CellsAtPoints& cells_at) : space_(space), cells_at_(cells_at) {}

  template <typename Crossed>
  Cell To(std::uint32_t vertex, const Vector3d& way, const Crossed& crossed) const {
    const Vector3d origin = space_.points[vertex];
    Cell cell = Tetrahedra::kAtInfinity;
    std::array<std::uint32_t, 3> face{};
    int out = -1;
    Cell outside = Tetrahedra::kAtInfinity;
    for (const Cell* at = cells_at_.begin(vertex); at != cells_at_.end(vertex); ++at) {
      const auto& corners = space_.corners[*at];
      const int own = IndexOf(corners, vertex);
      std::array<std::uint32_t, 3> across = Across(*at, own);
      if (IndexOf(corners, Tetrahedra::kAtInfinity) < 4) {
        outside = *at;
        continue;
      }
      const Vector3d a = space_.points[across[0]] - origin, b = space_.points[across[1]] - origin,
                     c = space_.points[across[2]] - origin;
      // The way crosses the face if all edges run round it in the same direction.
      if (Det(way, a, b) >= 0 && Det(way, b, c) >= 0 && Det(way, c, a) >= 0) {
        cell = *at;
        face = across;
        out = own;
        break;
      }
    }
    if (cell == Tetrahedra::kAtInfinity) return outside;  // the way leaves the hull at once

    for (std::size_t steps = 0; steps < space_.corners.size(); ++steps) {
      const Vector3d u = space_.points[face[0]] - origin, v = space_.points[face[1]] - origin,
                     w = space_.points[face[2]] - origin;
      const double across = Det(way, u, v) + Det(way, v, w) + Det(way, w, u);
      if (!(across > 0)) return cell;  // the way lies in the face
      const double share = Det(u, v, w) / across;
      if (share >= 1) return cell;
      crossed(cell, out, share);
      const Cell next = space_.neighbours[cell][At(out)];
      const int apex = IndexOf(space_.neighbours[next], cell);
      const std::uint32_t far = space_.corners[next][At(apex)];
      if (far == Tetrahedra::kAtInfinity || space_.Outer(next)) return next;
      const Vector3d a = space_.points[far] - origin;
      const double side_u = Det(way, u, a), side_v = Det(way, v, a), side_w = Det(way, w, a);
      std::uint32_t left = 0;  // corner opposite the face through which the way leaves
      if (side_v >= 0 && side_u <= 0) {
        left = face[2], face[2] = far;
      } else if (side_w >= 0 && side_v <= 0) {
        left = face[0], face[0] = far;
      } else if (side_u >= 0 && side_w <= 0) {
        left = face[1], face[1] = far;
      } else {
        return next;
      }
      out = IndexOf(space_.corners[next], left);
      cell = next;
    }
    return cell;
  }

 private:
  // Returns the face opposite corner k, oriented so that Det(way, first, second) >= 0 for all its edges if
  // the way from the corner crosses it.
  std::array<std::uint32_t, 3> Across(Cell cell, int k) const {
    static constexpr std::array<std::array<std::size_t, 3>, 4> kFace{
        {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};
    const auto& corners = space_.corners[cell];
    const auto& face = kFace[At(k)];
    return {corners[face[0]], corners[face[1]], corners[face[2]]};
  }

  const Tetrahedra& space_;
  const CellsAtPoints& cells_at_;
};

void LookAlongSightLines(const std::vector<FusedPoint>& points, const std::vector<std::uint32_t>& vertex_of,
                         const std::vector<Vector3d>& centers, const Tetrahedra& space, bool in_this_thread,
                         Evidence& evidence) {
  const CellsAtPoints cells_at(space);
  const Walk walk(space, cells_at);
  const auto look = [&](const FusedPoint& point, std::uint32_t vertex, const Vector3d& center) {
    const Vector3d to_camera = center - space.points[vertex];
    const double length = to_camera.norm(), soft = kSoftness * point.spread;
    const auto weight_at = [&](double distance) {
      return kSightLine * (1 - std::exp(-distance * distance / (2 * soft * soft)));
    };
    const Cell at_camera = walk.To(vertex, to_camera, [&](Cell cell, int k, double share) {
      // The camera's side of the face is empty, so the cut counts from the next cell to this one.
      const Cell next = space.neighbours[cell][At(k)];
      Add(evidence.crossing[next][At(IndexOf(space.neighbours[next], cell))], weight_at(share * length));
    });
    if (at_camera != Tetrahedra::kAtInfinity) Add(evidence.empty[at_camera], kSightLine);
    const double behind = kBehind * point.spread;
    const Cell at_back = walk.To(vertex, to_camera * (-behind / length), [&](Cell cell, int k, double share) {
      Add(evidence.crossing[cell][At(k)], weight_at(share * behind));
    });
    if (at_back != Tetrahedra::kAtInfinity) Add(evidence.filled[at_back], kSightLine);
  };
  constexpr double kStripes = 64;
  ParallelFor(
      points.size(),
      [&](std::size_t i) {
        const auto& seen_by = points[i].seen_by;
        const std::size_t lines = std::min(seen_by.size(), At(kSightLines));
        for (std::size_t k = 0; k < lines; ++k)
          look(points[i], vertex_of[i], centers[seen_by[k * seen_by.size() / lines]]);
      },
      in_this_thread ? 1 : kStripes);
}

// Returns the centre of the sphere through a cell's corners; none for outer and flat cells.
std::optional<Vector3d> Circumcenter(const Tetrahedra& space, Cell cell) {
  if (space.Outer(cell)) return std::nullopt;
  const auto& corners = space.corners[cell];
  const Vector3d origin = space.points[corners[0]], a = space.points[corners[1]] - origin,
                 b = space.points[corners[2]] - origin, c = space.points[corners[3]] - origin;
  const double volume = 2 * Det(a, b, c);
  if (!(volume > 0)) return std::nullopt;
  return origin +
         (a.squaredNorm() * b.cross(c) + b.squaredNorm() * c.cross(a) + c.squaredNorm() * a.cross(b)) /
             volume;
}

// Returns 1 - the smaller cosine of the angles between a face and the spheres of its two cells: 0 for a face
// of the surface that the points suggest, 2 for a thin face across it.
double Irregularity(const Tetrahedra& space, Cell cell, int k,
                    const std::vector<std::optional<Vector3d>>& centers) {
  const auto& corners = space.corners[cell];
  std::array<Vector3d, 3> face;
  std::size_t count = 0;
  for (int i = 0; i < 4; ++i)
    if (i != k) face[count++] = space.points[corners[static_cast<std::size_t>(i)]];
  Vector3d normal = (face[1] - face[0]).cross(face[2] - face[0]).normalized();
  const Vector3d apex = space.points[corners[At(k)]];
  if (normal.dot(apex - face[0]) < 0) normal = -normal;  // towards this cell
  double least = 1;
  const Cell next = space.neighbours[cell][At(k)];
  for (const auto& [of, inward] : {std::pair{cell, 1.0}, {next, -1.0}}) {
    if (!centers[of]) continue;
    const Vector3d radius = *centers[of] - face[0];
    // The cosine of the angle between the face and the sphere's tangent plane at its rim.
    if (radius.norm() > 0) least = std::min(least, inward * normal.dot(radius) / radius.norm());
  }
  return 1 - least;
}

// Returns whether a face, counter-clockwise as seen from its empty side, may belong to the surface. Other
// faces close the surface over unseen parts.
bool Supported(const Tetrahedra& space, const std::array<std::uint32_t, 3>& face,
               const std::vector<FusedPoint>& points, const std::vector<std::uint32_t>& point_of,
               const std::vector<Vector3d>& centers) {
  double longest = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::uint32_t a = face[i], b = face[(i + 1) % 3];
    const double pixel = std::max(points[point_of[a]].pixel, points[point_of[b]].pixel);
    longest = std::max(longest, (space.points[a] - space.points[b]).norm() / pixel);
  }
  if (longest <= kNeighboursPx) return true;
  if (longest > kLongestEdgePx) return false;
  const Vector3d corner = space.points[face[0]];
  const Vector3d outward = (space.points[face[1]] - corner).cross(space.points[face[2]] - corner);
  return std::ranges::any_of(face, [&](std::uint32_t of) {
    const std::vector<std::uint16_t>& views = points[point_of[of]].seen_by;
    return std::ranges::any_of(views,
                               [&](std::uint16_t view) { return outward.dot(centers[view] - corner) > 0; });
  });
}

}  // namespace

TriangleMesh CutSurface(const std::vector<FusedPoint>& points, const std::vector<Vector3d>& centers_in_world,
                        bool in_this_thread) {
  std::vector<Vector3d> positions;
  for (const FusedPoint& point : points) positions.push_back(point.position_in_world);
  std::vector<std::uint32_t> vertex_of;
  const Tetrahedra space = DelaunayTetrahedra(positions, &vertex_of);
  const std::size_t cells = space.corners.size();
  TriangleMesh mesh;
  if (cells == 0) return mesh;

  Evidence evidence(cells);
  LookAlongSightLines(points, vertex_of, centers_in_world, space, in_this_thread, evidence);

  std::vector<std::optional<Vector3d>> spheres(cells);
  for (Cell cell = 0; cell < cells; ++cell) spheres[cell] = Circumcenter(space, cell);
  cv::detail::GCGraph<std::int32_t> graph(static_cast<unsigned>(cells), static_cast<unsigned>(4 * cells));
  for (Cell cell = 0; cell < cells; ++cell) {
    graph.addVtx();
    graph.addTermWeights(static_cast<int>(cell), evidence.empty[cell], evidence.filled[cell]);
  }
  for (Cell cell = 0; cell < cells; ++cell)
    for (int k = 0; k < 4; ++k) {
      const Cell next = space.neighbours[cell][At(k)];
      if (next <= cell) continue;
      const int back = IndexOf(space.neighbours[next], cell);
      double regular = 1;
      if (!space.Outer(cell))
        regular = Irregularity(space, cell, k, spheres);
      else if (!space.Outer(next))
        regular = Irregularity(space, next, back, spheres);
      const int both = static_cast<int>(std::lround(kSightLine * kRegularity * regular));
      graph.addEdges(static_cast<int>(cell), static_cast<int>(next), both + evidence.crossing[cell][At(k)],
                     both + evidence.crossing[next][At(back)]);
    }
  graph.maxFlow();

  std::vector<std::uint32_t> number(space.points.size(), Tetrahedra::kAtInfinity);
  std::vector<std::uint32_t> point_of(space.points.size(), 0);
  for (std::size_t i = points.size(); i-- > 0;) point_of[vertex_of[i]] = static_cast<std::uint32_t>(i);
  static constexpr std::array<std::array<std::size_t, 3>, 4> kFace{
      {{1, 3, 2}, {0, 2, 3}, {0, 3, 1}, {0, 1, 2}}};
  for (Cell cell = 0; cell < cells; ++cell) {
    if (graph.inSourceSegment(static_cast<int>(cell))) continue;
    for (std::size_t k = 0; k < 4; ++k) {
      if (!graph.inSourceSegment(static_cast<int>(space.neighbours[cell][k]))) continue;
      // The face is oriented as seen from the empty side, away from corner k.
      std::array<std::uint32_t, 3> face;
      bool finite = true;
      for (std::size_t i = 0; i < 3; ++i) {
        face[i] = space.corners[cell][kFace[k][2 - i]];
        finite = finite && face[i] != Tetrahedra::kAtInfinity;
      }
      if (!finite || !Supported(space, face, points, point_of, centers_in_world)) continue;
      for (std::uint32_t& corner : face) {
        if (number[corner] == Tetrahedra::kAtInfinity) {
          number[corner] = static_cast<std::uint32_t>(mesh.vertices.size());
          mesh.vertices.push_back(space.points[corner].cast<float>());
        }
        corner = number[corner];
      }
      mesh.triangles.push_back(face);
    }
  }
  return mesh;
}

}  // namespace ulf::render
