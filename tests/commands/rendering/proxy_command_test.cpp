// Tests: commands/rendering/proxy_command, render/stereo/proxy_builder.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "core/base/atomic_file.h"
#include "core/base/json_text.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "render/proxy/mesh_file.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/render/stereo/stereo_scenes.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"
#include "tests/support/test_run.h"

namespace ulf::proxy_command_test {
namespace {

using Eigen::Vector3d;
using test::RunUlf;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

LightFieldWriter NewField(const std::filesystem::path& dir) {
  CaptureHeader header;
  header.camera = CameraModel::Pinhole(120, 90, 110);
  return LightFieldWriter::Create(dir, header);
}

// A photograph of a mottled wall at z = 3.
void AddPhotograph(const Vector3d& place, const Vector3d& looks_at, LightFieldWriter& writer) {
  const test::Patch wall{{-8, -6, 3}, {16, 0, 0}, {0, 12, 0}, test::Mottled(0.02, 1)};
  const test::Drawn drawn = test::Draw({wall}, place, looks_at);
  cv::Mat grey, colour;
  drawn.view.grey.convertTo(grey, CV_8U);
  cv::merge(std::vector<cv::Mat>(3, grey), colour);
  Frame frame;
  frame.image = {.pixels = colour, .transfer = Transfer::kSrgb};
  View view;
  view.cam_from_world = drawn.view.cam_from_world;
  writer.AddView(frame, view);
}

// Twelve photographs, seen from z = 0.
void DrawWall(const std::filesystem::path& dir, double spacing) {
  LightFieldWriter writer = NewField(dir);
  for (const Vector3d& place : test::GridViewpoints(4, 3, spacing, 0.0))
    AddPhotograph(place, {0, 0, 3}, writer);
  writer.SetSubject({{0, 0, 3}, 0.8});
  writer.Close(1.0);
}

// A walk along the wall, whose axes are parallel.
void DrawWalk(const std::filesystem::path& dir, bool with_points) {
  LightFieldWriter writer = NewField(dir);
  for (int i = 0; i < 6; ++i) AddPhotograph({0.3 * i, 0, 0}, {0.3 * i, 0, 3}, writer);
  std::vector<ScenePoint> points;
  for (int i = 0; with_points && i < 40; ++i)
    points.push_back({.position_in_world = {-0.7 + 0.075 * i, 0.1 * (i % 9 - 4), 3}});
  writer.SetPoints(points);
  writer.Close(1.0);
}

// Drawn once, copied for every test.
void WriteWall(const std::filesystem::path& dir, double spacing = 0.3) {
  static const test::ScratchFolder made;
  const std::filesystem::path wall = made / fmt::format("{}", spacing);
  if (!std::filesystem::exists(wall)) DrawWall(wall, spacing);
  std::filesystem::copy(wall, dir, std::filesystem::copy_options::recursive);
}

test::SceneSpec PlaneSeenFrom(const std::vector<Vector3d>& viewpoints) {
  return {.viewpoints = viewpoints, .width = 128, .height = 96, .focal_px = 100};
}

TEST(ProxyCommand, LeavesDepthMapsForTheSoftField) {
  const test::ScratchFolder scratch;
  const std::string dir = (scratch / "field").string();
  WriteWall(dir);
  ASSERT_EQ(RunUlf("proxy " + dir + " --no-maps").exit_code, 0);
  EXPECT_FALSE(std::filesystem::exists(scratch / "field/depth"));
  const auto refused = RunUlf("evaluate " + dir + " --proxy soft --fields soft");
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.errors, HasSubstr("ulf proxy"));
  ASSERT_EQ(RunUlf("proxy " + dir + " -o " + (scratch / "elsewhere.ply").string()).exit_code, 0);
  EXPECT_FALSE(std::filesystem::exists(scratch / "field/depth"));
  ASSERT_EQ(RunUlf("proxy " + dir).exit_code, 0);
  const auto index = JsonFromText(ReadWholeFile(scratch / "field/depth/maps.json"));
  EXPECT_EQ(index["maps"].size(), 12u);
  const auto evaluated = RunUlf("evaluate " + dir + " --proxy soft --fields soft,lumigraph --json");
  ASSERT_EQ(evaluated.exit_code, 0) << evaluated.errors;
  EXPECT_THAT(evaluated.output, HasSubstr("\"soft\""));
  const auto rendered =
      RunUlf("render " + dir + " --field soft --proxy soft --path orbit --frames 0:1/9 -o " +
             (scratch / "one.png").string());
  EXPECT_EQ(rendered.exit_code, 0) << rendered.errors;
  EXPECT_GT(cv::mean(cv::imread((scratch / "one.png").string()))[0], 20);
}

TEST(ProxyCommand, BuildsAMeshOfWhatTheViewsSee) {
  const test::ScratchFolder scratch;
  const std::string dir = (scratch / "field").string();
  WriteWall(dir);
  const std::string journal = ReadWholeFile(scratch / "field/journal.jsonl");

  const auto first = RunUlf("proxy " + dir + " --json");
  ASSERT_EQ(first.exit_code, 0) << first.errors;
  EXPECT_THAT(first.errors, Not(HasSubstr("close together")));
  const auto report = JsonFromText(first.output);
  EXPECT_EQ(report["views"], 12);
  EXPECT_EQ(report["depth_maps"], 12);
  EXPECT_GT(report["agreeing_share"], 0.8);
  EXPECT_GT(report["peak_mib"], 1);
  EXPECT_LT(report["pixel_depth_radii"], 0.3);
  const TriangleMesh mesh = ReadMeshFile(scratch / "field/proxy.ply").mesh;
  EXPECT_EQ(report["triangles"], mesh.triangles.size());
  ASSERT_GT(mesh.triangles.size(), 500u);
  double on_the_wall = 0, towards_the_cameras = 0;
  for (const Eigen::Vector3f& vertex : mesh.vertices) on_the_wall += std::abs(vertex.z() - 3) < 0.03f;
  for (const Eigen::Vector3f& normal : VertexNormals(mesh)) towards_the_cameras += normal.z() < -0.7f;
  EXPECT_GT(on_the_wall, 0.95 * static_cast<double>(mesh.vertices.size()));
  EXPECT_GT(towards_the_cameras, 0.9 * static_cast<double>(mesh.vertices.size()));

  EXPECT_EQ(ReadWholeFile(scratch / "field/journal.jsonl"), journal);
  const auto again = RunUlf("proxy " + dir + " --explain -o " + (scratch / "again.ply").string());
  ASSERT_EQ(again.exit_code, 0) << again.errors;
  EXPECT_EQ(ReadWholeFile(scratch / "again.ply"), ReadWholeFile(scratch / "field/proxy.ply"));
  EXPECT_THAT(again.output, HasSubstr("12 views, 12 of them with a depth map"));
  // A left-out corner sees past the mesh, so that either may be chosen.
  EXPECT_THAT(again.errors,
              ::testing::ContainsRegex("\n[ *] plane +[0-9.]+ dB, .*\n[ *] again.ply +[0-9.]+ dB, .*\n"));
  EXPECT_THAT(again.errors, HasSubstr("a little too well"));
}

// Masks make photographs linear; what all views mask gives no surface.
TEST(ProxyCommand, MaskedPartsGiveNoSurface) {
  const test::ScratchFolder scratch;
  const auto points = [&](const char* name, bool masked) {
    WriteWall(scratch / name);
    LightField light_field = ReadLightField(scratch / name);
    cv::Mat mask(90, 120, CV_8UC1, cv::Scalar(255));
    mask.rowRange(0, 45) = 0;
    std::filesystem::create_directories(scratch / name / "masks");
    for (View& view : light_field.views) {
      if (!masked) break;
      view.mask_path = fmt::format("masks/{}.png", view.id);
      cv::imwrite((scratch / name / view.mask_path).string(), mask);
    }
    if (masked) WriteLightField(light_field);
    const auto run = RunUlf("proxy " + (scratch / name).string() + " --json");
    EXPECT_EQ(run.exit_code, 0) << run.errors;
    return JsonOrDiscarded(run.output).value("points", 0);
  };
  const int whole = points("whole", false), half = points("half", true);
  EXPECT_GT(half, 0.2 * whole);
  EXPECT_LT(half, 0.7 * whole);
}

TEST(ProxyCommand, NamesInvalidMeshFilesAndTheRemedy) {
  const test::ScratchFolder scratch;
  WriteWall(scratch / "my wall");
  const std::string dir = "\"" + (scratch / "my wall").string() + "\"";
  const auto stl = RunUlf("proxy " + dir + " -o " + (scratch / "wall.stl").string());
  EXPECT_EQ(stl.exit_code, 2);
  EXPECT_THAT(stl.errors, HasSubstr("ending in .ply"));
  std::ofstream(scratch / "my wall/proxy.ply") << "ply\nformat ascii 1.0\nelement vertex 9\n";
  const auto render =
      RunUlf("render " + dir + " --field linear --frames 1 -o " + (scratch / "x.png").string());
  EXPECT_EQ(render.exit_code, 0) << "without the mesh: " << render.errors;
  EXPECT_THAT(render.errors, HasSubstr("ulf proxy " + dir));
  const auto asked = RunUlf("render " + dir + " --proxy mesh --frames 1 -o " + (scratch / "y.png").string());
  EXPECT_EQ(asked.exit_code, 1);
  EXPECT_THAT(asked.errors, HasSubstr("ulf proxy " + dir));
}

TEST(ProxyCommand, WorksWithoutOpenGl) {
  const test::ScratchFolder scratch;
  WriteWall(scratch / "field");
  const std::string proxy = "proxy " + (scratch / "field").string();
  const test::WithoutOpenGl here;
  const auto wanted = RunUlf(proxy + " --renderer gl");
  const auto without = RunUlf(proxy);
  EXPECT_EQ(wanted.exit_code, 1);
  EXPECT_THAT(wanted.errors, HasSubstr("or use --renderer reference"));
  EXPECT_EQ(without.exit_code, 0) << without.errors;
  EXPECT_FALSE(ReadMeshFile(scratch / "field/proxy.ply").mesh.triangles.empty());
}

TEST(ProxyCommand, SaysThatViewsStandTooCloseTogether) {
  const test::ScratchFolder scratch;
  const std::string dir = (scratch / "field").string();
  WriteWall(dir, 0.02);
  const auto result = RunUlf("proxy " + dir + " --json");
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  // At most three steps apart along the row: z^2 / (f b) over the radius.
  EXPECT_GT(JsonFromText(result.output)["pixel_depth_radii"], 9 / (110 * 0.06) / 0.8 / 1.1);
  EXPECT_THAT(result.errors, HasSubstr("stand close together"));
}

TEST(ProxyCommand, LeavesOutTestViewsAndKeepsToLimits) {
  const test::ScratchFolder scratch;
  const std::string dir = (scratch / "field").string();
  WriteWall(dir);
  const auto result = RunUlf("proxy " + dir + " --leave-out-every 4 --depth-maps 5 --triangles 600 --json");
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  const auto report = JsonFromText(result.output);
  EXPECT_EQ(report["views"], 9);
  EXPECT_EQ(report["depth_maps"], 5);
  EXPECT_LE(report["triangles"], 600);
}

std::map<std::string, std::string> BytesUnder(const std::filesystem::path& dir) {
  std::map<std::string, std::string> bytes;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(dir))
    if (entry.is_regular_file())
      bytes[entry.path().lexically_relative(dir).generic_string()] = ReadWholeFile(entry.path());
  return bytes;
}

