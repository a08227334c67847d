// Tests: commands/light_field/take_back_command, commands/reports/coverage_change,
// commands/reports/geometry_report, commands/light_field/info_command, render/proxy/geometry_state.
//
// Views taken out at the desk, what that does to coverage, mesh and depth maps, and how it is said.
#include <gmock/gmock.h>
#include <sys/mount.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "commands/reports/coverage_change.h"
#include "core/base/atomic_file.h"
#include "core/base/json_text.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "render/proxy/depth_map_files.h"
#include "render/proxy/geometry_state.h"
#include "render/proxy/mesh_file.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"
#include "tests/support/own_namespaces.h"
#include "tests/support/test_paths.h"

namespace ulf::test::take_back_command_test {
namespace {
namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

nlohmann::json Json(const std::string& arguments) {
  const CommandResult result = RunUlf(arguments + " --json");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  return JsonFromText(result.output);
}

// Views with a goal, a mesh of them and a depth map each.
class AtTheDesk : public testing::Test {
 protected:
  AtTheDesk() {
    WriteLightField(dir_, {.viewpoints = CapViewpoints(24, 0.35, 2.0)}, true);
    LightFieldWriter writer = LightFieldWriter::Resume(dir_);
    writer.SetGoal({.cap_deg = {30, 30}, .share = 0.9});
    writer.Close(1);
    const LightField light_field = ReadLightField(dir_);
    std::map<int, ViewDepthMap> maps;
    for (const View& view : light_field.views)
      maps.emplace(view.id, DepthMapOfMesh(*PlaneAndSquare(), light_field.CameraOf(view).WithoutDistortion(),
                                           view.cam_from_world, 0.01));
    WriteGeometryFiles(light_field, MeshPlyBytes(*PlaneAndSquare(), OriginComments("ulf proxy", light_field)),
                       maps, FormerGeometry::kReplaced);
  }
  std::string Dir() const { return dir_.string(); }
  ScratchFolder scratch_;
  fs::path dir_ = scratch_ / "field";
};

TEST_F(AtTheDesk, TakesViewsOutAndKeepsTheirPhotographs) {
  const LightField before = ReadLightField(dir_);
  const std::string photograph = ReadWholeFile(dir_ / before.views[3].image_path);
  const CommandResult result = RunUlf("take-back " + Dir() + " 4 7");
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, AllOf(HasSubstr("taken back, kept in unposed/: views 4 and 7; 22 views left\n"),
                                   HasSubstr("covered: "), HasSubstr(" % is open again"),
                                   HasSubstr("outdated: the mesh (proxy.ply) and 2 depth maps (depth/) "),
                                   HasSubstr("'ulf proxy " + Dir() + "'")));
  const LightField after = ReadLightField(dir_);
  EXPECT_EQ(after.views.size(), 22u);
  EXPECT_THAT(after.taken_back, ElementsAre(4, 7));
  EXPECT_THAT(after.doubts, IsEmpty()) << "derived files, too";
  EXPECT_FALSE(fs::exists(dir_ / before.views[3].image_path));
  EXPECT_EQ(ReadWholeFile(dir_ / "unposed" / fs::path(before.views[3].image_path).filename()), photograph);
  EXPECT_EQ(JsonFromText(ReadWholeFile(dir_ / "transforms.json"))["frames"].size(), 22u);
  EXPECT_THAT(RunUlf("repair " + Dir()).output, HasSubstr("nothing to repair"));

