#include "render/proxy/mesh_world.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <random>
#include <unordered_map>
#include <vector>

#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/parallel_for.h"
#include "core/base/quantile.h"
#include "render/proxy/depth_raster.h"
#include "render/proxy/mesh_resolution.h"
#include "render/proxy/shadow_map.h"
#include "render/proxy/visible_points.h"

namespace ulf::render {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector3i;

constexpr int kMostViewsAsked = 8;
constexpr std::size_t kMostPointsOfAView = 250;
constexpr std::size_t kMostTriangles = 200000;         // of the mesh that is tried
constexpr double kOnMesh = 0.02, kAboutOnMesh = 0.06;  // of the depth
// A mesh fits if half of the points that it covers lie on it; it does not if fewer than a fifth lie about on
// it.
constexpr double kFitsShare = 0.5, kMisfitShare = 0.2;
constexpr int kFewestCovered = 30;       // fewer points do not tell that a mesh fits
constexpr double kHardlyCovered = 0.1;   // of the points: fewer do not tell that it does not
constexpr double kOtherFitsShare = 0.4;  // of the points that a moved mesh covers
constexpr double kOtherFitsAbout = 1.2;  // and as many as lie about on a rough mesh that fits
constexpr double kOtherFitsTimes = 2;    // as many points on the moved mesh as on the given one, at least
constexpr std::size_t kSurfaceSamples = 30000, kVotingSamples = 400, kVotingPoints = 100, kTriedPoints = 300;
constexpr std::size_t kVerified = 6;  // of the best moves of either kind
// Our unit of length in that of another program: millimetres, centimetres, inches, feet and their reverses.
constexpr std::array kUnitScales{1.0,  0.001,  1000.0,     0.01,   100.0,     0.1,
                                 10.0, 0.0254, 1 / 0.0254, 0.3048, 1 / 0.3048};

// Points that a view sees.
struct PointsOfView {
  CameraModel camera;  // without distortion, for a small depth map
  Rigid3 cam_from_world;
  std::vector<Vector3d> in_world;
};

std::vector<PointsOfView> PointsSeenByViews(const LightField& light_field) {
  std::vector<PointsOfView> views;
  const std::size_t count = light_field.views.size();
  const std::size_t asked = std::min<std::size_t>(kMostViewsAsked, count);
  for (std::size_t k = 0; k < asked; ++k) {
    const View& view = light_field.views[k * count / asked];
    PointsOfView& seen = views.emplace_back(
        PointsOfView{ShadowMapCamera(light_field.CameraOf(view)), view.cam_from_world, {}});
    std::vector<Vector3d> untracked;
    for (const ScenePoint& point : light_field.points) {
      const bool is_seen = std::ranges::any_of(
          point.track, [&](const ViewObservation& observation) { return observation.view_id == view.id; });
      const Vector3d in_cam = view.cam_from_world * point.position_in_world;
      const auto img = light_field.CameraOf(view).ImgFromCam(in_cam);
      if (!(in_cam.z() > 0) || !img || !light_field.CameraOf(view).Contains(*img)) continue;
      if (is_seen)
        seen.in_world.push_back(point.position_in_world);
      else if (point.track.empty())
        untracked.push_back(in_cam);
    }
    constexpr std::size_t kMostForHull = 20000;
    std::vector<Vector3d> chosen;
    for (std::size_t i = 0; i < std::min(kMostForHull, untracked.size()); ++i)
      chosen.push_back(untracked[i * untracked.size() / std::min(kMostForHull, untracked.size())]);
    constexpr double kSteradians = 0.6;  // of a usual lens
    for (const std::size_t i : VisiblePoints(chosen, kSteradians))
      seen.in_world.push_back(view.cam_from_world.Inverse() * chosen[i]);
    std::mt19937 random(static_cast<unsigned>(k) + 1);
    std::ranges::shuffle(seen.in_world, random);
    if (seen.in_world.size() > kMostPointsOfAView) seen.in_world.resize(kMostPointsOfAView);
  }
  return views;
}

// Counts the points that views see through a mesh.
struct PointsOnMesh {
  int seen = 0, covered = 0;  // all, and those in whose direction the mesh is
  int on = 0, about_on = 0;   // of these: within kOnMesh and within kAboutOnMesh
  int views_with_mesh = 0;    // that have the mesh about as far away as points
};

PointsOnMesh CountOnMesh(const TriangleMesh& mesh, const std::vector<PointsOfView>& views) {
  PointsOnMesh counts;
  for (const PointsOfView& view : views) {
    const cv::Mat inverse = DrawInverseDepth(mesh, view.camera, view.cam_from_world);
    std::vector<double> depths;
    for (const Vector3d& point : view.in_world) {
      const Vector3d in_cam = view.cam_from_world * point;
      const auto img = view.camera.ImgFromCam(in_cam);
      if (!img || !view.camera.Contains(*img)) continue;
      ++counts.seen;
      depths.push_back(in_cam.z());
      double nearest = std::numeric_limits<double>::infinity();
      const int column = static_cast<int>(img->x()), row = static_cast<int>(img->y());
      for (int y = std::max(0, row - 1); y <= std::min(inverse.rows - 1, row + 1); ++y)
        for (int x = std::max(0, column - 1); x <= std::min(inverse.cols - 1, column + 1); ++x)
          if (const float at = inverse.at<float>(y, x); at > 0)
            nearest = std::min(nearest, std::abs(in_cam.z() * at - 1));
      if (!std::isfinite(nearest)) continue;
      ++counts.covered;
      counts.on += nearest < kOnMesh;
      counts.about_on += nearest < kAboutOnMesh;
    }
    if (depths.empty()) continue;
    const double near = 0.3 * Quantile(depths, 0.05), far = 3 * Quantile(depths, 0.95);
    const cv::Mat there = (inverse > 1 / far) & (inverse < 1 / near);
    constexpr int kFewestPixels = 30;
    counts.views_with_mesh += cv::countNonZero(there) >= kFewestPixels;
  }
  return counts;
}

// A mesh's point p lies in the world at scale * axes * p + shift.
struct MeshMove {
  Matrix3d axes = Matrix3d::Identity();
  double scale = 1;
  Vector3d shift = Vector3d::Zero();
  std::size_t near = 0;  // points near the surface