TEST(ProxyCommand, SharesOfMapsGiveTheBytesOfOneProcess) {
  const test::ScratchFolder scratch;
  const std::string alone = (scratch / "alone").string(), shared = (scratch / "shared").string();
  const std::string maps = " --maps " + (scratch / "maps").string();
  WriteWall(alone);
  std::filesystem::copy(alone, shared, std::filesystem::copy_options::recursive);
  ASSERT_EQ(RunUlf("proxy " + alone).exit_code, 0);
  for (const char* share : {"2/3", "0/3", "2/3"})  // one of them twice, as after a kill
    ASSERT_EQ(RunUlf("proxy " + shared + maps + " --maps-of " + share).exit_code, 0) << share;
  const auto early = RunUlf("proxy " + shared + maps);
  EXPECT_EQ(early.exit_code, 1);
  EXPECT_THAT(early.errors, HasSubstr("--maps-of 1/3"));
  ASSERT_EQ(RunUlf("proxy " + shared + maps + " --maps-of 1/3").exit_code, 0);
  const auto other = RunUlf("proxy " + shared + maps + " --size 200");
  EXPECT_EQ(other.exit_code, 1);
  EXPECT_THAT(other.errors, HasSubstr("other photographs, masks, cameras, poses or options"));
  const auto fused = RunUlf("proxy " + shared + maps);
  ASSERT_EQ(fused.exit_code, 0) << fused.errors;
  EXPECT_TRUE(BytesUnder(shared) == BytesUnder(alone));
  for (const char* share : {"3/3", "1", "-1/3", "1/0", "a/b", "0/2000000000", "0/99999999999"})
    EXPECT_EQ(RunUlf("proxy " + shared + maps + " --maps-of " + share).exit_code, 2) << share;
  EXPECT_EQ(RunUlf("proxy " + shared + " --maps-of 0/1").exit_code, 2) << "without a folder";
  EXPECT_EQ(RunUlf("proxy " + shared + " --maps " + (scratch / "none").string()).exit_code, 1);
}