  const auto json = Json("take-back " + Dir() + " 9");
  EXPECT_EQ(json["taken_back"], nlohmann::json({9}));
  EXPECT_EQ(json["views"], 21);
  EXPECT_LT(json["covered"]["after"], json["covered"]["before"]);
  EXPECT_EQ(json["outdated"], nlohmann::json({"proxy.ply", "depth"}));
  EXPECT_EQ(Json("info " + Dir())["taken_back"], 3);
}

TEST_F(AtTheDesk, NamesUnknownNumbersAndTakesNothingOut) {
  const std::string journal = ReadWholeFile(dir_ / "journal.jsonl");
  const CommandResult unknown = RunUlf("take-back " + Dir() + " 4 99");
  EXPECT_EQ(unknown.exit_code, 1);
  EXPECT_THAT(unknown.errors,
              HasSubstr("there is no view 99; there are views 1 to 24; nothing was taken back"));
  EXPECT_THAT(RunUlf("take-back " + Dir() + " 23-25").errors,
              HasSubstr("there is no view 25; there are views 1 to 24; nothing was taken back"));
  const std::pair<std::string, std::string> slips[] = {
      {"four", "'four' is not a view: give numbers, as 4, or ranges of them, as 4-7"},
      {"4-7-9", "'4-7-9' is not a view"},
      {"-3", "views are numbered from 1"},
      {"7-4", "'7-4' ends before it begins; write 4-7"},
      {"1-2000000000", "are more views than any light field has"},
      {"1-20000000000", "is not a view"}};
  for (const auto& [given, said] : slips) {
    const CommandResult slip = RunUlf("take-back " + Dir() + " " + given);
    EXPECT_EQ(slip.exit_code, 2) << given;
    EXPECT_THAT(slip.errors, HasSubstr(said));
  }
  EXPECT_EQ(ReadLightField(dir_).views.size(), 24u);
  ASSERT_EQ(RunUlf("take-back " + Dir() + " 4").exit_code, 0);
  EXPECT_THAT(RunUlf("take-back " + Dir() + " 4").errors, HasSubstr("view 4 was taken back before"));
  EXPECT_TRUE(ReadWholeFile(dir_ / "journal.jsonl").starts_with(journal)) << "lines are added alone";
}

TEST_F(AtTheDesk, WithoutViewsNothingIsMeasuredOrAdvised) {
  {
    LightFieldWriter writer = LightFieldWriter::Resume(dir_);
    const View& view = writer.Contents().views.front();
    const Eigen::Vector3d offset = view.CenterInWorld() - writer.Contents().subject->center_in_world;
    writer.SetMeasured({.goal_db = 33,
                        .frames = 9,
                        .directions = {{.direction = offset.normalized(),
                                        .nearest_view_angle = 0.01,
                                        .db = 40,
                                        .db_outside = 40,
                                        .cause = "none"}}});
    writer.Close(1);
  }
  EXPECT_EQ(Json("info " + Dir())["measured"]["directions"], 1);
  const CommandResult taken = RunUlf("take-back " + Dir() + " 1-24");
  ASSERT_EQ(taken.exit_code, 0) << taken.errors;
  const CommandResult info = RunUlf("info " + Dir());
  EXPECT_THAT(info.output, AllOf(HasSubstr("views          0\n"), Not(HasSubstr("picture quality"))));
  for (const std::string& said : {taken.output, info.output}) EXPECT_THAT(said, Not(HasSubstr("'ulf proxy")));
  const CommandResult exported = RunUlf("export colmap " + Dir() + " -o " + (scratch_ / "out").string());
  EXPECT_EQ(exported.exit_code, 1);
  EXPECT_THAT(exported.errors, HasSubstr("holds no views"));
  EXPECT_FALSE(fs::exists(scratch_ / "out"));
}

TEST_F(AtTheDesk, MeasuresOfAnotherSubjectLapse) {
  LightFieldWriter writer = LightFieldWriter::Resume(dir_);
  writer.SetMeasured({.goal_db = 33, .directions = {{.cause = "none"}}});
  writer.Close(1);
  Subject subject = *writer.Contents().subject;
  subject.center_in_world.x() += 0.01 * subject.radius;  // as a corrected map moves it
  writer.SetSubject(subject);
  EXPECT_TRUE(ReadLightField(dir_).measured);
  EXPECT_TRUE(writer.Contents().measured);
  subject.center_in_world.x() += 0.5 * subject.radius;
  writer.SetSubject(subject);
  EXPECT_FALSE(ReadLightField(dir_).measured);
  EXPECT_FALSE(writer.Contents().measured);
}

TEST_F(AtTheDesk, RangesOfViewsAreTakenOut) {
  const auto json = Json("take-back " + Dir() + " 4 7-9 8");
  EXPECT_EQ(json["taken_back"], nlohmann::json({4, 7, 8, 9}));
  EXPECT_EQ(json["views"], 20);
}

// As where the disk fails half way: the views leave together, and the next writer moves what stayed.
TEST_F(AtTheDesk, ReportsAViewThatCannotBeTakenOut) {
  const ScratchFolder elsewhere;
  if (const auto why_not = MountSmallDisk(elsewhere.path(), 1 << 20)) GTEST_SKIP() << *why_not;
  // A file that is mounted cannot be moved.
  const std::string photograph = ReadLightField(dir_).views[6].image_path,
                    file = (dir_ / photograph).string();
  ASSERT_EQ(mount(file.c_str(), file.c_str(), nullptr, MS_BIND, nullptr), 0);
  const CommandResult result = RunUlf("take-back " + Dir() + " 4 7 9");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.errors, AllOf(HasSubstr(photograph), HasSubstr("the views are taken back")));
  EXPECT_EQ(umount(file.c_str()), 0);
  EXPECT_EQ(ReadLightField(dir_).views.size(), 21u);
  EXPECT_THAT(ReadLightField(dir_).taken_back, ElementsAre(4, 7, 9));
  const CommandResult next = RunUlf("take-back " + Dir() + " 10");
  EXPECT_EQ(next.exit_code, 0) << next.errors;
  EXPECT_TRUE(fs::exists(dir_ / "unposed" / fs::path(photograph).filename()));
  EXPECT_FALSE(fs::exists(dir_ / photograph));
}