  Vector3d InWorld(const Vector3d& in_mesh) const { return scale * (axes * in_mesh) + shift; }
  Vector3d InMesh(const Vector3d& in_world) const { return axes.transpose() * (in_world - shift) / scale; }
};

// All signed permutations of the axes: the unchanged first, then the turns, then the mirrored ones.
std::vector<Matrix3d> AxisTurns() {
  std::vector<Matrix3d> turns;
  std::array<int, 3> order{0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      Matrix3d axes = Matrix3d::Zero();
      for (int row = 0; row < 3; ++row)
        axes(row, order[static_cast<std::size_t>(row)]) = (signs >> row & 1) != 0 ? -1 : 1;
      turns.push_back(axes);
    }
  } while (std::ranges::next_permutation(order).found);
  std::ranges::stable_sort(turns, std::greater<>(), [](const Matrix3d& axes) { return axes.determinant(); });
  return turns;
}

std::vector<Vector3d> SurfaceSamples(const TriangleMesh& mesh, std::size_t count) {
  std::vector<double> up_to;
  double area = 0;
  const auto corner = [&](std::size_t triangle, std::size_t k) {
    return Vector3d(mesh.vertices[mesh.triangles[triangle][k]].cast<double>());
  };
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    up_to.push_back(area += (corner(i, 1) - corner(i, 0)).cross(corner(i, 2) - corner(i, 0)).norm());
  std::mt19937 random(1);
  std::uniform_real_distribution<double> any(0, 1);
  std::vector<Vector3d> samples;
  for (std::size_t k = 0; k < count; ++k) {
    const auto drawn = std::ranges::lower_bound(up_to, area * any(random)) - up_to.begin();
    const std::size_t i = std::min(static_cast<std::size_t>(drawn), up_to.size() - 1);
    double a = any(random), b = any(random);
    if (a + b > 1) {
      a = 1 - a;
      b = 1 - b;
    }
    samples.push_back(corner(i, 0) + a * (corner(i, 1) - corner(i, 0)) + b * (corner(i, 2) - corner(i, 0)));
  }
  return samples;
}

