#include "render/splats/far_sphere.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_map>

#include "core/base/at.h"
#include "core/base/quantile.h"
#include "core/geometry/pinhole.h"
#include "render/splats/splat_shape.h"

namespace ulf::render {
namespace {

using Eigen::Vector3d;

constexpr double kFarQuantile = 0.995;  // of the Gaussians' distances from the middle of the views
constexpr double kBeyond = 1.1;         // the sphere's radius over this distance
constexpr float kFinestCell_px = 2;     // of the finest view
constexpr double kCoarser = 1.4;

struct FarSphere {
  Vector3d center;
  double radius;
};

FarSphere SphereAround(const std::vector<SplatView>& views, const Gaussians& gaussians) {
  FarSphere sphere{Vector3d::Zero(), 0};
  for (const SplatView& view : views)
    sphere.center += view.cam_from_world.OriginInSource() / static_cast<double>(views.size());
  for (const SplatView& view : views)
    sphere.radius =
        std::max(sphere.radius, 2 * (view.cam_from_world.OriginInSource() - sphere.center).norm());
  std::vector<double> distances;
  for (std::size_t i = 0; i < gaussians.size(); i += 16)
    distances.push_back((gaussians[i].position_in_world.cast<double>() - sphere.center).norm());
  if (!distances.empty())
    sphere.radius = std::max(sphere.radius, kBeyond * Quantile(std::move(distances), kFarQuantile));
  if (!(sphere.radius > 0)) sphere.radius = 1;  // one view that shows nothing
  return sphere;
}

// A cell of a cube's six faces, each of `across` x `across`.
struct CubeCell {
  int face = 0, column = 0, row = 0;
};

CubeCell CellOf(const Vector3d& direction, int across) {
  int axis = 0;
  direction.cwiseAbs().maxCoeff(&axis);
  const double length = direction[axis];
  const auto place = [&](int other) {
    const double at = 0.5 * (direction[(axis + other) % 3] / std::abs(length) + 1);
    return std::clamp(static_cast<int>(at * across), 0, across - 1);
  };
  return {2 * axis + (length < 0 ? 1 : 0), place(1), place(2)};
}

std::uint64_t NumberOf(const CubeCell& cell, int across) {
  const auto n = static_cast<std::uint64_t>(across);
  return (static_cast<std::uint64_t>(cell.face) * n + static_cast<std::uint64_t>(cell.row)) * n +
         static_cast<std::uint64_t>(cell.column);
}

// Returns the direction through a place of a face, 0 to `across`.
Vector3d DirectionAt(int face, double column, double row, int across) {
  Vector3d direction;
  const int axis = face / 2;
  direction[axis] = face % 2 == 1 ? -1 : 1;
  direction[(axis + 1) % 3] = 2 * column / across - 1;
  direction[(axis + 2) % 3] = 2 * row / across - 1;
  return direction.normalized();
}

struct MeanColor {
  cv::Vec3d sum = {0, 0, 0};
  double count = 0;
};
using FarCells = std::map<std::uint64_t, MeanColor>;  // by the cell's number, so that its order is fixed

// The colours that views show there, of pixels that have no Gaussian yet or of one in each `step` x `step`.
FarCells CellsOf(const std::vector<SplatView>& views, const FarSphere& sphere, int across, bool only_open,
                 int step = 1) {
  std::unordered_map<std::uint64_t, MeanColor> found;
  for (const SplatView& view : views) {
    const Vector3d from = view.cam_from_world.OriginInSource() - sphere.center;
    for (int y = 0; y < view.done.rows; y += step)
      for (int x = 0; x < view.done.cols; x += step) {
        if ((only_open && view.done.at<std::uint8_t>(y, x) != 0) || view.IsGap(x, y)) continue;
        const Vector3d ray =
            view.cam_from_world.DirectionInSource(PinholeRay(view.camera, x, y)).normalized();
        const double along = from.dot(ray);
        const double length =
            -along + std::sqrt(along * along + sphere.radius * sphere.radius - from.squaredNorm());
        const CubeCell cell = CellOf(from + length * ray, across);
        MeanColor& mean = found[NumberOf(cell, across)];
        mean.sum += cv::Vec3d(view.means[0].at<cv::Vec3b>(y, x));
        ++mean.count;
      }
  }
  return {found.begin(), found.end()};
}

Gaussian GaussianOf(std::uint64_t number, const MeanColor& mean, const FarSphere& sphere, int across) {
  const auto n = static_cast<std::uint64_t>(across);
  const int face = static_cast<int>(number / (n * n)), row = static_cast<int>(number / n % n),
            column = static_cast<int>(number % n);
  const auto at = [&](double x, double y) -> Vector3d {
    return sphere.center + sphere.radius * DirectionAt(face, column + x, row + y, across);
  };
  const Vector3d middle = at(0.5, 0.5);
  SurfaceCell cell{middle.cast<float>(),
                   (at(1, 0.5) - at(0, 0.5)).cast<float>(),
                   (at(0.5, 1) - at(0.5, 0)).cast<float>(),
                   (sphere.center - middle).normalized().cast<float>(),
                   kFinestCell_px,
                   {}};
  for (int c = 0; c < 3; ++c) cell.bgr[c] = cv::saturate_cast<std::uint8_t>(mean.sum[c] / mean.count);
  return FlatGaussian(kGroundForm, cell);
}

// Adds the cells beside these, with the mean of their colours.
void Grow(FarCells& cells, int across) {
  const auto n = static_cast<std::uint64_t>(across);
  FarCells grown;
  for (const auto& [number, mean] : cells) {
    const int face = static_cast<int>(number / (n * n)), row = static_cast<int>(number / n % n),
              column = static_cast<int>(number % n);
    for (const auto& [x, y] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
      // Beyond a face's edge the direction falls on the face beside it.
      const std::uint64_t beside =
          NumberOf(CellOf(DirectionAt(face, column + x + 0.5, row + y + 0.5, across), across), across);
      if (cells.contains(beside)) continue;
      grown[beside].sum += mean.sum / mean.count;
      ++grown[beside].count;
    }
  }
  cells.merge(grown);
}

}  // namespace

std::size_t AddFarSphere(const std::vector<SplatView>& views, std::size_t most, Gaussians& gaussians) {
  const FarSphere sphere = SphereAround(views, gaussians);
  double finest = 0;
  for (const SplatView& view : views) finest = std::max(finest, view.camera.MeanFocalPx());
  const std::size_t room = most - std::min(most, gaussians.size());
  double cell_px = static_cast<double>(kFinestCell_px);
  FarCells cells;
  int across = 1;
  do {
    across = std::max(1, static_cast<int>(2 * finest / cell_px));
    cells = CellsOf(views, sphere, across, true);
    cell_px *= kCoarser;
  } while (cells.size() > room && across > 1);
  if (cells.size() > room) return 0;
  for (const auto& [number, mean] : cells) gaussians.push_back(GaussianOf(number, mean, sphere, across));
  return cells.size();
}

std::size_t AddBackdrop(const std::vector<SplatView>& views, std::size_t most, Gaussians& gaussians) {
  constexpr int kAcross = 40, kGrown = 8, kStep = 8;  // cells of 2 degrees; 18 degrees beyond what is shown
  FarSphere sphere = SphereAround(views, gaussians);
  sphere.radius *= kBeyond;
  // Pixels that show something nearer tell a colour only where no view sees past it.
  FarCells cells = CellsOf(views, sphere, kAcross, true, kStep);
  cells.merge(CellsOf(views, sphere, kAcross, false, kStep));
  for (int i = 0; i < kGrown; ++i) Grow(cells, kAcross);
  if (gaussians.size() + cells.size() > most) return 0;
  for (const auto& [number, mean] : cells) gaussians.push_back(GaussianOf(number, mean, sphere, kAcross));
  return cells.size();
}

}  // namespace ulf::render