// Made on machines that did not see the same photographs: one was exchanged, or masked, between two shares.
TEST(ProxyCommand, SharesOfOtherPhotographsAreRefused) {
  const test::ScratchFolder scratch;
  const std::string field = (scratch / "field").string();
  WriteWall(field);
  LightField light_field = ReadLightField(field);
  const auto file = [&](std::size_t view) { return light_field.root / light_field.views[view].image_path; };
  const std::string first = ReadWholeFile(file(0)), second = ReadWholeFile(file(1));
  const auto refused = [&](const std::string& maps, const std::function<void()>& change) {
    const std::string proxy = "proxy " + field + " --maps " + (scratch / maps).string();
    EXPECT_EQ(RunUlf(proxy + " --maps-of 0/2").exit_code, 0);
    change();
    EXPECT_EQ(RunUlf(proxy + " --maps-of 1/2").exit_code, 0);
    const auto fused = RunUlf(proxy);
    EXPECT_EQ(fused.exit_code, 1) << maps;
    EXPECT_THAT(fused.errors, HasSubstr("share-0-of-2.json: was made of other photographs, masks")) << maps;
  };
  refused("exchanged", [&] {
    WriteFileAtomically(file(0), second);
    WriteFileAtomically(file(1), first);
  });
  cv::Mat mask(90, 120, CV_8UC1, cv::Scalar(255));
  const auto write_mask = [&] { cv::imwrite((light_field.root / "masks/0.png").string(), mask); };
  std::filesystem::create_directories(light_field.root / "masks");
  light_field.views[0].mask_path = "masks/0.png";
  write_mask();
  WriteLightField(light_field);
  refused("masked", [&] {
    mask.rowRange(0, 45) = 0;
    write_mask();
  });
}

