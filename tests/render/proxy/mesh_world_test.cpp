// Tests: render/proxy/mesh_world, render/proxy/proxy_choice, commands/options/mesh_option.
#include "render/proxy/mesh_world.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <functional>
#include <random>
#include <sstream>

#include "core/base/error.h"
#include "render/proxy/depth_raster.h"
#include "render/proxy/mesh_file.h"
#include "render/proxy/mesh_resolution.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/test_paths.h"

namespace ulf::mesh_world_test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using testing::AllOf;
using testing::HasSubstr;

// Rolling ground with a few hills of different widths, some 2 by 2 units: no turn takes it into itself.
TriangleMesh Ground(unsigned seed, int cells = 60) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> any(-1, 1);
  struct Hill {
    double x, y, height, width;
  };
  std::vector<Hill> hills;
  for (int i = 0; i < 7; ++i)
    hills.push_back({0.8 * any(random), 0.8 * any(random), 0.15 + 0.3 * std::abs(any(random)),
                     0.1 + 0.15 * std::abs(any(random))});
  TriangleMesh mesh;
  const auto side = static_cast<std::uint32_t>(cells + 1);
  for (std::uint32_t r = 0; r < side; ++r)
    for (std::uint32_t c = 0; c < side; ++c) {
      const double x = 2.0 * c / cells - 1, y = 2.0 * r / cells - 1;
      double z = 0.2 * x;
      for (const Hill& hill : hills)
        z += hill.height *
             std::exp(-(std::pow(x - hill.x, 2) + std::pow(y - hill.y, 2)) / std::pow(hill.width, 2));
      mesh.vertices.emplace_back(Vector3d(x, y, z).cast<float>());
      if (r + 1 == side || c + 1 == side) continue;
      const std::uint32_t at = r * side + c;
      mesh.triangles.push_back({at, at + 1, at + side});
      mesh.triangles.push_back({at + 1, at + side + 1, at + side});
    }
  return mesh;
}

// Views around the ground, with points on it that they see; `tracks`: the points know who sees them.
LightField FieldOver(const TriangleMesh& ground, unsigned seed, bool tracks) {
  LightField field;
  field.root = "ground";
  field.cameras = {CameraModel::Pinhole(160, 120, 130)};
  const Vector3d away(0.3, 0.2, 0.1);  // the world's origin is beside the middle
  for (const Vector3d& viewpoint : test::CapViewpoints(9, 0.6, 3, 0.1, seed)) {
    View& view = field.views.emplace_back();
    view.id = static_cast<int>(field.views.size());
    view.cam_from_world = LookAt(viewpoint + away, away, Vector3d::UnitY());
  }
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, 0.003);
  std::vector<cv::Mat> depths;
  for (const View& view : field.views)
    depths.push_back(DrawInverseDepth(ground, field.cameras[0], view.cam_from_world));
  for (int i = 0; i < 400; ++i) {
    ScenePoint point;
    point.position_in_world = ground.vertices[random() % ground.vertices.size()].cast<double>();
    std::vector<ViewObservation> seen;
    for (std::size_t v = 0; v < field.views.size(); ++v) {
      const Vector3d in_cam = field.views[v].cam_from_world * point.position_in_world;
      const auto img = field.cameras[0].ImgFromCam(in_cam);
      if (img && field.cameras[0].Contains(*img) &&
          depths[v].at<float>(static_cast<int>(img->y()), static_cast<int>(img->x())) * in_cam.z() < 1.02)
        seen.push_back({field.views[v].id, *img});
    }
    if (seen.size() < 2) continue;
    if (tracks) point.track = seen;
    point.position_in_world += Vector3d(noise(random), noise(random), noise(random));
    field.points.push_back(point);
  }
  return field;
}

TriangleMesh Changed(TriangleMesh mesh, const std::function<Vector3d(const Vector3d&)>& change) {
  for (Eigen::Vector3f& vertex : mesh.vertices) vertex = change(vertex.cast<double>()).cast<float>();
  return mesh;
}

// Triangles with a corner of which this holds.
TriangleMesh PartOf(TriangleMesh mesh, const std::function<bool(const Eigen::Vector3f&)>& holds) {
  std::erase_if(mesh.triangles, [&](const auto& corners) { return !holds(mesh.vertices[corners[0]]); });
  return mesh;
}

