// Tests: render/proxy/photograph_depth.
#include "render/proxy/photograph_depth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "tests/render/scenes/synthetic_views.h"

namespace ulf::test::photograph_depth_test {
namespace {

using Eigen::Vector3d;

struct Surface {
  double depth;  // along the camera's axis
  bool is_square;
};

// Returns where the ray of a pixel meets the square, or else the plane z = 0.
std::optional<Surface> TrueSurface(const CameraModel& camera, const Rigid3& cam_from_world, int x, int y) {
  const auto ray_in_cam = camera.RayFromImg({x + 0.5, y + 0.5});
  if (!ray_in_cam || ray_in_cam->z() <= 0) return std::nullopt;
  const Rigid3 world_from_cam = cam_from_world.Inverse();
  const Vector3d center = world_from_cam.translation, ray = world_from_cam.rotation * *ray_in_cam;
  const double to_square = (kSquareZ - center.z()) / ray.z(), to_plane = -center.z() / ray.z();
  const Vector3d on_square = center + to_square * ray;
  const bool hits = to_square > 0 && std::max(std::abs(on_square.x()), std::abs(on_square.y())) < kSquareHalf;
  if (!hits && to_plane <= 0) return std::nullopt;
  return Surface{(hits ? to_square : to_plane) * ray_in_cam->z(), hits};
}

// Depths end at a slope of 3, 71 degrees from the axis.
bool IsBeyond(const CameraModel& camera, int x, int y) {
  const Vector3d ray = *camera.RayFromImg({x + 0.5, y + 0.5});
  return std::max(std::abs(ray.x()), std::abs(ray.y())) > 2.95 * ray.z();
}

LightField Seeing(int views, double half_angle, double unit = 1) {
  LightField light_field;
  light_field.cameras = {CameraModel::Pinhole(96, 72, 80)};
  for (const Vector3d& center : CapViewpoints(views, half_angle, 2.0)) {
    View& view = light_field.views.emplace_back();
    view.id = static_cast<int>(light_field.views.size());
    view.cam_from_world = LookAt(unit * center, unit * Vector3d(0.02, -0.01, 0), Vector3d::UnitY());
  }
  return light_field;
}

std::map<int, render::ViewDepthMap> TrueMaps(const LightField& light_field, double unit = 1) {
  std::map<int, render::ViewDepthMap> maps;
  for (const View& view : light_field.views)
    maps.emplace(view.id,
                 render::DepthMapOfMesh(*PlaneAndSquare(unit), light_field.cameras[0].ScaledTo(48, 36),
                                        view.cam_from_world, 0.005 / unit));
  return maps;
}

// 255 where a neighbour of the pixel sees the other surface: the texel nearest to the pixel may see it, too.
cv::Mat EdgesOfSquare(const CameraModel& camera, const Rigid3& cam_from_world) {
  cv::Mat on_square(SizeOf(camera), CV_8U, cv::Scalar(0));
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x)
      if (const auto truth = TrueSurface(camera, cam_from_world, x, y); truth && truth->is_square)
        on_square.at<std::uint8_t>(y, x) = 255;
  cv::Mat edges;
  cv::morphologyEx(on_square, edges, cv::MORPH_GRADIENT, cv::Mat::ones(3, 3, CV_8U));
  return edges;
}

// The slanted plane is exact to the rim, too, though a pixel of a fisheye there is ten texels wide.
TEST(PhotographDepth, IsAlongTheAxisThroughEveryLens) {
  const LightField light_field = Seeing(6, 0.6);
  const render::PhotographDepths depths(light_field, PlaneAndSquare(), {});
  EXPECT_FALSE(depths.HasConfidence());
  const CameraModel lenses[] = {
      CameraModel::Pinhole(120, 90, 100),
      {120, 90, 100, 101, 57.3, 47.2, Distortion::kRadialTangential, {-0.21, 0.06, 0.0008, -0.0011, 0}},
      {121, 83, 40, 40.5, 61.2, 40.1, Distortion::kFisheye, {0.02, -0.004, 0.001, -0.0002, 0}},
      // Parts of pictures whose rays are interpolated between nodes.
      {120, 90, 600, 603, 61.2, 41.1, Distortion::kRadialTangential, {-0.21, 0.06, 0.0008, -0.0011, 0}},
      {120, 90, 300, 301, -80.5, 40.1, Distortion::kFisheye, {0.02, -0.004, 0.001, -0.0002, 0}}};
  for (const CameraModel& lens : lenses)
    for (const View& view : light_field.views) {
      const PhotographDepth pixels = depths.Of(view, lens);
      ASSERT_EQ(pixels.depth.size(), SizeOf(lens));
      EXPECT_TRUE(pixels.confidence.empty());
      const cv::Mat edges = EdgesOfSquare(lens, view.cam_from_world);
      int compared = 0;
      for (int y = 0; y < lens.height; ++y)
        for (int x = 0; x < lens.width; ++x) {
          const auto truth = TrueSurface(lens, view.cam_from_world, x, y);
          if (!truth || truth->depth > 6 || IsBeyond(lens, x, y) || edges.at<std::uint8_t>(y, x) > 0)
            continue;
          ++compared;
          ASSERT_NEAR(pixels.depth.at<float>(y, x), truth->depth, 3e-5 * truth->depth)
              << lens.fx << " px, view " << view.id << ", pixel " << x << ", " << y;
        }
      EXPECT_GT(compared, 0.5 * lens.width * lens.height);
    }
}

TEST(PhotographDepth, IsUnknownWhereTheMeshIsNot) {
  const LightField light_field = Seeing(3, 0.3);
  auto square = std::make_shared<render::TriangleMesh>(*PlaneAndSquare());
  square->triangles.erase(square->triangles.begin(), square->triangles.begin() + 2);
  const View& view = light_field.views[0];
  // The maps fill what the mesh leaves out.
  const render::PhotographDepths depths(light_field, square,
                                        render::SoftProxy::InMemory(TrueMaps(light_field)));
  const cv::Mat depth = depths.Of(view, light_field.cameras[0]).depth;
  const auto in_middle = light_field.cameras[0].ImgFromCam(view.cam_from_world * Vector3d(0, 0, kSquareZ));
  EXPECT_NEAR(depth.at<float>(static_cast<int>(in_middle->y()), static_cast<int>(in_middle->x())),
              (view.cam_from_world * Vector3d(0, 0, kSquareZ)).z(), 0.01);
  EXPECT_EQ(depth.at<float>(0, 0), 0);
  EXPECT_LT(cv::countNonZero(depth), 0.1 * static_cast<double>(depth.total()));
}

// The view's own map is taken, and where other maps see through what it shows, no one agrees.
TEST(PhotographDepth, IsDoubtedWhereOthersSeeThrough) {
  const LightField light_field = Seeing(6, 0.4);
  std::map<int, render::ViewDepthMap> maps = TrueMaps(light_field);
  const cv::Rect floating(4, 4, 12, 10);
  cv::Mat piece = maps.at(1).inverse_depth(floating);
  piece.setTo(65535);  // the nearest that the map can tell: as the square
  const double floats_at = 1 / (65535 * maps.at(1).unit);
  const render::PhotographDepths depths(light_field, PlaneAndSquare(), render::SoftProxy::InMemory(maps));
  ASSERT_TRUE(depths.HasConfidence());
  const View& view = light_field.views[0];
  const CameraModel& camera = light_field.cameras[0];
  const PhotographDepth pixels = depths.Of(view, camera);
  const cv::Rect in_photograph(2 * floating.x + 2, 2 * floating.y + 2, 2 * floating.width - 4,
                               2 * floating.height - 4);
  EXPECT_EQ(cv::countNonZero(pixels.confidence(in_photograph)), 0);
  EXPECT_NEAR(pixels.depth.at<float>(18, 20), floats_at, 1e-3);
  EXPECT_LT(floats_at, 0.95 * TrueSurface(camera, view.cam_from_world, 20, 18)->depth);
  cv::Mat elsewhere(pixels.depth.size(), CV_8U, cv::Scalar(255));
  elsewhere(cv::Rect(0, 0, 40, 36)) = 0;
  EXPECT_GT(cv::mean(pixels.confidence, elsewhere)[0], 0.9);
}

// At every size of the world the unit shows the farthest depths, and rounds the nearest by little.
TEST(PhotographDepth, UnitOfSixteenBitsKeepsTheRange) {
  for (const double unit : {1e-3, 0.05, 1.0, 12.0, 1e4}) {
    const LightField light_field = Seeing(6, 0.3, unit);
    const render::PhotographDepths depths(light_field, PlaneAndSquare(unit), {});
    const double png_unit = render::UnitForSixteenBits(depths, light_field);
    EXPECT_LT(3 * unit / png_unit, 65535) << unit;
    EXPECT_GT(1 * unit / png_unit, 200) << unit;
    if (unit == 1.0) {
      EXPECT_EQ(png_unit, 1e-3) << "millimetres of metres";
    }
  }
}

}  // namespace
}  // namespace ulf::test::photograph_depth_test