TEST(ProxyCommand, SharesOfMapsStayOutOfPhotographs) {
  const test::ScratchFolder scratch;
  const std::string field = (scratch / "field").string();
  WriteWall(field);
  const auto before = BytesUnder(field);
  std::filesystem::create_directory_symlink(scratch / "field/images", scratch / "elsewhere");
  for (const std::string& maps :
       {field, field + "/images", field + "/maps", (scratch / "elsewhere").string()}) {
    const auto run = RunUlf("proxy " + field + " --maps-of 0/1 --maps " + maps);
    EXPECT_EQ(run.exit_code, 2) << maps;
    EXPECT_THAT(run.errors, HasSubstr("--maps " + maps + ": lies in the light field")) << maps;
  }
  EXPECT_TRUE(BytesUnder(field) == before);
}

TEST(ProxyCommand, TakesAMeshMadeElsewhere) {
  const test::ScratchFolder scratch;
  const std::string dir = (scratch / "field").string();
  test::WriteLightField(dir, PlaneSeenFrom({{0, 0, 2}}), true);
  std::ofstream(scratch / "square.obj")
      << "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv nan 0 0\nf 1 2 3 4\nf 1 2 5\n";
  const auto result = RunUlf("proxy " + dir + " --from " + (scratch / "square.obj").string());
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.errors, HasSubstr("dropped 1 vertex that is not finite and 1 face at it"));
  EXPECT_EQ(ReadMeshFile(scratch / "field/proxy.ply").mesh.triangles.size(), 2u);

  std::ofstream(scratch / "triangle.obj") << "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n";
  const auto again = RunUlf("proxy " + dir + " --from " + (scratch / "triangle.obj").string());
  ASSERT_EQ(again.exit_code, 0) << again.errors;
  EXPECT_THAT(again.errors, HasSubstr("it is kept as"));
  EXPECT_EQ(ReadMeshFile(scratch / "field/proxy.ply").mesh.triangles.size(), 1u);
  EXPECT_EQ(ReadMeshFile(scratch / "field/kept/proxy.ply").mesh.triangles.size(), 2u)
      << "ulf cannot make it again";
}

