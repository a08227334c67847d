// Tests: render/proxy/plane_search, render/proxy/planes_proxy.
#include "render/proxy/planes_proxy.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>

#include "core/base/error.h"
#include "render/fields/field_options.h"
#include "render/gl/gl_renderer.h"
#include "render/proxy/plane_search.h"
#include "render/proxy/points_proxy.h"
#include "render/quality/choice.h"
#include "render/quality/quality.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"

namespace ulf::planes_proxy_test {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

const CameraModel kCamera = CameraModel::Pinhole(160, 120, 200);
const Subject kSubject{Vector3d::Zero(), 0.3};

Rigid3 Looking(const Vector3d& center) { return LookAt(center, {0.02, -0.01, 0}, Vector3d::UnitY()); }

// Viewpoints 0.3 apart about (0, 0, 2), and points as somebody adds them, in a unit of length.
struct MadeOfPoints {
  explicit MadeOfPoints(unsigned seed = 1) : random(seed) {
    for (const Vector3d& at : test::GridViewpoints(5, 4, 0.3, 2.0)) {
      View view;
      view.id = static_cast<int>(light_field.views.size());
      view.cam_from_world = Looking(at);
      light_field.views.push_back(view);
    }
  }
  double Uniform(double from, double to) {
    return from + (to - from) * static_cast<double>(random()) / 4294967295.0;
  }
  // Seen by all views, as far as any of them looks.
  void Add(const Vector3d& at) {
    ScenePoint point{at};
    for (const View& view : light_field.views) point.track.push_back({view.id, Eigen::Vector2d::Zero()});
    light_field.points.push_back(point);
  }
  // origin + s * a + t * b + noise, s and t within one of zero.
  void AddPatch(int count, const Vector3d& origin, const Vector3d& a, const Vector3d& b,
                double noise = 0.002) {
    for (int i = 0; i < count; ++i) {
      const Vector3d off(Uniform(-noise, noise), Uniform(-noise, noise), Uniform(-noise, noise));
      Add(origin + Uniform(-1, 1) * a + Uniform(-1, 1) * b + off);
    }
  }
  void AddCloud(int count, double half = 0.8) {
    for (int i = 0; i < count; ++i) Add({Uniform(-half, half), Uniform(-half, half), Uniform(-half, half)});
  }
  LightField In(double unit) const {
    LightField scaled = light_field;
    for (View& view : scaled.views) view.cam_from_world.translation *= unit;
    for (ScenePoint& point : scaled.points) point.position_in_world *= unit;
    return scaled;
  }

