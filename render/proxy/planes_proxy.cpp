#include "render/proxy/planes_proxy.h"

#include <spdlog/spdlog.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <set>

#include "core/base/counted.h"
#include "core/base/error.h"

namespace ulf::render {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

// Coordinates in a plane along its points' principal axes.
struct PlaneAxes {
  Vector3d origin, x, y;

  Vector2d In(const Vector3d& point) const { return {x.dot(point - origin), y.dot(point - origin)}; }
  Vector3d Out(const Vector2d& in) const { return origin + in.x() * x + in.y() * y; }
};

PlaneAxes AxesOf(const FoundPlane& plane, const LightField& light_field) {
  Vector3d mean = Vector3d::Zero();
  const auto count = static_cast<double>(plane.points.size());
  for (const std::size_t i : plane.points) mean += light_field.points[i].position_in_world / count;
  const Vector3d any = plane.normal.unitOrthogonal(), other = plane.normal.cross(any);
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (const std::size_t i : plane.points) {
    const Vector3d from_mean = light_field.points[i].position_in_world - mean;
    const Vector2d in(any.dot(from_mean), other.dot(from_mean));
    spread += in * in.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(spread);
  const Vector2d along = solver.eigenvectors().col(1);
  const Vector3d x = along.x() * any + along.y() * other;
  return {mean - (plane.normal.dot(mean) - plane.offset) * plane.normal, x, plane.normal.cross(x)};
}

// Counts and marks by cell, with an empty rim for growth.
struct PlaneGrid {
  Vector2d corner;
  double cell;
  cv::Size size;

  cv::Point CellOf(const Vector2d& in) const {
    const Vector2d cells = ((in - corner) / cell).array().floor().max(-1).min(1e6);
    return {static_cast<int>(cells.x()), static_cast<int>(cells.y())};
  }
  bool Has(const cv::Point& at) const { return cv::Rect({0, 0}, size).contains(at); }
};

constexpr int kRim = 3;          // cells; more than anything grows
constexpr int kMostCells = 100;  // per side, so that a plane has few triangles. Guessed

PlaneGrid GridAround(const std::vector<Vector2d>& points) {
  Eigen::AlignedBox2d box;
  for (const Vector2d& point : points) box.extend(point);
  const double extent = box.sizes().maxCoeff();
  const double cell = std::max(SpacingOf(points, 400), extent / kMostCells);
  const Vector2d corner = box.min().array() - kRim * cell;
  const Vector2d cells = (box.sizes() / cell).array().ceil();
  return {
      corner, cell, {static_cast<int>(cells.x()) + 2 * kRim + 1, static_cast<int>(cells.y()) + 2 * kRim + 1}};
}

cv::Mat CountsIn(const PlaneGrid& grid, const std::vector<Vector2d>& points) {
  cv::Mat counts = cv::Mat::zeros(grid.size, CV_32S);
  for (const Vector2d& point : points) ++counts.at<int>(grid.CellOf(point));
  return counts;
}

cv::Mat SquareOf(int radius) {
  return cv::getStructuringElement(cv::MORPH_RECT, {2 * radius + 1, 2 * radius + 1});
}

// Counts the points behind the plane that were seen through each cell.
cv::Mat SeenThrough(const PlaneGrid& grid, const PlaneAxes& axes, const FoundPlane& plane,
                    const LightField& light_field, const std::vector<std::vector<Vector3d>>& seen_from) {
  constexpr double kClearlyBehind = 0.05;  // of the way from the viewpoint to the point. Guessed
  cv::Mat counts = cv::Mat::zeros(grid.size, CV_32S);
  for (std::size_t i = 0; i < seen_from.size(); ++i) {
    const Vector3d& point = light_field.points[i].position_in_world;
    std::set<std::pair<int, int>> cells;  // a point counts once in each
    for (const Vector3d& from : seen_from[i]) {
      const double before = plane.normal.dot(from) - plane.offset;
      const double behind = plane.offset - plane.normal.dot(point);
      if (before * behind <= 0) continue;  // on the viewpoint's side
      const double way = before / (before + behind);
      if (way > 1 - kClearlyBehind) continue;
      const cv::Point at = grid.CellOf(axes.In(from + way * (point - from)));
      if (grid.Has(at)) cells.insert({at.x, at.y});
    }
    for (const auto& [x, y] : cells) ++counts.at<int>(y, x);
  }
  return counts;
}

// Returns CV_8U: the cells inside the hulls of connected points; removes isolated points from `own`.
cv::Mat InsideHulls(const cv::Mat& counts, std::size_t points, cv::Mat& own) {
  // Guessed: largest number of empty cells between connected points, and size of an isolated group.
  constexpr int kGrow = 2;
  constexpr double kAlone = 0.02;
  constexpr int kFewest = 4;
  cv::Mat grown, labels, inside = cv::Mat::zeros(own.size(), CV_8U);
  cv::dilate(own, grown, SquareOf(kGrow));
  const int parts = cv::connectedComponents(grown, labels, 8, CV_32S);
  const double least = std::max<double>(kFewest, kAlone * static_cast<double>(points));
  for (int part = 1; part < parts; ++part) {
    const cv::Mat here = labels == part;
    cv::Mat counts_here = cv::Mat::zeros(counts.size(), CV_32S);
    counts.copyTo(counts_here, here);
    if (cv::sum(counts_here)[0] < least) {
      own.setTo(0, here);
      continue;
    }
    std::vector<cv::Point> cells, hull;
    cv::findNonZero(counts_here > 0, cells);
    cv::convexHull(cells, hull);
    cv::fillConvexPoly(inside, hull, 255);
  }
  return inside;
}

// A single point that was seen through a cell may be wrong.
constexpr int kChance = 1;

// Returns the sum over a cell and the eight around it.
cv::Mat Around(const cv::Mat& counts) {
  cv::Mat floats, sums;
  counts.convertTo(floats, CV_32F);
  cv::boxFilter(floats, sums, CV_32F, {3, 3}, {-1, -1}, false, cv::BORDER_CONSTANT);
  return sums;
}

void AddCells(const PlaneGrid& grid, const PlaneAxes& axes, const cv::Mat& kept, TriangleMesh& mesh) {
  cv::Mat corners(grid.size.height + 1, grid.size.width + 1, CV_32S, cv::Scalar(-1));
  const auto corner = [&](int x, int y) {
    int& index = corners.at<int>(y, x);
    if (index < 0) {
      index = static_cast<int>(mesh.vertices.size());
      mesh.vertices.push_back(axes.Out(grid.corner + grid.cell * Vector2d(x, y)).cast<float>());
    }
    return static_cast<std::uint32_t>(index);
  };
  for (int y = 0; y < grid.size.height; ++y)
    for (int x = 0; x < grid.size.width; ++x)
      if (kept.at<std::uint8_t>(y, x)) {
        const auto a = corner(x, y), b = corner(x + 1, y), c = corner(x + 1, y + 1), d = corner(x, y + 1);
        mesh.triangles.push_back({a, b, c});
        mesh.triangles.push_back({a, c, d});
      }
}

void AddPlane(const FoundPlane& plane, const LightField& light_field,
              const std::vector<std::vector<Vector3d>>& seen_from, TriangleMesh& mesh) {
  const PlaneAxes axes = AxesOf(plane, light_field);
  std::vector<Vector2d> points;
  for (const std::size_t i : plane.points) points.push_back(axes.In(light_field.points[i].position_in_world));
  const PlaneGrid grid = GridAround(points);
  if (!(grid.cell > 0)) return;  // all points coincide
  const cv::Mat counts = CountsIn(grid, points);
  cv::Mat own = counts > 0, beside;
  const cv::Mat inside = InsideHulls(counts, points.size(), own);
  cv::dilate(own, beside, SquareOf(1));
  const cv::Mat through = SeenThrough(grid, axes, plane, light_field, seen_from);
  AddCells(grid, axes, own | (beside & (through <= kChance)) | (inside & (Around(through) <= kChance)), mesh);
}

}  // namespace

std::shared_ptr<const TriangleMesh> MeshOfPlanes(const std::vector<FoundPlane>& planes,
                                                 const LightField& light_field) {
  const auto seen_from = ViewpointsOfPoints(light_field);
  auto mesh = std::make_shared<TriangleMesh>();
  for (const FoundPlane& plane : planes) AddPlane(plane, light_field, seen_from, *mesh);
  return mesh;
}

std::shared_ptr<const Proxy> MakePlanesProxy(const Subject& subject, const LightField& light_field) {
  const PlaneSearch search = FindPlanes(light_field);
  if (!search.why_none.empty())
    throw Error("{} {}: {}; use another proxy (plane, mesh)", Parameter("proxy"), kPlanesProxy,
                search.why_none);
  auto mesh = MeshOfPlanes(search.planes, light_field);
  spdlog::info("{}: {} of {}, on which {:.0f} % of {} lie", kPlanesProxy,
               Counted(search.planes.size(), "plane"), Counted(mesh->triangles.size(), "triangle"),
               100 * search.explained, Counted(search.points, "tracked point"));
  return std::make_shared<MeshProxy>(subject, std::move(mesh), kPlanesProxy);
}

}  // namespace ulf::render