TEST(ProxyCommand, TakesTheMiddleOfPointsForASubject) {
  const test::ScratchFolder scratch;
  DrawWalk(scratch / "bare", false);
  const auto refused = RunUlf("proxy " + (scratch / "bare").string());
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.errors, HasSubstr("--subject x,y,z,radius"));
  DrawWalk(scratch / "walk", true);
  const std::string dir = (scratch / "walk").string();
  const auto splats =
      RunUlf("export splat --most 20000 --json " + dir + " -o " + (scratch / "walk.ply").string());
  ASSERT_EQ(splats.exit_code, 0) << splats.errors;
  EXPECT_THAT(splats.errors, HasSubstr("ulf proxy"));
  EXPECT_FALSE(std::filesystem::exists(scratch / "walk/proxy.ply")) << "an export changes nothing";
  EXPECT_GT(JsonFromText(splats.output)["psnr_db"], 15);
  const auto made = RunUlf("proxy " + dir + " --json");
  ASSERT_EQ(made.exit_code, 0) << made.errors;
  EXPECT_GT(JsonFromText(made.output)["agreeing_share"], 0.7);
  const TriangleMesh mesh = ReadMeshFile(scratch / "walk/proxy.ply").mesh;
  double on_the_wall = 0;
  for (const Eigen::Vector3f& vertex : mesh.vertices) on_the_wall += std::abs(vertex.z() - 3) < 0.05f;
  EXPECT_GT(on_the_wall, 0.9 * static_cast<double>(mesh.vertices.size()));
}

// A rolling ground of 2 side² triangles.
void WriteGround(const std::string& file, std::uint32_t side) {
  TriangleMesh ground;
  for (std::uint32_t y = 0; y <= side; ++y)
    for (std::uint32_t x = 0; x <= side; ++x) {
      const float scale = 1 / static_cast<float>(side);
      const float u = static_cast<float>(x) * scale - 0.5f, v = static_cast<float>(y) * scale - 0.5f;
      ground.vertices.emplace_back(u, v, 0.05f * std::sin(20 * u) * std::cos(15 * v));
      if (x == side || y == side) continue;
      const std::uint32_t at = y * (side + 1) + x;
      ground.triangles.push_back({at, at + 1, at + side + 1});
      ground.triangles.push_back({at + 1, at + side + 2, at + side + 1});
    }
  WriteMeshPly(file, ground);
}

constexpr std::uint32_t kMoreThanShown = 708;

