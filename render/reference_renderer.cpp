#include "render/reference_renderer.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

#include "render/lumigraph_field.h"

namespace ulf {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

const std::array<float, 256>& LinearTable() {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> values{};
    for (std::size_t i = 0; i < 256; ++i) values[i] = LinearFromSrgb(static_cast<float>(i) / 255.0f);
    return values;
  }();
  return table;
}

cv::Vec3f LinearAt(const cv::Mat& pixels, int x, int y) {
  const auto& table = LinearTable();
  const cv::Vec3b& p =
      pixels.at<cv::Vec3b>(std::clamp(y, 0, pixels.rows - 1), std::clamp(x, 0, pixels.cols - 1));
  return {table[p[0]], table[p[1]], table[p[2]]};
}

// Everything about one frame that does not change from pixel to pixel.
struct FrameSetup {
  const RenderScene& scene;
  const CameraModel& camera;
  Rigid3 world_from_cam;
  Vector3d virtual_center;
  bool show_field;
  std::vector<int> level;  // of each view
  std::vector<int> views_by_distance;
};

cv::Vec3f LightOf(const FrameSetup& setup, int index, const Vector2d& img) {
  if (setup.show_field) return ViewColor(setup.scene.views[static_cast<std::size_t>(index)].id);
  const SceneView& view = setup.scene.views[static_cast<std::size_t>(index)];
  const cv::Vec3f light = SampleView(view, setup.level[static_cast<std::size_t>(index)], img);
  return (light - cv::Vec3f::all(view.black)) * view.scale;
}

struct Shade {
  cv::Vec3f light{0, 0, 0};
  double weight = 0;
};

Shade BlendViews(const FrameSetup& setup, const FieldSample& sample, const Vector3d& point) {
  Shade shade;
  for (const auto& [index, weight] : sample.weights) {
    const auto seen = setup.scene.views[static_cast<std::size_t>(index)].See(point);
    if (!seen) continue;
    const double feathered = weight * seen->feather;
    shade.light += static_cast<float>(feathered) * LightOf(setup, index, seen->img);
    shade.weight += feathered;
  }
  return shade;
}

std::optional<cv::Vec3f> NearestLight(const FrameSetup& setup, const Vector3d& point) {
  for (const int index : setup.views_by_distance)
    if (const auto seen = setup.scene.views[static_cast<std::size_t>(index)].See(point))
      return LightOf(setup, index, seen->img);
  return std::nullopt;
}

Vector3d RayThrough(const CameraModel& camera, double x, double y) {
  return {(x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1.0};
}

// The cone around a tile's rays.
std::pair<Vector3d, double> ConeOf(const CameraModel& camera, const cv::Rect& tile) {
  const Vector3d axis =
      RayThrough(camera, tile.x + 0.5 * tile.width, tile.y + 0.5 * tile.height).normalized();
  double half_angle = 0;
  for (const int x : {tile.x, tile.x + tile.width})
    for (const int y : {tile.y, tile.y + tile.height}) {
      const Vector3d corner = RayThrough(camera, x, y);
      half_angle = std::max(half_angle, std::atan2(axis.cross(corner).norm(), axis.dot(corner)));
    }
  return {axis, half_angle};
}

}  // namespace

cv::Vec3f SampleView(const SceneView& view, int level, const Vector2d& img) {
  const cv::Mat& pixels = view.pyramid[static_cast<std::size_t>(level)];
  const double x = img.x() * pixels.cols / view.camera.width - 0.5;
  const double y = img.y() * pixels.rows / view.camera.height - 0.5;
  const int left = static_cast<int>(std::floor(x)), top = static_cast<int>(std::floor(y));
  const float right_share = static_cast<float>(x - left), below_share = static_cast<float>(y - top);
  const cv::Vec3f above =
      LinearAt(pixels, left, top) * (1 - right_share) + LinearAt(pixels, left + 1, top) * right_share;
  const cv::Vec3f below =
      LinearAt(pixels, left, top + 1) * (1 - right_share) + LinearAt(pixels, left + 1, top + 1) * right_share;
  return above * (1 - below_share) + below * below_share;
}

ReferenceRenderer::ReferenceRenderer(std::shared_ptr<const RenderScene> scene, const RenderOptions& options)
    : scene_(std::move(scene)), options_(options), proxy_(scene_->subject) {
  SetField(options.field);
}

void ReferenceRenderer::SetField(const FieldOptions& field) {
  options_.field = FieldThatServes(field, scene_->mesh);
  field_ = MakeField(scene_, options_.field);
}

Rendering ReferenceRenderer::Render(const CameraModel& camera, const Rigid3& cam_from_world) {
  RequireUndistorted(camera);
  const auto start = std::chrono::steady_clock::now();
  FrameSetup setup{
      *scene_, camera, cam_from_world.Inverse(), cam_from_world.OriginInSource(), options_.show_field,
      {},      {}};
  for (const SceneView& view : scene_->views)
    setup.level.push_back(PyramidLevel(view, scene_->subject, setup.virtual_center, camera.MeanFocalPx()));
  setup.views_by_distance = ViewsByDistance(*scene_, setup.virtual_center);

  const cv::Mat depth = proxy_.Depth(camera, cam_from_world);
  const auto field = field_->From(setup.virtual_center);
  Rendering picture;
  picture.linear = cv::Mat::zeros(camera.height, camera.width, CV_32FC3);
  picture.confidence = cv::Mat::zeros(camera.height, camera.width, CV_32F);
  FieldSample sample;

  const auto shade_pixel = [&](int x, int y, const std::vector<int>& candidates) {
    const Vector3d ray_in_cam = RayThrough(camera, x + 0.5, y + 0.5);
    const Vector3d point = setup.world_from_cam * (ray_in_cam * depth.at<float>(y, x));
    const Vector3d ray_in_world = setup.world_from_cam.rotation * ray_in_cam.normalized();
    field->Weights({ray_in_world, point, candidates.empty() ? nullptr : &candidates}, sample);
    const Shade shade = BlendViews(setup, sample, point);
    if (shade.weight >= kLeastWeight) {
      picture.linear.at<cv::Vec3f>(y, x) = shade.light * static_cast<float>(1 / shade.weight);
      picture.confidence.at<float>(y, x) =
          static_cast<float>(sample.confidence * std::min(1.0, shade.weight));
      return;
    }
    const auto light = options_.fill ? NearestLight(setup, point) : std::nullopt;
    if (light) picture.linear.at<cv::Vec3f>(y, x) = *light;
    ++(light ? picture.filled_px : picture.empty_px);
  };

  constexpr int kTile = 16;
  for (int top = 0; top < camera.height; top += kTile)
    for (int left = 0; left < camera.width; left += kTile) {
      const cv::Rect tile(left, top, std::min(kTile, camera.width - left),
                          std::min(kTile, camera.height - top));
      const auto [axis_in_cam, half_angle] = ConeOf(camera, tile);
      const auto candidates =
          field->CandidatesInCone(setup.world_from_cam.rotation * axis_in_cam, half_angle);
      for (int y = tile.y; y < tile.y + tile.height; ++y)
        for (int x = tile.x; x < tile.x + tile.width; ++x) shade_pixel(x, y, candidates);
    }
  picture.ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  return picture;
}

}  // namespace ulf