// Points by the cells of a grid.
class CellMap {
 public:
  explicit CellMap(double cell) : cell_(cell) {}
  // Returns none beyond a million cells from the origin.
  std::optional<std::uint64_t> KeyOf(const Vector3d& point, const Vector3i& beside = Vector3i::Zero()) const {
    constexpr double kMost = 1 << 20;
    const Vector3d at = (point / cell_).array().floor();
    if (!(at.cwiseAbs().maxCoeff() < kMost - 2)) return std::nullopt;
    std::uint64_t key = 0;
    for (int i = 0; i < 3; ++i)
      key = key << 21 | static_cast<std::uint64_t>(static_cast<std::int64_t>(at(i)) + beside(i) + (1 << 20));
    return key;
  }
  void Add(const Vector3d& point) {
    const auto key = KeyOf(point);
    if (!key) return;
    Cell& cell = cells_[*key];
    cell.sum += point;
    ++cell.count;
  }
  bool HasNear(const Vector3d& point) const {
    Vector3i beside;
    for (beside.x() = -1; beside.x() <= 1; ++beside.x())
      for (beside.y() = -1; beside.y() <= 1; ++beside.y())
        for (beside.z() = -1; beside.z() <= 1; ++beside.z())
          if (const auto key = KeyOf(point, beside); key && cells_.contains(*key)) return true;
    return false;
  }
  // Returns the nearest mean of a cell among the point's own and those around it.
  std::optional<Vector3d> Near(const Vector3d& point) const {
    std::optional<Vector3d> nearest;
    Vector3i beside;
    for (beside.x() = -1; beside.x() <= 1; ++beside.x())
      for (beside.y() = -1; beside.y() <= 1; ++beside.y())
        for (beside.z() = -1; beside.z() <= 1; ++beside.z()) {
          const auto key = KeyOf(point, beside);
          const auto found = key ? cells_.find(*key) : cells_.end();
          if (found == cells_.end()) continue;
          const Vector3d mean = found->second.sum / found->second.count;
          if (!nearest || (mean - point).squaredNorm() < (*nearest - point).squaredNorm()) nearest = mean;
        }
    return nearest;
  }
  // Returns the middle of the fullest cell; none of an empty map.
  std::optional<Vector3d> Fullest() const {
    const Cell* most = nullptr;
    for (const auto& [key, cell] : cells_)
      if (!most || cell.count > most->count ||
          (cell.count == most->count && (cell.sum / cell.count).norm() < (most->sum / most->count).norm()))
        most = &cell;
    if (!most) return std::nullopt;
    return Vector3d(most->sum / most->count);
  }

 private:
  struct Cell {
    Vector3d sum = Vector3d::Zero();
    double count = 0;
  };
  double cell_;
  std::unordered_map<std::uint64_t, Cell> cells_;
};

double SpreadOfPoints(const std::vector<Vector3d>& points) {
  std::array<std::vector<double>, 3> of;
  for (const Vector3d& point : points)
    for (int i = 0; i < 3; ++i) of[static_cast<std::size_t>(i)].push_back(point(i));
  double sum = 0;
  for (const auto& values : of) sum += std::pow(Quantile(values, 0.9) - Quantile(values, 0.1), 2);
  return std::sqrt(sum);
}

// Finds moves of a mesh by which its surface holds most points.
class MoveSearch {
 public:
  MoveSearch(const TriangleMesh& mesh, const std::vector<PointsOfView>& views)
      : samples_(SurfaceSamples(mesh, kSurfaceSamples)) {
    std::vector<double> depths;
    for (const PointsOfView& view : views)
      for (const Vector3d& point : view.in_world) {
        points_.push_back(point);
        depths.push_back((view.cam_from_world * point).z());
      }
    std::mt19937 random(1);
    std::ranges::shuffle(points_, random);
    if (points_.size() > kTriedPoints) points_.resize(kTriedPoints);
    tolerance_ = kOnMesh * Quantile(depths, 0.25);
  }