// A light field of one view, and a mesh of another program.
struct FieldAndGround {
  explicit FieldAndGround(std::uint32_t side) {
    test::WriteLightField(dir, PlaneSeenFrom({{0, 0, 2}}), true);
    WriteGround(file, side);
  }
  test::ScratchFolder scratch;
  std::string dir = (scratch / "field").string(), file = (scratch / "fine.ply").string();
};

TEST(ProxyCommand, TakesAsManyTrianglesAsPicturesShow) {
  const FieldAndGround made(kMoreThanShown);
  const auto coarser = RunUlf("proxy " + made.dir + " --from " + made.file);
  ASSERT_EQ(coarser.exit_code, 0) << coarser.errors;
  EXPECT_THAT(coarser.errors, HasSubstr("fine.ply: made coarser from 1002528 triangles to "));
  const std::size_t kept = ReadMeshFile(made.scratch / "field/proxy.ply").mesh.triangles.size();
  EXPECT_LE(kept, 1000000u);
  EXPECT_GT(kept, 500000u);
}

TEST(ProxyCommand, TakesAsManyTrianglesAsAsked) {
  const FieldAndGround made(100);
  const auto asked = RunUlf("proxy " + made.dir + " --from " + made.file + " --triangles 5000");
  ASSERT_EQ(asked.exit_code, 0) << asked.errors;
  EXPECT_THAT(asked.errors,
              AllOf(HasSubstr("from 20000 triangles to "), HasSubstr("as asked (--triangles)")));
  const std::size_t kept = ReadMeshFile(made.scratch / "field/proxy.ply").mesh.triangles.size();
  EXPECT_LE(kept, 5000u);
  EXPECT_GT(kept, 2500u);
}

TEST(ProxyCommand, RendersAFinerMeshMadeCoarser) {
  const FieldAndGround made(kMoreThanShown);
  const auto shown =
      RunUlf("render " + made.dir + " --proxy " + made.file + " --field nearest --renderer reference -o " +
             (made.scratch / "one.png").string());
  ASSERT_EQ(shown.exit_code, 0) << shown.errors;
  EXPECT_THAT(shown.errors, AllOf(HasSubstr("fine.ply: made coarser, to "), HasSubstr("ulf proxy ")));
}

TEST(ProxyCommand, SaysWhatIsMissing) {
  const test::ScratchFolder scratch;
  const auto field = [&](const std::string& name, const std::vector<Vector3d>& viewpoints, bool subject) {
    test::WriteLightField(scratch / name, PlaneSeenFrom(viewpoints), subject);
    return (scratch / name).string();
  };
  struct Case {
    std::string arguments;
    int exit_code;
    std::string says;
  };
  const std::string one = field("one", {{0, 0, 2}}, true);
  const std::string place = field("place", {{0, 0, 2}, {0, 0, 2}, {0, 0, 2}}, true);
  const std::string grid = field("grid", test::GridViewpoints(2, 2, 0.25, 2.0), true);
  for (const Case& c : {
           Case{one, 1, "at least two views"},
           Case{field("no_subject", {{0, 0, 2}}, false), 1, "at least two views"},
           Case{place, 1, "move the camera sideways"},
           Case{grid + " --leave-out-every 2 --subject 0,0,0", 2, "x,y,z,radius"},
           Case{grid + " --subject 0,0,-900,1", 1, "Where the subject is elsewhere, give its place"},
           Case{grid + " --from " + (scratch / "none.ply").string(), 1, "none.ply"},
           Case{grid + " -o " + (scratch / "none/mesh.ply").string(), 2, "none"},
           Case{(scratch / "nowhere").string(), 1, "nowhere"},
       }) {
    const auto result = RunUlf("proxy " + c.arguments);
    EXPECT_EQ(result.exit_code, c.exit_code) << c.arguments << "\n" << result.output << result.errors;
    EXPECT_THAT(result.errors, HasSubstr(c.says)) << c.arguments;
  }
  EXPECT_FALSE(std::filesystem::exists(scratch / "grid/proxy.ply"));
}

}  // namespace
}  // namespace ulf::proxy_command_test
