#include "tests/render/scenes/agreement.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "render/fields/aperture_field.h"
#include "render/fields/blending_field.h"
#include "render/fields/field_options.h"
#include "render/fields/lumigraph_field.h"
#include "render/fields/make_field.h"
#include "render/proxy/depth_raster.h"
#include "render/renderer/reference_renderer.h"
#include "tests/support/floors.h"

namespace ulf::test {

using Eigen::Vector3d;

namespace {

// Planes have none: inverse depth is linear over them. 0.02 of the larger inverse depth about a pixel.
bool DepthJumps(const cv::Mat& depth, int x, int y) {
  const auto inverse = [&](int px, int py) {
    return 1.0 / depth.at<float>(std::clamp(py, 0, depth.rows - 1), std::clamp(px, 0, depth.cols - 1));
  };
  const double here = inverse(x, y);
  for (const auto& [dx, dy] : {std::pair{1, 0}, {0, 1}, {1, 1}, {1, -1}}) {
    const double before = inverse(x - dx, y - dy), after = inverse(x + dx, y + dy);
    if (std::abs(before + after - 2 * here) > 0.02 * std::max({before, here, after})) return true;
  }
  return false;
}

// Rasterisers take corners to a 256th of a pixel. Which pixels a surface's rim covers, and with them what
// holes are filled from, hangs by that where the rim is seen from almost within the surface.
cv::Mat UncertainDepth(const RenderScene& scene, const CameraModel& camera, const Rigid3& cam_from_world) {
  cv::Mat uncertain = cv::Mat::zeros(camera.height, camera.width, CV_8U);
  const auto triangles = scene.proxy->Triangles(camera, cam_from_world);
  if (!triangles) return uncertain;
  const auto inverse_depth = [&](double shift_x, double shift_y) {
    CameraModel shifted = camera;
    shifted.cx += shift_x, shifted.cy += shift_y;
    cv::Mat inverse = DrawInverseDepth(*triangles, shifted, cam_from_world);
    FillHoles(inverse);
    return inverse;
  };
  const cv::Mat here = inverse_depth(0, 0);
  constexpr double kSnap = 1.0 / 256;
  for (const auto& [x, y] : {std::pair{-kSnap, 0.0}, {kSnap, 0.0}, {0.0, -kSnap}, {0.0, kSnap}})
    uncertain |= cv::abs(inverse_depth(x, y) - here) > 5e-4 * here;
  return uncertain;
}

cv::Mat BandOf(const RenderScene& scene, const PlacedField& field, const Filling& filling,
               const CameraModel& camera, const Rigid3& cam_from_world) {
  const Rigid3 world_from_cam = cam_from_world.Inverse();
  const Vector3d v = cam_from_world.OriginInSource();
  const auto order = ViewsByDistance(scene, v);
  const cv::Mat depth = scene.proxy->Depth(camera, cam_from_world);
  const auto point_at = [&](int x, int y) -> Vector3d {
    const Vector3d ray((x + 0.5 - camera.cx) / camera.fx, (y + 0.5 - camera.cy) / camera.fy, 1);
    return world_from_cam * (ray * depth.at<float>(y, x));
  };
  // How much of a view there is at a point, 0 where it does not see it or has no light there.
  const auto share = [&](int index, const Vector3d& point) -> double {
    const SceneView& view = scene.views[static_cast<std::size_t>(index)];
    const auto seen = view.ProjectVisible(point);
    if (!seen || !view.photograph->linear()) return seen ? seen->feather : 0;
    const int level = PyramidLevel(view, scene, v, camera.MeanFocalPx());
    return seen->feather * SampleLevel(view.photograph->Level(level), view.camera, seen->img)[3];
  };
  // Those that others' filling is made of: lumigraph weights of four have the fifth for their threshold.
  const std::size_t most = static_cast<std::size_t>(filling.views > 1 ? filling.views + 1 : filling.views);
  const auto fillers = [&](const Vector3d& point) {
    std::vector<int> views;
    for (const int i : order) {
      if (views.size() >= most) break;
      if (share(i, point) > 0) views.push_back(i);
    }
    return views;
  };
  // Asked for by a pixel and by its neighbours.
  std::vector<std::optional<std::vector<int>>> fillers_at(static_cast<std::size_t>(depth.total()));
  const auto fillers_of = [&](int x, int y) -> const std::vector<int>& {
    auto& known = fillers_at[static_cast<std::size_t>(y * camera.width + x)];
    if (!known) known = fillers(point_at(x, y));
    return *known;
  };
  // With a margin: the two renderers need not agree to the last bit on where it begins.
  const double whole = 1.05 * filling.whole;
  cv::Mat band = UncertainDepth(scene, camera, cam_from_world);
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      FieldSample sample;
      const Vector3d point = point_at(x, y);
      field.Weights({.ray_in_world = (point - v).normalized(), .point_in_world = point}, sample);
      bool changes = DepthJumps(depth, x, y);
      double own = 0;
      std::vector<bool> sees;
      for (const ViewWeight& entry : sample.weights) {
        const double of_view = share(entry.view, point);
        own += entry.weight * of_view;
        sees.push_back(of_view > 0);
      }
      const bool is_filled = own < whole;
      for (int dy = -1; dy <= 1 && !changes; ++dy)
        for (int dx = -1; dx <= 1 && !changes; ++dx) {
          const int nx = std::clamp(x + dx, 0, camera.width - 1),
                    ny = std::clamp(y + dy, 0, camera.height - 1);
          const Vector3d there = point_at(nx, ny);
          for (std::size_t i = 0; i < sees.size(); ++i)
            changes = changes || sees[i] != (share(sample.weights[i].view, there) > 0);
          if (is_filled && !changes) changes = fillers_of(nx, ny) != fillers_of(x, y);
        }
      if (changes) band.at<std::uint8_t>(y, x) = 255;
    }
  return band;
}

}  // namespace

