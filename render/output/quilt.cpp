#include "render/output/quilt.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/quantile.h"
#include "core/geometry/angles.h"
#include "render/output/camera_path.h"
#include "render/output/picture_files.h"
#include "render/viewpoints/viewpoint_mesh.h"

namespace ulf::render {
namespace {

using Eigen::Vector3d;

constexpr double kConeStep = Radians(0.5);
constexpr double kWindowMargin = 1.1;  // around the subject's sphere. Guessed.
constexpr double kOutermostViews = 0.03;

// The line of viewpoints before the window.
struct QuiltLine {
  Vector3d center, right, towards_viewer;  // of the window; unit directions
  double distance = 0;
  Vector3d ViewpointAt(double angle) const {
    return center + distance * (towards_viewer + std::tan(angle) * right);
  }
};

// Returns how far before the subject's centre, seen from there, its surface lies: the median of the proxy's
// triangles within its sphere; 0 without triangles.
double SurfaceBefore(const RenderScene& scene, const Rigid3& cam_from_world) {
  if (!scene.proxy || !scene.proxy->Occluder()) return 0;
  constexpr int kSide = 64;
  const Vector3d center = cam_from_world * scene.subject.center_in_world;
  const double radius = scene.subject.radius;
  const CameraModel camera = CameraModel::Pinhole(kSide, kSide, 0.5 * kSide * center.z() / radius);
  const cv::Mat depth = scene.proxy->Depth(camera, cam_from_world);
  std::vector<double> depths;
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x)
      if (std::hypot(x + 0.5 - camera.cx, y + 0.5 - camera.cy) < 0.5 * kSide)
        depths.push_back(static_cast<double>(depth.at<float>(y, x)));
  return std::clamp(center.z() - Median(std::move(depths)), -radius, radius);
}

// Tells whether the recorded viewpoints cover an angle.
class CarriedAngles {
 public:
  CarriedAngles(const RenderScene& scene, const QuiltLine& line) : scene_(scene), line_(line) {
    if (scene.mesh.span == Span::kSurface) return;
    std::vector<double> angles;  // of a row or a ring
    for (const Vector3d& center : scene.Centers()) angles.push_back(AngleOf(center));
    low_ = Quantile(angles, kOutermostViews);
    high_ = Quantile(angles, 1 - kOutermostViews);
  }
  bool operator()(double angle) const {
    const Vector3d viewpoint = line_.ViewpointAt(angle);
    if (scene_.mesh.span == Span::kSurface)
      return InsideHull(scene_.mesh, (viewpoint - scene_.subject.center_in_world).normalized());
    const double of_subject = AngleOf(viewpoint);
    return of_subject >= low_ && of_subject <= high_;
  }

 private:
  // The angle is seen from the subject's centre.
  double AngleOf(const Vector3d& viewpoint) const {
    const Vector3d arm = viewpoint - scene_.subject.center_in_world;
    return std::atan2(arm.dot(line_.right), arm.dot(line_.towards_viewer));
  }

  const RenderScene& scene_;
  QuiltLine line_;
  double low_ = 0, high_ = 0;
};

double WidestCone(const CarriedAngles& carried) {
  double half = 0;
  while (half + kConeStep <= 0.5 * kMostViewCone && carried(half + kConeStep) && carried(-half - kConeStep))
    half += kConeStep;
  return 2 * half;
}

cv::Size TileSize(const QuiltFormat& format) {
  return {format.width_px / std::max(1, format.columns), format.height_px / std::max(1, format.rows)};
}

void RequireFormat(const QuiltFormat& format) {
  constexpr int kLeastTilePx = 16;
  const cv::Size tile = TileSize(format);
  if (format.columns < 1 || format.rows < 1 || format.columns * format.rows < 2 ||
      std::min(tile.width, tile.height) < kLeastTilePx || !(format.aspect > 0) ||
      !std::isfinite(format.aspect))
    throw Refusal(fmt::format("a quilt of {}x{} tiles in {}x{} pixels", format.columns, format.rows,
                              format.width_px, format.height_px),
                  "", fmt::format("it has at least 2 tiles of {} pixels a side", kLeastTilePx),
                  fmt::format("give fewer tiles ({} 8x6) or a larger picture ({} 3360x3360)",
                              Parameter("tiles"), Parameter("size")));
}

}  // namespace