  // Returns moves without a shift, then with one, the best of each kind first.
  std::vector<MeshMove> Run() const {
    const std::vector<Matrix3d> turns = AxisTurns();
    const double points_spread = SpreadOfPoints(points_), mesh_spread = SpreadOfPoints(samples_);
    std::vector<MeshMove> plain, shifted;
    for (const double scale : kUnitScales) {
      CellMap surface(tolerance_ / scale);
      for (const Vector3d& sample : samples_) surface.Add(sample);
      constexpr double kMostTimes = 8;  // as large as the points' spread, or as small
      const double times = scale * mesh_spread / points_spread;
      std::vector<MeshMove> of_turns(2 * turns.size());
      ParallelFor(turns.size(), [&](std::size_t t) {
        MeshMove move{turns[t], scale, Vector3d::Zero(), 0};
        move.near = CountNear(surface, move);
        of_turns[2 * t] = move;
        if (times > kMostTimes || times < 1 / kMostTimes) return;
        if (const auto shift = VotedShift(move)) of_turns[2 * t + 1] = Settled(surface, move, *shift);
      });
      for (std::size_t i = 0; i < of_turns.size(); ++i) (i % 2 == 0 ? plain : shifted).push_back(of_turns[i]);
    }
    std::vector<MeshMove> best;
    for (std::vector<MeshMove>* moves : {&plain, &shifted}) {
      std::ranges::stable_sort(*moves, std::greater<>(), &MeshMove::near);
      best.insert(best.end(), moves->begin(),
                  moves->begin() + static_cast<std::ptrdiff_t>(std::min(kVerified, moves->size())));
    }
    return best;
  }

 private:
  std::size_t CountNear(const CellMap& surface, const MeshMove& move) const {
    return static_cast<std::size_t>(std::ranges::count_if(
        points_, [&](const Vector3d& point) { return surface.HasNear(move.InMesh(point)); }));
  }

  // Returns the shift on which most pairs of a point and a place of the surface agree.
  std::optional<Vector3d> VotedShift(const MeshMove& move) const {
    CellMap votes(2 * tolerance_);
    const std::size_t step = std::max<std::size_t>(1, samples_.size() / kVotingSamples);
    for (std::size_t p = 0; p < std::min(kVotingPoints, points_.size()); ++p)
      for (std::size_t s = 0; s < samples_.size(); s += step)
        votes.Add(points_[p] - move.InWorld(samples_[s]));
    return votes.Fullest();
  }

  // Moves the surface to the points that are near it, again and again.
  MeshMove Settled(const CellMap& surface, MeshMove move, const Vector3d& shift) const {
    constexpr int kRounds = 12;
    move.shift = shift;
    for (int round = 0; round < kRounds; ++round) {
      std::array<std::vector<double>, 3> apart;
      for (const Vector3d& point : points_)
        if (const auto near = surface.Near(move.InMesh(point)))
          for (int i = 0; i < 3; ++i)
            apart[static_cast<std::size_t>(i)].push_back((point - move.InWorld(*near))(i));
      for (int i = 0; i < 3; ++i) move.shift(i) += Median(apart[static_cast<std::size_t>(i)]);
    }
    move.near = CountNear(surface, move);
    return move;
  }

  std::vector<Vector3d> samples_;  // of the surface, in the mesh's frame
  std::vector<Vector3d> points_;   // in the world
  double tolerance_ = 0;           // world units
};

TriangleMesh MovedMesh(TriangleMesh mesh, const MeshMove& move) {
  for (Eigen::Vector3f& vertex : mesh.vertices) vertex = move.InWorld(vertex.cast<double>()).cast<float>();
  return mesh;
}