TEST_F(AtTheDesk, AFolderThatACaptureHoldsIsLeftAlone) {
  LightFieldWriter capture = LightFieldWriter::Resume(dir_);
  const CommandResult result = RunUlf("take-back " + Dir() + " 4");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.errors, HasSubstr("another process is recording"));
  EXPECT_EQ(ReadLightField(dir_).views.size(), 24u);
}

TEST_F(AtTheDesk, InfoTellsWhetherTheGeometryFits) {
  const auto fits = Json("info " + Dir())["geometry"];
  EXPECT_EQ(fits["triangles"], PlaneAndSquare()->triangles.size());
  EXPECT_EQ(fits["vertices"], PlaneAndSquare()->vertices.size());
  EXPECT_EQ(fits["made_by"], "ulf proxy");
  EXPECT_EQ(fits["views"], 24);
  EXPECT_EQ(fits["fits"], true);
  EXPECT_EQ(fits["depth_maps"], 24);
  EXPECT_EQ(fits["stale_depth_maps"], 0);
  EXPECT_TRUE(fits["problem"].is_null());
  EXPECT_THAT(RunUlf("info " + Dir()).output,
              HasSubstr("(by ulf proxy of 24 views, as they are now); 24 depth maps\n"));

  // A pose that changes, as by ulf refine.
  {
    LightFieldWriter writer = LightFieldWriter::Resume(dir_);
    Rigid3 moved = writer.Contents().views.front().cam_from_world;
    moved.translation.x() += 0.01;
    writer.UpdatePoses({{writer.Contents().views.front().id, moved}});
    writer.Close(1);
  }
  EXPECT_THAT(
      RunUlf("info " + Dir()).output,
      AllOf(HasSubstr(
                "(by ulf proxy of 24 views when views, poses or lenses were others); 23 of 24 depth maps"),
            HasSubstr("'ulf proxy " + Dir() + "' makes both anew")));
  const auto stale = Json("info " + Dir())["geometry"];
  EXPECT_EQ(stale["fits"], false);
  EXPECT_EQ(stale["stale_depth_maps"], 1);

  ASSERT_EQ(RunUlf("take-back " + Dir() + " 5").exit_code, 0);
  EXPECT_THAT(RunUlf("info " + Dir()).output,
              HasSubstr("(by ulf proxy of 24 views, where there are 23 now)"));

  // Another program's mesh, which the maps are not of; none at all.
  WriteMeshPly(dir_ / kMeshProxyFile, *PlaneAndSquare());
  const auto other = Json("info " + Dir())["geometry"];
  EXPECT_TRUE(other["made_by"].is_null());
  EXPECT_TRUE(other["fits"].is_null());
  EXPECT_THAT(other["problem"].get<std::string>(), HasSubstr("another mesh"));
  EXPECT_THAT(RunUlf("info " + Dir()).output,
              HasSubstr("the mesh is used; 'ulf proxy " + Dir() + "' makes both anew"));
  std::ofstream(dir_ / kMeshProxyFile)
      << "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
         "element face 0\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n";
  EXPECT_THAT(RunUlf("info " + Dir()).output, HasSubstr("makes it again\n"));
  EXPECT_EQ(Json("info " + Dir())["geometry"]["triangles"], 0);
  fs::remove(dir_ / kMeshProxyFile);
  EXPECT_TRUE(Json("info " + Dir())["geometry"].is_null());
  EXPECT_THAT(RunUlf("info " + Dir()).output, HasSubstr("no mesh; 'ulf proxy " + Dir() + "' makes one"));
}