const std::vector<NamedQuilt>& QuiltDisplays() {
  static const std::vector<NamedQuilt> displays = {{"portrait", {8, 6, 3360, 3360, 0.75}},
                                                   {"go", {11, 6, 4092, 4092, 0.5625}},
                                                   {"16-landscape", {7, 7, 5999, 5999, 1.77778}},
                                                   {"16-portrait", {11, 6, 5995, 6000, 0.5625}},
                                                   {"32-landscape", {7, 7, 8190, 8190, 1.77778}},
                                                   {"32-portrait", {11, 6, 8184, 8184, 0.5625}},
                                                   {"65", {8, 9, 8192, 8192, 1.77778}}};
  return displays;
}

QuiltFormat QuiltOfDisplay(const std::string& name) {
  std::vector<std::string> names;
  for (const NamedQuilt& known : QuiltDisplays()) {
    if (name == known.display) return known.format;
    names.emplace_back(known.display);
  }
  throw Refusal(Parameter("display"), name, "there is no such display",
                fmt::format("there are {}; others by {}, {} and {}", fmt::join(names, ", "),
                            Parameter("tiles"), Parameter("size"), Parameter("aspect")));
}

QuiltViews QuiltViewsOf(const RenderScene& scene, const QuiltOptions& options) {
  const QuiltFormat& format = options.format;
  RequireFormat(format);
  const Rigid3 middle = OrbitPath(scene, 1).cam_from_world.front();
  QuiltViews views;
  views.right = middle.DirectionInSource(Vector3d::UnitX());
  views.up = -middle.DirectionInSource(Vector3d::UnitY());
  const Vector3d towards_viewer = -middle.DirectionInSource(Vector3d::UnitZ());
  views.window_center = scene.subject.center_in_world + SurfaceBefore(scene, middle) * towards_viewer;
  const QuiltLine line{views.window_center, views.right, towards_viewer,
                       (middle.OriginInSource() - views.window_center).norm()};
  const CarriedAngles carried(scene, line);
  views.view_cone = options.view_cone.value_or(WidestCone(carried));

  const double fits = 2 * kWindowMargin * scene.subject.radius / options.zoom;
  views.height = std::max(fits, fits / format.aspect);
  views.width = views.height * format.aspect;
  const cv::Size tile = TileSize(format);
  CameraModel camera =
      CameraModel::Pinhole(tile.width, tile.height, line.distance * tile.width / views.width);
  camera.fy = line.distance * tile.height / views.height;
  const int count = format.columns * format.rows;
  for (int i = 0; i < count; ++i) {
    const double angle = (static_cast<double>(i) / (count - 1) - 0.5) * views.view_cone;
    CameraModel sheared = camera;
    sheared.cx += camera.fx * std::tan(angle);  // the window's middle stays in the tile's
    views.cameras.push_back(sheared);
    const Vector3d viewpoint = line.ViewpointAt(angle);
    views.cam_from_world.push_back({middle.rotation, -(middle.rotation * viewpoint)});
    views.outside += !carried(angle);
  }
  return views;
}

cv::Mat DrawQuilt(Renderer& renderer, const QuiltViews& views, const QuiltFormat& format,
                  const std::function<void(int done)>& progress) {
  const cv::Size tile = TileSize(format);
  cv::Mat quilt(tile.height * format.rows, tile.width * format.columns, CV_8UC3);
  for (std::size_t i = 0; i < views.cameras.size(); ++i) {
    if (i + 1 < views.cameras.size()) renderer.Prefetch(views.cameras[i + 1], views.cam_from_world[i + 1]);
    const Rendering picture = renderer.Render(views.cameras[i], views.cam_from_world[i]);
    const int number = static_cast<int>(i), column = number % format.columns, row = number / format.columns;
    DisplayPicture(picture, {})
        .copyTo(quilt({column * tile.width, (format.rows - 1 - row) * tile.height, tile.width, tile.height}));
    if (progress) progress(number + 1);
  }
  return quilt;
}

std::string QuiltName(const std::string& name, const QuiltFormat& format) {
  return fmt::format("{}_qs{}x{}a{:.6g}.png", name, format.columns, format.rows, format.aspect);
}

}  // namespace ulf::render