cv::Mat VisibilityBand(const RenderScene& scene, const RenderOptions& options, const CameraModel& camera,
                       const Rigid3& cam_from_world) {
  const auto plain = std::shared_ptr<const RenderScene>(&scene, [](const RenderScene*) {});
  const Filling filling = FillingOf(options);
  if (!options.aperture)
    return BandOf(scene, *MakeField(plain, options.field)->From(cam_from_world.OriginInSource()), filling,
                  camera, cam_from_world);
  const auto focused = WithFocalPlane(scene, *options.aperture);
  if (!UsesMesh(options.field.kind))
    return BandOf(*focused, *MakeField(focused, options.field)->From(cam_from_world.OriginInSource()),
                  filling, camera, cam_from_world);
  const ApertureField wide(std::make_shared<MeshField>(plain, options.field.level));
  return BandOf(*focused, *wide.From(cam_from_world, *options.aperture), filling, camera, cam_from_world);
}

Agreement Compare(const Rendering& a, const Rendering& b, const cv::Mat& band) {
  cv::Mat difference;
  cv::absdiff(Srgb8FromLinear(a.linear), Srgb8FromLinear(b.linear), difference);
  Agreement agreement;
  agreement.band_share = static_cast<double>(cv::countNonZero(band)) / static_cast<double>(band.total());
  long outside = 0, within = 0, within_all = 0, as_sure = 0;
  double sum = 0;
  for (int y = 0; y < difference.rows; ++y)
    for (int x = 0; x < difference.cols; ++x) {
      const cv::Vec3b& d = difference.at<cv::Vec3b>(y, x);
      sum += (d[0] + d[1] + d[2]) / 3.0;
      const bool is_within = std::max({d[0], d[1], d[2]}) <= 2;
      within_all += is_within;
      if (band.at<std::uint8_t>(y, x)) continue;
      ++outside;
      within += is_within;
      as_sure += std::abs(a.confidence.at<float>(y, x) - b.confidence.at<float>(y, x)) <= 0.02 &&
                 a.drawn.at<std::uint8_t>(y, x) == b.drawn.at<std::uint8_t>(y, x);
    }
  agreement.within_share = static_cast<double>(within) / static_cast<double>(std::max(outside, 1L));
  agreement.confidence_share = static_cast<double>(as_sure) / static_cast<double>(std::max(outside, 1L));
  agreement.within_share_of_all = static_cast<double>(within_all) / static_cast<double>(difference.total());
  agreement.mean_abs = sum / static_cast<double>(difference.total());
  return agreement;
}

}  // namespace ulf::test
