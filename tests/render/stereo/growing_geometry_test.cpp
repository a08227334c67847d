// Tests: render/stereo/growing_geometry, render/stereo/mesh_of_maps, render/stereo/stereo_view,
// core/base/host_time.
//
// Geometry that grows with the views, against the depth that is right.
#include "render/stereo/growing_geometry.h"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "core/base/host_time.h"
#include "core/base/quantile.h"
#include "render/proxy/depth_raster.h"
#include "tests/render/stereo/stereo_scenes.h"
#include "tests/support/floors.h"

namespace ulf::growing_geometry_test {
namespace {

using Eigen::Vector3d;
using test::Drawn;
using test::Mottled;
using test::Patch;

const Subject kSubject{{0, 0, 3}, 0.6};

// A slab before a wall.
std::vector<Patch> SlabBeforeWall() {
  return {{{-8, -6, 4.5}, {16, 0, 0}, {0, 12, 0}, Mottled(0.02, 1)},
          {{-0.7, -0.5, 3}, {1.4, 0, 0.2}, {0, 1.0, 0}, Mottled(0.06, 2)}};
}

// Five by five views a tenth apart, which look at the subject; in the order of rows.
const std::vector<Drawn>& GridOfViews() {
  static const std::vector<Drawn> views = [] {
    std::vector<Drawn> drawn;
    for (int row = 0; row < 5; ++row)
      for (int column = 0; column < 5; ++column)
        drawn.push_back(Draw(SlabBeforeWall(), {0.2 * (column - 2), 0.2 * (row - 2), 0}, {0, 0, 3}));
    return drawn;
  }();
  return views;
}

GrowingGeometryOptions Small() {
  GrowingGeometryOptions options;
  options.least_apart = Radians(5);
  return options;
}

GrowingGeometry Grown(const GrowingGeometryOptions& options) {
  GrowingGeometry geometry(options);
  geometry.SetSubject(kSubject);
  for (std::size_t i = 0; i < GridOfViews().size(); ++i) {
    geometry.AddView(static_cast<int>(i), GridOfViews()[i].view);
    geometry.MakeNextMap(false);
  }
  while (geometry.MakeNextMap(true)) {
  }
  return geometry;
}

// Made once: tests change copies of it.
const GrowingGeometry& OfAllViews() {
  static const GrowingGeometry geometry = Grown(Small());
  return geometry;
}

// Of the maps' depths, by the depth that is right where there is one.
std::vector<double> RelativeErrors(const std::vector<ViewDepth>& maps, double scale = 1) {
  std::vector<double> errors;
  for (const ViewDepth& map : maps) {
    const auto drawn = std::ranges::min_element(GridOfViews(), {}, [&](const Drawn& view) {
      return (scale * view.view.center_in_world - map.view.center_in_world).norm();
    });
    for (int y = 6; y < map.depth.rows - 6; ++y)
      for (int x = 6; x < map.depth.cols - 6; ++x)
        if (map.depth.at<float>(y, x) > 0 && drawn->depth.at<float>(y, x) > 0)
          errors.push_back(std::abs(static_cast<double>(map.depth.at<float>(y, x)) /
                                        (scale * static_cast<double>(drawn->depth.at<float>(y, x))) -
                                    1));
  }
  return errors;
}

TEST(GrowingGeometry, MapsOfViewsOneByOneAreRight) {
  const GrowingGeometry& geometry = OfAllViews();
  EXPECT_EQ(geometry.views(), 25);
  EXPECT_GE(geometry.maps(), 6);
  EXPECT_LT(geometry.maps(), 20) << "neighbouring views share a map";
  EXPECT_EQ(geometry.MissingMaps(), 0);
  const std::vector<double> errors = RelativeErrors(geometry.Maps());
  EXPECT_GT(errors.size(), 6u * 80 * 60);
  EXPECT_LT(Quantile(errors, 0.5), 0.01);
  EXPECT_LT(Quantile(errors, 0.9), 0.06);
}

TEST(GrowingGeometry, ViewWaitsForNeighboursAround) {
  GrowingGeometry geometry(Small());
  EXPECT_FALSE(geometry.MakeNextMap(true)) << "no subject, no views";
  geometry.SetSubject(kSubject);
  geometry.AddView(0, GridOfViews()[0].view);
  EXPECT_FALSE(geometry.MakeNextMap(true)) << "one view has no neighbour";
  for (int i = 1; i < 5; ++i) geometry.AddView(i, GridOfViews()[static_cast<std::size_t>(i)].view);
  EXPECT_FALSE(geometry.MakeNextMap(false) && geometry.maps() > 2)
      << "a row has neighbours at two sides only";
  const int missing = geometry.MissingMaps();
  EXPECT_GT(missing, 0);
  int made = 0;
  while (geometry.MakeNextMap(true)) ++made;
  EXPECT_EQ(made, missing);
  EXPECT_EQ(geometry.MissingMaps(), 0);
}

TEST(GrowingGeometry, MissingMapsAreMadeRepeatably) {
  const auto made_at_once = [] {
    GrowingGeometry geometry(Small());
    geometry.SetSubject(kSubject);
    for (std::size_t i = 0; i < GridOfViews().size(); ++i)
      geometry.AddView(static_cast<int>(i), GridOfViews()[i].view);
    geometry.MakeMissingMaps(0);
    EXPECT_EQ(geometry.maps(), 0) << "no time, no map";
    const int missing = geometry.MissingMaps();
    geometry.MakeMissingMaps(600);
    EXPECT_EQ(geometry.maps(), missing);
    return geometry.Maps();
  };
  const std::vector<ViewDepth> once = made_at_once(), again = made_at_once();
  ASSERT_EQ(once.size(), again.size());
  for (std::size_t i = 0; i < once.size(); ++i)
    EXPECT_EQ(cv::norm(once[i].depth, again[i].depth, cv::NORM_INF), 0) << i;
  EXPECT_LT(Quantile(RelativeErrors(once), 0.5), 0.01);
}

TEST(StereoViewMaker, PictureIsUndistortedAndReduced) {
  const CameraModel camera = [] {
    CameraModel distorted = CameraModel::Pinhole(640, 480, 560);
    distorted.distortion = Distortion::kRadialTangential;
    distorted.coefficients = {-0.1, 0.02, 0, 0, 0};
    return distorted;
  }();
  // A line that is straight in space is bent in the picture, and straight again afterwards.
  cv::Mat picture(480, 640, CV_8UC3, cv::Scalar::all(20));
  const Rigid3 pose;
  for (double x = -0.6; x < 0.6; x += 0.0005)
    if (const auto img = camera.ImgFromCam({x, 0.3, 1}))
      cv::circle(picture, {static_cast<int>(img->x()), static_cast<int>(img->y())}, 3, cv::Scalar::all(250),
                 -1);
  StereoViewMaker maker(320);
  for (int repeat = 0; repeat < 2; ++repeat) {
    const StereoView view = maker.Make(picture, camera, pose);
    ASSERT_EQ(view.grey.size(), cv::Size(320, 240));
    EXPECT_EQ(view.camera.distortion, Distortion::kNone);
    for (const double x : {-0.5, -0.2, 0.0, 0.3, 0.5}) {
      const auto img = view.camera.ImgFromCam({x, 0.3, 1});
      ASSERT_TRUE(img);
      EXPECT_GT(view.grey.at<float>(static_cast<int>(img->y()), static_cast<int>(img->x())), 180) << x;
      EXPECT_LT(view.grey.at<float>(static_cast<int>(img->y()) - 6, static_cast<int>(img->x())), 60) << x;
    }
  }
}

TEST(GrowingGeometry, MakesNoMoreMapsThanAsked) {
  GrowingGeometryOptions options = Small();
  options.least_apart = Radians(1.6);
  options.depth_maps = 4;
  EXPECT_LE(Grown(options).maps(), 14) << "beyond the number they are three times as far apart";
  options.depth_maps = 60;
  EXPECT_GT(Grown(options).maps(), 20);
}

// The world grows by a tenth, as a loop that closes may have it: depths grow with it, nothing is made anew.
TEST(GrowingGeometry, MapsFollowACorrectedScale) {
  GrowingGeometry geometry = OfAllViews();
  const int maps = geometry.maps();
  constexpr double kScale = 1.1;
  std::map<int, Rigid3> moved;
  for (std::size_t i = 0; i < GridOfViews().size(); ++i) {
    Rigid3 pose = GridOfViews()[i].view.cam_from_world;
    pose.translation *= kScale;
    moved[static_cast<int>(i)] = pose;
  }
  const std::vector<ViewDepth> before = geometry.Maps();
  geometry.SetSubject({kScale * kSubject.center_in_world, kScale * kSubject.radius});
  geometry.MoveViews(moved);
  EXPECT_EQ(geometry.maps(), maps);
  EXPECT_LT(Quantile(RelativeErrors(geometry.Maps(), kScale), 0.5), 0.01);
  EXPECT_GT(Quantile(RelativeErrors(before, kScale), 0.5), 0.05) << "who holds the old maps keeps them";
  for (std::size_t i = 0; i < before.size(); ++i)
    EXPECT_NEAR(geometry.Maps()[i].plane_step * kScale, before[i].plane_step, 1e-9);
}

// Of maps for rendering, by the depth that is right; `scale`: of the world by now.
std::vector<double> RelativeErrors(const std::map<int, ViewDepthMap>& maps, double scale) {
  std::vector<double> errors;
  for (const auto& [id, map] : maps) {
    const cv::Mat& depth = GridOfViews()[static_cast<std::size_t>(id)].depth;
    for (int y = 6; y < depth.rows - 6; ++y)
      for (int x = 6; x < depth.cols - 6; ++x)
        if (depth.at<float>(y, x) > 0)
          errors.push_back(
              std::abs(map.InverseDepthAt(x, y) * scale * static_cast<double>(depth.at<float>(y, x)) - 1));
  }
  return errors;
}

// Every pixel has a depth, by its own map or the mesh, and is as deep as the world is by then.
TEST(GrowingGeometry, RenderingMapsFollowTheWorld) {
  GrowingGeometry geometry = OfAllViews();
  const auto for_rendering = [&](const Subject& subject) {
    const MapsMesh mesh = MeshOfMaps(geometry.Maps(), subject, geometry.options().mesh);
    return geometry.MapsForRendering(mesh.mesh);
  };
  const std::map<int, ViewDepthMap> maps = for_rendering(kSubject);
  ASSERT_EQ(static_cast<int>(maps.size()), geometry.maps());
  for (const auto& [id, pose] : geometry.MapPoses()) EXPECT_TRUE(maps.contains(id)) << id;
  for (const auto& [id, map] : maps) {
    EXPECT_EQ(cv::countNonZero(map.inverse_depth), static_cast<int>(map.inverse_depth.total())) << id;
    EXPECT_GT(map.step, 0) << id;
  }
  EXPECT_LT(Quantile(RelativeErrors(maps, 1), 0.5), 0.01);
  EXPECT_LT(Quantile(RelativeErrors(maps, 1), 0.9), 0.06);

  constexpr double kScale = 1.1;
  std::map<int, Rigid3> moved;
  for (std::size_t i = 0; i < GridOfViews().size(); ++i) {
    moved[static_cast<int>(i)] = GridOfViews()[i].view.cam_from_world;
    moved[static_cast<int>(i)].translation *= kScale;
  }
  const Subject subject{kScale * kSubject.center_in_world, kScale * kSubject.radius};
  geometry.SetSubject(subject);
  geometry.MoveViews(moved);
  const int gone = maps.begin()->first;
  geometry.RemoveView(gone);
  const std::map<int, ViewDepthMap> now = for_rendering(subject);
  EXPECT_EQ(now.size() + 1, maps.size());
  EXPECT_FALSE(now.contains(gone));
  EXPECT_LT(Quantile(RelativeErrors(now, kScale), 0.5), 0.01);
  EXPECT_NEAR(now.begin()->second.step * kScale, maps.at(now.begin()->first).step, 1e-9);
}

TEST(GrowingGeometry, MapOfAMovedViewIsMadeAgain) {
  GrowingGeometry geometry = OfAllViews();
  const int maps = geometry.maps();
  const ViewDepth first = geometry.Maps().front();
  const auto id = std::ranges::find_if(GridOfViews(),
                                       [&](const Drawn& view) {
                                         return view.view.center_in_world == first.view.center_in_world;
                                       }) -
                  GridOfViews().begin();
  Rigid3 pose = first.view.cam_from_world;
  pose.translation += Vector3d(0.0005, 0, 0);  // a fiftieth of a pixel at the subject
  geometry.MoveViews({{static_cast<int>(id), pose}});
  EXPECT_EQ(geometry.maps(), maps);
  pose.translation += Vector3d(0.15, 0, 0);
  geometry.MoveViews({{static_cast<int>(id), pose}});
  EXPECT_LT(geometry.maps(), maps);
}

TEST(GrowingGeometry, ViewThatWasTakenBackIsGone) {
  GrowingGeometry geometry = OfAllViews();
  const int maps = geometry.maps();
  const std::uint64_t revision = geometry.revision();
  for (int id = 0; id < 25; ++id) geometry.RemoveView(id);
  geometry.RemoveView(99);
  EXPECT_EQ(geometry.views(), 0);
  EXPECT_EQ(geometry.maps(), 0);
  EXPECT_EQ(geometry.revision(), revision + static_cast<std::uint64_t>(maps));
  EXPECT_FALSE(geometry.MakeNextMap(true));
}

TEST(GrowingGeometry, SaysWhetherItsMapsHaveMoved) {
  GrowingGeometry geometry = OfAllViews();
  const std::map<int, Rigid3> then = geometry.MapPoses();
  ASSERT_EQ(static_cast<int>(then.size()), geometry.maps());
  EXPECT_FALSE(geometry.HaveMovedSince(then, 0.5));
  const auto moved = [&](double x) {
    std::map<int, Rigid3> poses;
    for (std::size_t i = 0; i < GridOfViews().size(); ++i) {
      Rigid3 pose = GridOfViews()[i].view.cam_from_world;
      pose.translation.x() += x;
      poses[static_cast<int>(i)] = pose;
    }
    return poses;
  };
  geometry.MoveViews(moved(0.0005));  // a fiftieth of a pixel at the subject
  EXPECT_FALSE(geometry.HaveMovedSince(then, 0.5));
  geometry.MoveViews(moved(0.1));
  EXPECT_TRUE(geometry.HaveMovedSince(then, 0.5));
  geometry.MoveViews(moved(0));
  EXPECT_FALSE(geometry.HaveMovedSince(then, 0.5));
  geometry.RemoveView(then.begin()->first);
  EXPECT_TRUE(geometry.HaveMovedSince(then, 0.5)) << "a map is gone";
}

TEST(RangeOfKnown, HoldsWhatTheViewSeesInFewerPlanes) {
  const std::vector<Drawn>& views = GridOfViews();
  std::vector<const StereoView*> neighbours;
  for (const int i : {6, 8, 16, 18}) neighbours.push_back(&views[static_cast<std::size_t>(i)].view);
  std::vector<ViewDepth> maps;
  for (const int i : {6, 18})
    maps.push_back({views[static_cast<std::size_t>(i)].view, views[static_cast<std::size_t>(i)].depth, 0.01});
  const StereoView& view = views[12].view;
  const auto range = RangeOfKnown(view, neighbours, {&maps[0], &maps[1]});
  ASSERT_TRUE(range);
  double least = 0, most = 0;
  cv::minMaxLoc(views[12].depth, &least, &most, nullptr, nullptr, views[12].depth > 0);
  EXPECT_LT(range->least, 1 / most);
  EXPECT_GT(range->most, 1 / least);
  const InverseDepthRange searched = PixelSpacedRange(view, neighbours, 0.2 * 3, 100 * 3);
  EXPECT_LT(range->planes, searched.planes / 2);
  // What other views know of somewhere else says nothing.
  StereoView elsewhere = view;
  elsewhere.cam_from_world =
      LookAt(view.center_in_world, view.center_in_world - Vector3d(0, 0, 1), Vector3d::UnitY());
  EXPECT_FALSE(RangeOfKnown(elsewhere, neighbours, {&maps[0], &maps[1]}));
  EXPECT_FALSE(RangeOfKnown(view, neighbours, {}));
}

TEST(MeshOfMaps, ShowsTheDepthThatIsRight) {
  const MapsMesh mesh = MeshOfMaps(OfAllViews().Maps(), kSubject);
  EXPECT_GT(mesh.points, 1000u);
  EXPECT_GT(mesh.agreeing_share, 0.5);
  const Drawn& middle = GridOfViews()[12];
  const cv::Mat inverse = DrawInverseDepth(mesh.mesh, middle.view.camera, middle.view.cam_from_world);
  std::vector<double> errors;
  for (int y = 6; y < inverse.rows - 6; ++y)
    for (int x = 6; x < inverse.cols - 6; ++x)
      if (inverse.at<float>(y, x) > 0 && middle.depth.at<float>(y, x) > 0)
        errors.push_back(
            std::abs(static_cast<double>(inverse.at<float>(y, x)) * middle.depth.at<float>(y, x) - 1));
  EXPECT_GT(errors.size(), 0.8 * (inverse.rows - 12) * (inverse.cols - 12));
  EXPECT_LT(Quantile(errors, 0.5), 0.01);
  EXPECT_TRUE(MeshOfMaps({}, kSubject).mesh.triangles.empty());
}

TEST(Stopwatch, CountsFromLapToLap) {
  Stopwatch watch;
  const double first = watch.LapSeconds(), second = watch.LapSeconds();
  EXPECT_GE(first, 0);
  EXPECT_GE(second, 0);
  EXPECT_LT(second, 60);
}

}  // namespace
}  // namespace ulf::growing_geometry_test
