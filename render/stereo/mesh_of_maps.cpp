#include "render/stereo/mesh_of_maps.h"

#include <algorithm>

#include "core/base/host_time.h"
#include "core/base/parallel_for.h"
#include "render/proxy/depth_raster.h"
#include "render/stereo/surface_cut.h"
#include "render/stereo/view_selection.h"

namespace ulf::render {
namespace {

constexpr int kMapsCompared = 10;     // neighbours whose depth maps confirm a view's. Guessed.
constexpr int kWidestSpacingPx = 64;  // FusionOptions::spacing_px does not grow further

// Spaces the points wider until they are at most half as many as the surface may have triangles.
std::vector<FusedPoint> SpacedPoints(const std::vector<ViewDepth>& maps,
                                     const std::vector<std::vector<int>>& others, FusionOptions fusion,
                                     const MapsMeshOptions& options) {
  std::vector<FusedPoint> points = FusePoints(maps, others, fusion);
  while (points.size() > static_cast<std::size_t>(options.most_triangles) / 2 &&
         fusion.spacing_px < kWidestSpacingPx) {
    ++fusion.spacing_px;
    points = FusePoints(maps, others, fusion);
  }
  return points;
}

// Returns for each map the others that may confirm it, and how.
std::vector<std::vector<int>> MapsToCompare(const std::vector<ViewDepth>& maps, const Subject& subject) {
  std::vector<StereoView> mapped;
  for (const ViewDepth& map : maps) mapped.push_back(map.view);
  std::vector<std::vector<int>> others;
  for (std::size_t i = 0; i < mapped.size(); ++i)
    others.push_back(NeighboursOf(static_cast<int>(i), mapped, subject, kMapsCompared));
  return others;
}

FusionOptions FusionOf(std::size_t maps, const MapsMeshOptions& options) {
  FusionOptions fusion;
  fusion.in_this_thread = options.in_this_thread;
  fusion.agreeing_views = std::min(fusion.agreeing_views, std::max(1, static_cast<int>(maps) - 1));
  return fusion;
}

// For rendering, a depth that others confirm within two of its steps is right to a pixel. Stricter limits
// make better points of a mesh, but here the mesh replaces unconfirmed depths, which is no better. Settled on
// fern of LLFF.
constexpr double kConfirmedPlanes = 2;

}  // namespace

MapsMesh MeshOfMaps(std::vector<ViewDepth> maps, const Subject& subject, const MapsMeshOptions& options) {
  MapsMesh result;
  Stopwatch watch;
  std::vector<Eigen::Vector3d> centers;
  for (const ViewDepth& map : maps) centers.push_back(map.view.center_in_world);
  const std::vector<std::vector<int>> others = MapsToCompare(maps, subject);
  const FusionOptions fusion = FusionOf(maps.size(), options);
  KeepConsistentDepths(maps, others, fusion);
  double agreeing = 0, pixels = 0;
  for (const ViewDepth& map : maps) {
    agreeing += cv::countNonZero(map.depth);
    pixels += static_cast<double>(map.depth.total());
  }
  result.agreeing_share = pixels > 0 ? agreeing / pixels : 0;
  const std::vector<FusedPoint> points = SpacedPoints(maps, others, fusion, options);
  result.points = points.size();
  result.fusion_s = watch.LapSeconds();
  result.mesh = CutSurface(points, centers, options.in_this_thread);
  result.surface_s = watch.LapSeconds();
  return result;
}

std::map<int, ViewDepthMap> MapsForRendering(std::vector<ViewDepth> maps, const std::vector<int>& view_ids,
                                             const TriangleMesh& mesh, const Subject& subject,
                                             const MapsMeshOptions& options) {
  const std::vector<std::vector<int>> others = MapsToCompare(maps, subject);
  FusionOptions fusion = FusionOf(maps.size(), options);
  fusion.tolerance_planes = kConfirmedPlanes;
  KeepConsistentDepths(maps, others, fusion);
  std::vector<ViewDepthMap> made(maps.size());
  ParallelFor(maps.size(), [&](std::size_t i) {
    const ViewDepth& map = maps[i];
    cv::Mat inverse_depth = DrawInverseDepth(mesh, map.view.camera, map.view.cam_from_world);
    for (int y = 0; y < inverse_depth.rows; ++y)
      for (int x = 0; x < inverse_depth.cols; ++x)
        if (const float depth = map.depth.at<float>(y, x); depth > 0)
          inverse_depth.at<float>(y, x) = 1 / depth;
    FillHoles(inverse_depth);
    made[i] = MakeViewDepthMap(map.view.camera, inverse_depth, map.plane_step);
  });
  std::map<int, ViewDepthMap> of_views;
  for (std::size_t i = 0; i < made.size(); ++i) of_views.emplace(view_ids[i], std::move(made[i]));
  return of_views;
}

}  // namespace ulf::render