// A mesh whose end is missing, one with a corner that is no vertex, and what is no mesh.
TEST_F(AtTheDesk, EveryCommandReportsAnUnreadableMesh) {
  const std::string whole = ReadWholeFile(dir_ / kMeshProxyFile);
  std::string other_corner = whole;
  other_corner.back() = '\x7f';
  for (const std::string& mesh : {whole.substr(0, whole.size() - 20), other_corner, std::string("hello")}) {
    std::ofstream(dir_ / kMeshProxyFile, std::ios::binary) << mesh;
    const std::string file = (dir_ / kMeshProxyFile).string(),
                      again = "; 'ulf proxy " + Dir() + "' makes it again";
    const CommandResult info = RunUlf("info " + Dir());
    EXPECT_THAT(info.output, AllOf(HasSubstr("geometry       " + file + ": "), HasSubstr(again),
                                   Not(HasSubstr("as they are now"))));
    const auto geometry = Json("info " + Dir())["geometry"];
    EXPECT_TRUE(geometry["fits"].is_null());
    EXPECT_EQ(geometry["triangles"], 0);
    EXPECT_THAT(geometry["problem"].get<std::string>(), HasSubstr(file));
    EXPECT_THAT(RunUlf("repair " + Dir()).output,
                AllOf(HasSubstr("found: " + file + ": "), HasSubstr(again)));
    const CommandResult drawn =
        RunUlf("render " + Dir() + " --renderer reference --width 40 -o " + (scratch_ / "a.png").string());
    EXPECT_EQ(drawn.exit_code, 0) << drawn.errors;
    EXPECT_THAT(drawn.errors, AllOf(HasSubstr(file), HasSubstr(again), Not(HasSubstr("the mesh alone"))));
    EXPECT_EQ(RunUlf("render " + Dir() + " --proxy mesh -o " + (scratch_ / "b.png").string()).exit_code, 1)
        << "it was asked for";
  }
}

TEST(CoverageChange, IsPrintedOnlyWithDifferingDecimals) {
  using commands::CoverageChange;
  const coverage::Cap cap = coverage::Cap::ParseDegrees("40x30");
  const auto text = [&](double before, double after) {
    return commands::ToText(CoverageChange{cap, before, after}, FrameSource::kCamera, "my vase");
  };
  EXPECT_THAT(
      text(0.98134, 0.98071),
      AllOf(
          HasSubstr("covered: 98.13 % of 40 x 30 degrees before, 98.07 % after: 0.06 % must be taken again"),
          HasSubstr("'ulf info \"my vase\"' says where")));
  EXPECT_THAT(text(0.98134, 0.98133), AllOf(HasSubstr("98.1 % of 40 x 30 degrees, as before"),
                                            Not(HasSubstr("again")), Not(HasSubstr("after"))));
  EXPECT_THAT(text(0.90, 0.95),
              AllOf(HasSubstr("90.0 %"), HasSubstr("95.0 % after\n"), Not(HasSubstr("again"))));
  EXPECT_THAT(text(0.95, 0.90),
              HasSubstr("95.0 % of 40 x 30 degrees before, 90.0 % after: 5.0 % must be taken again"));
}

}  // namespace
}  // namespace ulf::test::take_back_command_test