// Returns what to do with the mesh: "x, -z, y in place of x, y, z and lengths times 0.001".
std::string MoveInWords(const MeshMove& move) {
  std::vector<std::string> words;
  if (!move.axes.isIdentity()) {
    std::string axes;
    for (int row = 0; row < 3; ++row) {
      int column = 0;
      move.axes.row(row).cwiseAbs().maxCoeff(&column);
      axes +=
          fmt::format("{}{}{}", row > 0 ? ", " : "", move.axes(row, column) < 0 ? "-" : "", "xyz"[column]);
    }
    words.push_back(fmt::format("{} in place of x, y, z{}", axes,
                                move.axes.determinant() < 0 ? " (it is mirrored)" : ""));
  }
  if (move.scale != 1) words.push_back(fmt::format("lengths times {:.4g}", move.scale));
  if (move.shift.norm() > 0)
    words.push_back(
        fmt::format("moved by {:.4g}, {:.4g}, {:.4g}", move.shift.x(), move.shift.y(), move.shift.z()));
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i)
    text += (i == 0 ? "" : i + 1 == words.size() ? " and " : ", ") + words[i];
  return text;
}

// Returns the simplest move by which the mesh fits much better than as it is; none if there is none.
std::optional<MeshMove> FittingMove(const TriangleMesh& mesh, const std::vector<PointsOfView>& views,
                                    const PointsOnMesh& given) {
  for (const MeshMove& move : MoveSearch(mesh, views).Run()) {
    const PointsOnMesh moved = CountOnMesh(MovedMesh(mesh, move), views);
    spdlog::debug("{}: {} near, {} of {} on the mesh", MoveInWords(move), move.near, moved.on, moved.covered);
    if (moved.on >= kFewestCovered && moved.on >= kOtherFitsShare * moved.covered &&
        moved.on >= kOtherFitsTimes * given.on && moved.on >= kOtherFitsAbout * given.about_on)
      return move;
  }
  return std::nullopt;
}

}  // namespace

void RequireMeshOfWorld(const std::string& name, const TriangleMesh& mesh, const LightField& light_field) {
  const auto warn = [&](int seen, const std::string& why) {
    spdlog::warn("{}: of {} that views see, {}: whether it is in the world of {} cannot be told", name,
                 Counted(static_cast<std::size_t>(seen), "point"), why, light_field.root.string());
  };
  const std::vector<PointsOfView> views = PointsSeenByViews(light_field);
  const PointsOnMesh given = CountOnMesh(mesh, views);
  spdlog::debug("{}: of {} points {} are covered, {} on it, {} about on it, {} views have it", name,
                given.seen, given.covered, given.on, given.about_on, given.views_with_mesh);
  if (given.seen < static_cast<int>(kFewestPointsForMesh))
    return warn(given.seen, fmt::format("which are too few (fewer than {})", kFewestPointsForMesh));
  if (given.covered >= kFewestCovered && given.on >= kFitsShare * given.covered) return;
  const std::string misfit =
      fmt::format("{}: is in another world than {}: of {} that views see, {} on it", name,
                  light_field.root.string(), Counted(static_cast<std::size_t>(given.seen), "point"),
                  given.on == 0   ? std::string("none lies")
                  : given.on == 1 ? std::string("1 lies")
                                  : fmt::format("{} lie", given.on));
  if (const auto move = FittingMove(Simplified(mesh, kMostTriangles), views, given))
    throw Error("{}; it would fit with {}: write it so from the program that made it", misfit,
                MoveInWords(*move));
  const bool hardly_covered = given.covered < kFewestCovered || given.covered < kHardlyCovered * given.seen;
  if (hardly_covered ? given.views_with_mesh == 0 : given.about_on < kMisfitShare * given.covered)
    throw Error(
        "{}, and no exchange of its axes, usual unit of length or shift makes it fit: is it a mesh of this "
        "scene, under these poses?",
        misfit);
  if (hardly_covered)
    warn(given.seen, given.covered == 1 ? std::string("1 lies in its direction")
                                        : fmt::format("{} lie in its direction", given.covered));
}

}  // namespace ulf::render
