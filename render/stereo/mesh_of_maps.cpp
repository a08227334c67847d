#include "render/stereo/mesh_of_maps.h"

#include <algorithm>

#include "core/base/stopwatch.h"
#include "render/stereo/surface_cut.h"
#include "render/stereo/view_selection.h"

namespace ulf::render {
namespace {

// Spaces the points wider until they are at most half as many as the surface may have triangles.
std::vector<FusedPoint> SpacedPoints(const std::vector<ViewDepth>& maps,
                                     const std::vector<std::vector<int>>& others, FusionOptions fusion,
                                     const MapsMeshOptions& options) {
  std::vector<FusedPoint> points = FusePoints(maps, others, fusion);
  while (points.size() > static_cast<std::size_t>(options.most_triangles) / 2 &&
         fusion.spacing_px < options.widest_spacing_px) {
    ++fusion.spacing_px;
    points = FusePoints(maps, others, fusion);
  }
  return points;
}

}  // namespace

std::vector<std::vector<int>> MapsToCompare(const std::vector<ViewDepth>& maps, const Subject& subject,
                                            const MapsMeshOptions& options) {
  std::vector<StereoView> mapped;
  for (const ViewDepth& map : maps) mapped.push_back(map.view);
  std::vector<std::vector<int>> others;
  for (std::size_t i = 0; i < mapped.size(); ++i)
    others.push_back(NeighboursOf(static_cast<int>(i), mapped, subject, {.count = options.maps_compared}));
  return others;
}

FusionOptions FusionOf(std::size_t maps, const MapsMeshOptions& options) {
  FusionOptions fusion;
  fusion.in_this_thread = options.in_this_thread;
  fusion.agreeing_views = std::min(fusion.agreeing_views, std::max(1, static_cast<int>(maps) - 1));
  return fusion;
}

MapsMesh MeshOfMaps(std::vector<ViewDepth> maps, const Subject& subject, const MapsMeshOptions& options) {
  MapsMesh result;
  Stopwatch watch;
  std::vector<Eigen::Vector3d> centers;
  for (const ViewDepth& map : maps) centers.push_back(map.view.center_in_world);
  const std::vector<std::vector<int>> others = MapsToCompare(maps, subject, options);
  const FusionOptions fusion = FusionOf(maps.size(), options);
  KeepWhatAgrees(maps, others, fusion);
  double agreeing = 0, pixels = 0;
  for (const ViewDepth& map : maps) {
    agreeing += cv::countNonZero(map.depth);
    pixels += static_cast<double>(map.depth.total());
  }
  result.agreeing_share = pixels > 0 ? agreeing / pixels : 0;
  const std::vector<FusedPoint> points = SpacedPoints(maps, others, fusion, options);
  result.points = points.size();
  result.fusion_s = watch.LapSeconds();
  result.mesh = CutSurface(points, centers, {.in_this_thread = options.in_this_thread});
  result.surface_s = watch.LapSeconds();
  return result;
}

}  // namespace ulf::render
