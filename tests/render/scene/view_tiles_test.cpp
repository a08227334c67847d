// Tests: render/scene/view_tiles.
//
// Which views are looked through where: none too few, few too many.
#include "render/scene/view_tiles.h"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <numeric>

#include "core/base/at.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"

namespace ulf::test::view_tiles_test {
namespace {

using Eigen::Vector3d;

struct Looked {
  int pixels = 0, tests = 0;  // views that were tested at all pixels together
};

// Every view that has a pixel's point in its image is looked through there, or ends behind one that has it.
Looked ExpectNoneIsMissed(const RenderScene& scene, const ViewTiler::Picture& picture, const cv::Mat& depth,
                          bool ends) {
  std::vector<int> order(scene.views.size());
  std::iota(order.rbegin(), order.rend(), 0);
  ViewTiler tiler(scene.views);
  const ViewTiles tiled = tiler.Tile(scene.views, order, picture, [&](int) { return ends; });
  cv::Mat tile_of(depth.size(), CV_32S, cv::Scalar(-1));
  Looked looked{static_cast<int>(depth.total())};
  for (std::size_t i = 0; i < tiled.tiles.size(); ++i) {
    const ViewTiles::Tile& tile = tiled.tiles[i];
    EXPECT_EQ(cv::norm(tile_of(tile.px), cv::Mat(tile.px.size(), CV_32S, cv::Scalar(-1)), cv::NORM_INF), 0);
    tile_of(tile.px).setTo(static_cast<int>(i));
    looked.tests += tile.px.area() * (tile.end - tile.first);
  }
  const Rigid3 world_from_cam = picture.cam_from_world.Inverse();
  int missed = 0;
  for (int y = 0; y < depth.rows; y += 3)
    for (int x = 0; x < depth.cols; x += 3) {
      const CameraModel& camera = picture.camera;
      const Vector3d ray((x + 0.5 - camera.cx) / camera.fx, (y + 0.5 - camera.cy) / camera.fy, 1);
      const Vector3d point = world_from_cam * (ray * depth.at<float>(y, x));
      const int index = tile_of.at<int>(y, x);
      std::vector<int> there;
      if (index >= 0) {
        const auto begin = tiled.views.begin();
        there.assign(begin + tiled.tiles[At(index)].first, begin + tiled.tiles[At(index)].end);
      }
      auto at = there.begin();
      for (const int view : order) {
        if (!scene.views[At(view)].Project(point)) continue;
        at = std::find(at, there.end(), view);  // in their order, too
        missed += at == there.end();
        if (ends) break;
      }
    }
  EXPECT_EQ(missed, 0);
  return looked;
}

ViewTiler::Picture From(const RenderScene& scene, const Vector3d& eye, const Vector3d& target) {
  const Rigid3 cam_from_world = LookAt(eye, target, Vector3d::UnitY());
  return {CameraModel::Pinhole(320, 200, 220), cam_from_world, scene.proxy->Background(cam_from_world),
          nullptr};
}

TEST(ViewTiles, NoViewIsMissedWhateverItsLens) {
  for (const Distortion distortion :
       {Distortion::kNone, Distortion::kRadialTangential, Distortion::kFisheye}) {
    auto scene = *MakeScene({.viewpoints = CapViewpoints(40, 0.6, 2.0), .width = 48, .height = 36});
    for (SceneView& view : scene.views) {
      view.camera.distortion = distortion;
      if (distortion != Distortion::kNone) view.camera.coefficients = {-0.2, 0.05, 0.01, -0.01, 0};
    }
    for (const auto& [eye, target] : {std::pair(Vector3d(0.3, 0.2, 5), Vector3d(0, 0, 0)),
                                      std::pair(Vector3d(0.1, 0.2, 1), Vector3d(0.4, 0, 0)),
                                      std::pair(Vector3d(1.5, 0.2, 0.5), Vector3d(0, 0, 0.3))}) {
      const auto picture = From(scene, eye, target);
      const cv::Mat depth = scene.proxy->Depth(picture.camera, picture.cam_from_world);
      ExpectNoneIsMissed(scene, picture, depth, false);
      ExpectNoneIsMissed(scene, picture, depth, true);
    }
  }
}

TEST(ViewTiles, NoViewIsMissedBeforeOrBehindTriangles) {
  const auto flat = MakeScene({.viewpoints = CapViewpoints(40, 0.6, 2.0), .width = 48, .height = 36});
  auto mesh = std::make_shared<TriangleMesh>();
  mesh->vertices = {{-0.5f, -0.4f, 0.9f}, {0.6f, 0.1f, -1.5f}, {0.1f, 0.5f, 1.2f}};
  mesh->triangles = {{0, 1, 2}};
  const auto scene = WithProxy(*flat, std::make_shared<MeshProxy>(flat->subject, mesh));
  for (const Vector3d& eye : {Vector3d(0.3, 0.2, 5), Vector3d(0.2, 0.2, 1.3), Vector3d(2.5, 0.2, 0.5)}) {
    auto picture = From(*scene, eye, {0, 0, 0});
    picture.triangles = mesh;
    ExpectNoneIsMissed(*scene, picture, scene->proxy->Depth(picture.camera, picture.cam_from_world), false);
  }
}

// Points make other triangles for each picture, which may come to lie where former ones were.
TEST(ViewTiles, KnownTrianglesAreKeptAlive) {
  const auto scene = MakeScene({.viewpoints = CapViewpoints(5, 0.6, 2.0)});
  ViewTiler tiler(scene->views);
  ViewTiler::Picture picture = From(*scene, {0.3, 0.2, 5}, {0, 0, 0});
  picture.triangles = std::make_shared<TriangleMesh>();
  const std::weak_ptr<const TriangleMesh> known = picture.triangles;
  const std::vector<int> order{0, 1, 2, 3, 4};
  tiler.Tile(scene->views, order, picture, [](int) { return true; });
  picture.triangles = nullptr;
  EXPECT_FALSE(known.expired());
}

// From afar most of the picture lies beside all photographs; from near one photograph often has a whole tile.
TEST(ViewTiles, FewViewsAreSearched) {
  const auto scene = MakeScene({.viewpoints = CapViewpoints(200, 0.4, 2.0), .width = 48, .height = 36});
  const auto looked_from = [&](double distance, bool ends) {
    const auto picture = From(*scene, {0.1, 0.1, distance}, {0, 0, 0});
    const Looked looked = ExpectNoneIsMissed(
        *scene, picture, scene->proxy->Depth(picture.camera, picture.cam_from_world), ends);
    return static_cast<double>(looked.tests) / looked.pixels;
  };
  EXPECT_LT(looked_from(10, true), 10) << "of 200 at a pixel";
  EXPECT_LT(looked_from(10, false), 30);
  EXPECT_LT(looked_from(1.2, true), 50);
}

}  // namespace
}  // namespace ulf::test::view_tiles_test