std::string Misfit(const TriangleMesh& mesh, const LightField& field) {
  try {
    RequireMeshOfWorld("hills.ply", mesh, field);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(MeshWorld, ARightMeshPassesEvenIfPartialOrRough) {
  for (const unsigned seed : {2u, 4u})
    for (const bool tracks : {true, false}) {
      const TriangleMesh ground = Ground(seed);
      const LightField field = FieldOver(ground, seed, tracks);
      ASSERT_GT(field.points.size(), 200u);
      EXPECT_EQ(Misfit(ground, field), "") << seed << tracks;
      EXPECT_EQ(Misfit(PartOf(ground, [](const Eigen::Vector3f& at) { return at.x() < -0.6; }), field), "")
          << seed;
      EXPECT_EQ(
          Misfit(PartOf(ground, [](const Eigen::Vector3f& at) { return at.head<2>().norm() < 0.25; }), field),
          "")
          << seed;
      EXPECT_EQ(Misfit(Simplified(ground, 60), field), "") << seed;
      EXPECT_EQ(
          Misfit(Changed(ground, [](const Vector3d& at) { return Vector3d(at + 0.03 * Vector3d::UnitZ()); }),
                 field),
          "")
          << "a little off";
    }
}

// One of each kind; the long cases below have all.
TEST(MeshWorld, NamesTheMoveThatWouldFit) {
  const TriangleMesh ground = Ground(6);
  const LightField field = FieldOver(ground, 6, true);
  EXPECT_THAT(Misfit(Changed(ground,
                             [](const Vector3d& at) {
                               return Vector3d(1000 * at.x(), -1000 * at.z(), 1000 * at.y());
                             }),
                     field),
              AllOf(HasSubstr("hills.ply: is in another world than ground"),
                    HasSubstr("x, z, -y in place of x, y, z and lengths times 0.001")));
  EXPECT_THAT(
      Misfit(Changed(ground, [](const Vector3d& at) { return Vector3d(at + Vector3d(4, -7, 2.5)); }), field),
      HasSubstr("it would fit with moved by -"));
}

TEST(MeshWorld, NamesEveryUnitThatWouldFit) {
  const TriangleMesh ground = Ground(2);
  const LightField field = FieldOver(ground, 2, true);
  struct {
    double times;
    const char* words;
  } const units[] = {{1000, "lengths times 0.001"},        {0.001, "lengths times 1000"},
                     {100, "lengths times 0.01"},          {0.01, "lengths times 100"},
                     {1 / 0.0254, "lengths times 0.0254"}, {1 / 0.3048, "lengths times 0.3048"}};
  for (const auto& unit : units)
    EXPECT_THAT(Misfit(Changed(ground, [&](const Vector3d& at) { return Vector3d(unit.times * at); }), field),
                AllOf(HasSubstr("hills.ply: is in another world than ground"), HasSubstr(unit.words)))
        << unit.times;
}

TEST(MeshWorld, NamesAllAxesThatWouldFit) {
  const TriangleMesh ground = Ground(4);
  const LightField field = FieldOver(ground, 4, false);
  struct {
    Matrix3d mesh_from_world;
    const char* words;
  } const cases[] = {
      {(Matrix3d() << 1, 0, 0, 0, 0, 1, 0, -1, 0).finished(),
       "x, -z, y in place of x, y, z"},  // z up to y up
      {(Matrix3d() << 1, 0, 0, 0, 0, -1, 0, 1, 0).finished(), "x, z, -y in place of x, y, z"},
      {(Matrix3d() << -1, 0, 0, 0, -1, 0, 0, 0, 1).finished(), "-x, -y, z in place"},
      {(Matrix3d() << 1, 0, 0, 0, -1, 0, 0, 0, -1).finished(), "x, -y, -z in place"},  // OpenGL's axes
      {(Matrix3d() << 0, 1, 0, 0, 0, 1, 1, 0, 0).finished(), "z, x, y in place"},
      {(Matrix3d() << 1, 0, 0, 0, 1, 0, 0, 0, -1).finished(),
       "x, y, -z in place of x, y, z (it is mirrored)"}};
  for (const auto& one : cases)
    EXPECT_THAT(
        Misfit(Changed(ground, [&](const Vector3d& at) { return Vector3d(one.mesh_from_world * at); }),
               field),
        HasSubstr(one.words));
  EXPECT_THAT(
      Misfit(
          Changed(ground, [&](const Vector3d& at) { return Vector3d(1000 * cases[0].mesh_from_world * at); }),
          field),
      AllOf(HasSubstr(cases[0].words), HasSubstr("lengths times 0.001")));
}

TEST(MeshWorld, NamesEveryShiftThatWouldFit) {
  for (const unsigned seed : {2u, 6u}) {
    const TriangleMesh ground = Ground(seed);
    const LightField field = FieldOver(ground, seed, true);
    const auto moved = [&](const Vector3d& by) {
      return Misfit(Changed(ground, [&](const Vector3d& at) { return Vector3d(at + by); }), field);
    };
    EXPECT_THAT(moved({4, -7, 2.5}), HasSubstr("it would fit with moved by -")) << seed;
    EXPECT_THAT(moved({4512, -7000, 250}), HasSubstr("it would fit with moved by -45")) << seed;
    EXPECT_THAT(moved({0, 0, 0.7}), HasSubstr("would fit with moved by")) << seed;
  }
}

TEST(MeshWorld, SaysThatNothingFitsForAnotherScene) {
  const LightField field = FieldOver(Ground(2), 2, true);
  std::mt19937 random(5);
  std::uniform_real_distribution<float> any(-1, 1);
  TriangleMesh crumpled = Ground(8, 12);
  for (Eigen::Vector3f& vertex : crumpled.vertices)
    vertex = 1.2f * Eigen::Vector3f(any(random), any(random), any(random));
  EXPECT_THAT(Misfit(crumpled, field), HasSubstr("no exchange of its axes, usual unit of length or shift"));
}

TEST(MeshWorld, FewPointsTellNothingAndThatIsSaid) {
  const TriangleMesh ground = Ground(2);
  LightField field = FieldOver(ground, 2, true);
  field.points.resize(3);
  std::ostringstream said;
  const auto logger = spdlog::default_logger();
  spdlog::set_default_logger(
      std::make_shared<spdlog::logger>("said", std::make_shared<spdlog::sinks::ostream_sink_mt>(said)));
  EXPECT_EQ(Misfit(Changed(ground, [](const Vector3d& at) { return Vector3d(1000 * at); }), field), "");
  spdlog::set_default_logger(logger);
  EXPECT_THAT(said.str(), HasSubstr("too few (fewer than 50): whether it is in the world of"));
}

// Commands refuse it, with points of the light field or, where it has none, of its photographs.
TEST(MeshWorld, CommandsRefuseAForeignMesh) {
  const test::ScratchFolder scratch;
  const std::string dir = (scratch / "field").string(), mesh = (scratch / "mesh.ply").string();
  test::SceneSpec spec{.viewpoints = test::CapViewpoints(8, 0.25, 1.5, 0.05, 3), .width = 320, .height = 240};
  spec.focal_px = 270;
  spec.with_square = true;
  test::WriteLightField(dir, spec, true);
  // Millimetres, and z up.
  WriteMeshPly(mesh, Changed(*test::PlaneAndSquare(), [](const Vector3d& at) {
                 return Vector3d(1000 * at.x(), -1000 * at.z(), 1000 * at.y());
               }));
  const std::string out = (scratch / "out").string();
  for (const std::string& arguments :
       {"render " + dir + " --proxy " + mesh + " --path orbit -o " + out + ".mp4",
        "proxy " + dir + " --from " + mesh, "export gltf " + dir + " --mesh " + mesh + " -o " + out,
        "evaluate " + dir + " --proxy " + mesh}) {
    const test::CommandResult told = test::RunUlf(arguments);
    EXPECT_EQ(told.exit_code, 1) << arguments << told.errors;
    EXPECT_THAT(told.errors, HasSubstr("is in another world than " + dir)) << arguments;
    EXPECT_FALSE(std::filesystem::exists(out)) << arguments;
    EXPECT_FALSE(std::filesystem::exists(scratch / "field/proxy.ply")) << arguments;
  }
  WriteMeshPly(mesh, *test::PlaneAndSquare());
  const test::CommandResult right = test::RunUlf("proxy " + dir + " --from " + mesh);
  EXPECT_EQ(right.exit_code, 0) << right.errors;
}

}  // namespace
}  // namespace ulf::mesh_world_test