  std::mt19937 random;
  LightField light_field;
};

const Vector3d kX = Vector3d::UnitX(), kY = Vector3d::UnitY(), kZ = Vector3d::UnitZ();

// A wall, a smaller layer before it, and clutter. Views show nothing of what the layer hides from them.
MadeOfPoints TwoLayers(unsigned seed = 1) {
  MadeOfPoints made(seed);
  const Vector3d middle(-0.2, 0.1, 0.5), half(0.3, 0.2, 0);
  made.AddPatch(600, {0, 0, -0.7}, 1.5 * kX, 1.2 * kY);
  made.AddPatch(250, middle, half.x() * kX, half.y() * kY);
  made.AddCloud(100);
  for (ScenePoint& point : made.light_field.points) {
    const Vector3d& at = point.position_in_world;
    if (at.z() > middle.z() - 0.01) continue;
    std::erase_if(point.track, [&](const ViewObservation& seen) {
      const Vector3d from =
          made.light_field.views[static_cast<std::size_t>(seen.view_id)].cam_from_world.OriginInSource();
      const Vector3d before = from + (from.z() - middle.z()) / (from.z() - at.z()) * (at - from);
      return ((before - middle).cwiseAbs() - half).maxCoeff() < 0.01;
    });
  }
  return made;
}

// How far the mesh's surface is from the viewpoint (0, 0, 2) along the ray to a place in the plane z = 0.
double DepthTowards(const LightField& light_field, double x, double y) {
  const auto proxy = MakePlanesProxy(kSubject, light_field);
  const Rigid3 pose = LookAt({0, 0, 2}, {0, 0, 0}, kY);
  const Eigen::Vector2d img = *kCamera.ImgFromCam(pose * Vector3d(x, y, 0));
  return proxy->Depth(kCamera, pose).at<float>(static_cast<int>(img.y()), static_cast<int>(img.x()));
}

TEST(PlaneSearchTest, FindsTwoLayersAmongOutliers) {
  for (const unsigned seed : {1u, 2u, 3u, 4u}) {
    const PlaneSearch search = FindPlanes(TwoLayers(seed).light_field);
    ASSERT_EQ(search.planes.size(), 2) << "seed " << seed << ": " << search.why_none;
    EXPECT_EQ(search.points, 950);
    EXPECT_GT(search.explained, 850.0 / 950);
    for (const auto& [i, z, count] : {std::tuple{0, -0.7, 600}, {1, 0.5, 250}}) {
      const FoundPlane& plane = search.planes[static_cast<std::size_t>(i)];
      EXPECT_GT(plane.normal.z(), std::cos(0.02)) << "towards the viewpoints, seed " << seed;
      EXPECT_NEAR(plane.offset, z, 0.01) << "seed " << seed;
      EXPECT_NEAR(static_cast<double>(plane.points.size()), count, 25) << "seed " << seed;
      EXPECT_TRUE(std::ranges::is_sorted(plane.points));
    }
  }
}

// A table that is seen from above and a wall behind it; nobody says what is upright.
TEST(PlaneSearchTest, FindsATableAndAWallInAnyFrame) {
  for (const double turn : {0.0, 0.7, 2.1}) {
    MadeOfPoints made;
    made.AddPatch(400, {0, -0.5, 0}, 0.8 * kX, 0.5 * Vector3d(0, -0.5, std::sqrt(0.75)));
    made.AddPatch(300, {0, 0.4, -0.6}, 1.0 * kX, 0.6 * kY);
    const Eigen::Matrix3d rotation = Eigen::AngleAxisd(turn, Vector3d(1, 2, -1).normalized()).matrix();
    for (View& view : made.light_field.views)
      view.cam_from_world.rotation = view.cam_from_world.rotation * Eigen::Quaterniond(rotation.transpose());
    for (ScenePoint& point : made.light_field.points)
      point.position_in_world = rotation * point.position_in_world;
    const PlaneSearch search = FindPlanes(made.light_field);
    ASSERT_EQ(search.planes.size(), 2) << "turned by " << turn << ": " << search.why_none;
    EXPECT_GT(search.planes[0].normal.dot(rotation * Vector3d(0, std::sqrt(0.75), 0.5)), std::cos(0.02));
    EXPECT_GT(search.planes[1].normal.dot(rotation * kZ), std::cos(0.02));
    EXPECT_NEAR(search.planes[1].offset, -0.6, 0.01);
  }
}

TEST(PlaneSearchTest, NoMorePlanesThanThereAre) {
  MadeOfPoints wall;
  wall.AddPatch(500, {0, 0, -0.2}, kX, kY, 0.004);
  EXPECT_EQ(FindPlanes(wall.light_field).planes.size(), 1);
}

TEST(PlaneSearchTest, ACloudHasNone) {
  for (const int count : {60, 200, 1000, 4000})
    for (const unsigned seed : {1u, 2u, 3u}) {
      MadeOfPoints made(seed);
      made.AddCloud(count);
      const PlaneSearch search = FindPlanes(made.light_field);
      EXPECT_TRUE(search.planes.empty()) << count << " points, seed " << seed;
      EXPECT_FALSE(search.why_none.empty());
      EXPECT_THROW(MakePlanesProxy(kSubject, made.light_field), Error);
    }
}

TEST(PlaneSearchTest, SaysWhyThereAreNone) {
  MadeOfPoints few;
  few.AddPatch(20, Vector3d::Zero(), kX, kY);
  EXPECT_THAT([&] { MakePlanesProxy(kSubject, few.light_field); },
              testing::ThrowsMessage<Error>(
                  testing::AllOf(HasSubstr("proxy planes: 20 tracked points"), HasSubstr("50 or more"))));
  MadeOfPoints some;
  some.AddPatch(200, Vector3d::Zero(), 0.5 * kX, 0.5 * kY);
  some.AddCloud(2000);
  EXPECT_THAT(FindPlanes(some.light_field).why_none, HasSubstr("explain"));
  // Points that are no numbers, or all in one place, or on a line; and no views.
  MadeOfPoints odd;
  for (int i = 0; i < 200; ++i) odd.Add(Vector3d::Constant(std::nan("")));
  EXPECT_FALSE(FindPlanes(odd.light_field).why_none.empty());
  for (ScenePoint& point : odd.light_field.points) point.position_in_world = kX;
  EXPECT_FALSE(FindPlanes(odd.light_field).why_none.empty());
  for (ScenePoint& point : odd.light_field.points) point.position_in_world = odd.Uniform(-1, 1) * kX;
  EXPECT_FALSE(FindPlanes(odd.light_field).why_none.empty());
  LightField blind = TwoLayers().light_field;
  blind.views.clear();
  EXPECT_FALSE(FindPlanes(blind).why_none.empty());
}

TEST(PlaneSearchTest, TheUnitOfLengthDoesNotMatter) {
  const MadeOfPoints made = TwoLayers();
  const PlaneSearch plain = FindPlanes(made.light_field);
  const auto mesh = MeshOfPlanes(plain.planes, made.light_field);
  for (const double unit : {1e-3, 1e3}) {
    const LightField scaled = made.In(unit);
    const PlaneSearch search = FindPlanes(scaled);
    ASSERT_EQ(search.planes.size(), plain.planes.size()) << unit;
    for (std::size_t i = 0; i < plain.planes.size(); ++i) {
      EXPECT_EQ(search.planes[i].points, plain.planes[i].points) << unit;
      EXPECT_NEAR(search.planes[i].offset / unit, plain.planes[i].offset, 1e-6) << unit;
    }
    const auto large = MeshOfPlanes(search.planes, scaled);
    EXPECT_NEAR(static_cast<double>(large->triangles.size()), static_cast<double>(mesh->triangles.size()),
                0.02 * static_cast<double>(mesh->triangles.size()));
  }
}

TEST(PlanesProxyTest, IsTheSameTwice) {
  const LightField light_field = TwoLayers().light_field;
  const auto first = MakePlanesProxy(kSubject, light_field), second = MakePlanesProxy(kSubject, light_field);
  EXPECT_EQ(first->Fingerprint(), second->Fingerprint());
  EXPECT_EQ(first->Name(), "planes");
  EXPECT_NE(first->Fingerprint(), MakePlanesProxy(kSubject, TwoLayers(2).light_field)->Fingerprint());
}

// Without views that know what they saw, too: then each point is seen from the nearest.
TEST(PlanesProxyTest, NeedsNoObservations) {
  MadeOfPoints made = TwoLayers();
  for (ScenePoint& point : made.light_field.points) point.track.clear();
  EXPECT_EQ(FindPlanes(made.light_field).planes.size(), 2);
  EXPECT_NEAR(DepthTowards(made.light_field, -0.2, 0.1), 1.5, 0.02);
}

TEST(PlanesProxyTest, EndsWhereItsPointsEnd) {
  const LightField light_field = TwoLayers().light_field;
  // Of the near layer, its middle and beside each edge: a tenth inside and, past the spacing of its
  // points, outside.
  EXPECT_NEAR(DepthTowards(light_field, -0.2 / 0.75, 0.1 / 0.75), 1.5, 0.02);
  for (const auto& [x, y] : {std::pair{-0.47, 0.1}, {0.07, 0.1}, {-0.2, -0.07}, {-0.2, 0.27}})
    EXPECT_NEAR(DepthTowards(light_field, x / 0.75, y / 0.75), 1.5, 0.02) << x << " " << y;
  for (const auto& [x, y] : {std::pair{-0.6, 0.1}, {0.2, 0.1}, {-0.2, -0.2}, {-0.2, 0.4}})
    EXPECT_NEAR(DepthTowards(light_field, x / 0.75, y / 0.75), 2.7, 0.02) << x << " " << y;
}

// A wall without features in its middle is closed; where points behind were seen through, it is open.
TEST(PlanesProxyTest, IsOpenOnlyWhereItWasSeenThrough) {
  MadeOfPoints made;
  while (made.light_field.points.size() < 500) {
    const Vector3d at(made.Uniform(-0.5, 0.5), made.Uniform(-0.4, 0.4), 0);
    if (at.head<2>().cwiseAbs().maxCoeff() > 0.2) made.Add(at);
  }
  EXPECT_NEAR(DepthTowards(made.light_field, 0, 0), 2, 0.02);
  made.AddPatch(400, {0, 0, -0.8}, 0.35 * kX, 0.35 * kY);
  EXPECT_NEAR(DepthTowards(made.light_field, 0, 0), 2.8, 0.03);
  EXPECT_NEAR(DepthTowards(made.light_field, 0.35, 0), 2, 0.02);
}

TEST(PlanesProxyTest, BeatsOnePlaneAndNearsTheMesh) {
  const test::SceneSpec spec{.viewpoints = test::CapViewpoints(50, 0.6, 2.0, 0.03),
                             .width = 320,
                             .height = 240,
                             .focal_px = 260,
                             .with_square = true};
  const auto scene = test::MakeScene(spec);
  LightField light_field;
  for (const SceneView& view : scene->views) {
    light_field.views.emplace_back().id = view.id;
    light_field.views.back().cam_from_world = view.cam_from_world;
  }
  light_field.points = test::PointsOfPlaneAndSquare(2000, 300);
  const auto planes = MakePlanesProxy(scene->subject, light_field);
  ASSERT_TRUE(planes->Occluder());
  const auto psnr = [&](const std::shared_ptr<const Proxy>& proxy, FieldKind field, RendererKind renderer) {
    double sum = 0;
    const auto with = WithProxy(*scene, proxy);
    const auto drawing = MakeRenderer(with, {.field = {.kind = field}, .renderer = renderer});
    for (const Vector3d& at : {Vector3d(0.15, -0.1, 1.9), {-0.4, 0.2, 1.8}, {0.1, 0.5, 1.8}}) {
      const cv::Mat truth = test::PhotographOfPlane(kCamera, Looking(at), true);
      const Rendering picture = drawing->Render(kCamera, Looking(at));
      sum += CompareImages(Srgb8FromLinear(picture.linear), truth, cv::Mat(truth.size(), CV_8U, 255)).psnr_db;
    }
    return sum / 3;
  };
  const auto plane = std::make_shared<PlaneProxy>(scene->subject);
  const auto mesh = std::make_shared<MeshProxy>(scene->subject, test::PlaneAndSquare());
  for (const FieldKind field : {FieldKind::kSubdivision, FieldKind::kLumigraph})
    for (const RendererKind renderer : {RendererKind::kGl, RendererKind::kReference}) {
      const double by_planes = psnr(planes, field, renderer);
      EXPECT_GT(by_planes, psnr(plane, field, renderer) + 2) << FieldName(field);
      EXPECT_GT(by_planes, psnr(mesh, field, renderer) - 1) << FieldName(field);
    }
  // By evidence: they are taken where the plane is not enough, and are not where it is.
  const auto points = std::make_shared<PointsProxy>(scene->subject, light_field.points);
  const auto chosen = [&](const RenderScene& from) {
    return ChooseByEvidence(from, {{.kind = FieldKind::kSubdivision}}, {plane, planes, points},
                            RendererKind::kGl);
  };
  const Choice layers = chosen(*scene);
  EXPECT_EQ(layers.proxy->Name(), "planes") << layers.why;
  test::SceneSpec flat = spec;
  flat.with_square = false;
  flat.viewpoints = test::CapViewpoints(50, 0.05, 2.0);  // from straight before it
  const Choice one = chosen(*test::MakeScene(flat));
  EXPECT_EQ(one.proxy->Name(), "plane") << one.why;
}

}  // namespace
}  // namespace ulf::planes_proxy_test
