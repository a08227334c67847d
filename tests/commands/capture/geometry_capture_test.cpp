// Tests: coverage/session/record/live_geometry, coverage/session/record/capture_record,
// coverage/session/record/geometry_files, commands/capture/capture_report.
//
// ulf capture leaves a mesh and the depth maps of views beside it, or says why there are none; a light field
// is complete without.
#include <gmock/gmock.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <regex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "acquisition/simulator/scene/scene.h"
#include "acquisition/simulator/simulated_camera.h"
#include "core/base/atomic_file.h"
#include "core/base/device_uri.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/base/quantile.h"
#include "core/geometry/similarity3.h"
#include "core/light_field/folder/light_field_io.h"
#include "coverage/session/record/geometry_files.h"
#include "render/proxy/depth_map_files.h"
#include "render/proxy/geometry_state.h"
#include "render/proxy/mesh_file.h"
#include "render/proxy/proxy_choice.h"
#include "tests/support/child_process.h"
#include "tests/support/floors.h"
#include "tests/support/own_namespaces.h"
#include "tests/support/test_paths.h"
#include "tests/support/test_run.h"

namespace ulf::geometry_capture_test {
namespace {

namespace fs = std::filesystem;
using test::CommandResult;
using test::RunUlf;
using test::ScratchFolder;
using testing::HasSubstr;

// A light field of a small cap in the simulator's world.
CommandResult Capture(const fs::path& dir, const std::string& more) {
  return RunUlf(
      "capture 'sim:studio?width=320&height=240&look_away=0&row_deg=5&speed_deg_s=25' --headless --poses "
      "known "
      "--subject 0,0,0.07,0.162 --quality fast --json -o " +
      dir.string() + " " + more);
}

std::map<std::string, std::string> FilesIn(const fs::path& folder) {
  std::map<std::string, std::string> files;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder, none))
    files[entry.path().filename().string()] = ReadWholeFile(entry.path());
  return files;
}

DepthMapReading MapsOf(const fs::path& dir) {
  return ReadDepthMaps(dir, ReadLightField(dir),
                       std::make_shared<TriangleMesh>(ReadMeshFile(dir / "proxy.ply").mesh));
}

// Of the subject, by blending field and proxy.
std::map<std::pair<std::string, std::string>, double> SubjectDb(const fs::path& dir,
                                                                const std::string& what) {
  const CommandResult evaluated = RunUlf("evaluate " + dir.string() + " --every 16 --json " + what);
  EXPECT_EQ(evaluated.exit_code, 0) << evaluated.errors;
  std::map<std::pair<std::string, std::string>, double> db;
  const auto report = JsonFromText(evaluated.output);
  for (const auto& row : report["results"])
    db[{row["field"].get<std::string>(), row["proxy"].get<std::string>()}] =
        row["all"]["psnr_disc_db"].get<double>();
  return db;
}

// Of the depths along the map's rays, as the scene has them.
std::vector<double> DepthErrors(const ViewDepthMap& map, const Rigid3& cam_from_world, const Scene& scene,
                                const Similarity3& scene_from_world) {
  std::vector<double> errors;
  const Eigen::Vector3d origin = scene_from_world * cam_from_world.OriginInSource();
  for (int y = 5; y < map.camera.height - 5; y += 5)
    for (int x = 5; x < map.camera.width - 5; x += 5) {
      const Eigen::Vector3d ray = map.camera.RayFromImg({x + 0.5, y + 0.5})->normalized();
      const double depth =
          scene.DepthAlong(origin, scene_from_world.rotation * cam_from_world.DirectionInSource(ray)) *
          ray.z();
      errors.push_back(std::abs(map.InverseDepthAt(x, y) * depth / scene_from_world.scale - 1));
    }
  return errors;
}

TEST(GeometryCapture, MeshAndMapsAreReadyAtTheEnd) {
  const ScratchFolder scratch;
  const fs::path dir = scratch / "lf";
  const CommandResult run = Capture(dir, "--until-covered 20x14");
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  const auto json = JsonFromText(run.output);
  EXPECT_GE(json["geometry"]["maps"], 4);
  const MeshReading mesh = ReadMeshFile(dir / "proxy.ply");
  EXPECT_EQ(mesh.mesh.triangles.size(), json["geometry"]["triangles"]);
  EXPECT_GT(mesh.mesh.triangles.size(), 5000u);
  // The camera's poses are known: its world is the simulator's.
  const DepthMapReading reading = MapsOf(dir);
  EXPECT_EQ(reading.stale, 0u);
  ASSERT_GE(reading.maps.size(), 4u);
  EXPECT_EQ(reading.maps.size(), json["geometry"]["maps"]);
  EXPECT_EQ(reading.maps.size(), json["geometry"]["written_maps"]);
  const auto scene = Scene::Named("studio");
  for (const View& view : ReadLightField(dir).views) {
    const auto found = reading.maps.find(view.id);
    if (found == reading.maps.end()) continue;
    const std::vector<double> errors =
        DepthErrors(found->second->Get(), view.cam_from_world, *scene, Similarity3());
    EXPECT_LT(Quantile(errors, 0.5), 0.005) << view.id;
    EXPECT_LT(Quantile(errors, 0.8), 0.05) << view.id;
  }
  // The mesh serves a rendering at once.
  const CommandResult evaluated =
      RunUlf("evaluate " + dir.string() + " --every 6 --fields lumigraph --proxy plane --proxy mesh --json");
  ASSERT_EQ(evaluated.exit_code, 0) << evaluated.errors;
  const auto rows = JsonFromText(evaluated.output)["results"];
  ASSERT_EQ(rows.size(), 2u) << evaluated.output;
  const auto psnr_db = [&](int row) { return rows[row]["all"]["psnr_db"].get<double>(); };
  EXPECT_GT(psnr_db(1), psnr_db(0) + 3) << "mesh, plane";
}

// The tracker's poses, which are corrected to the end.
TEST(GeometryCapture, SoftFieldTakesMapsOfCorrectedPoses) {
  const ScratchFolder scratch;
  const fs::path dir = scratch / "lf";
  const std::string device = "sim:studio?width=320&height=240&look_away=0";
  const CommandResult run =
      RunUlf("capture '" + device + "' --headless --quality fast --frames 120 -o " + dir.string());
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  std::smatch counts;
  ASSERT_TRUE(std::regex_search(run.output, counts,
                                std::regex("of ([0-9]+) depth maps, .*: proxy.ply, ([0-9]+) in depth/\n")))
      << run.output;
  EXPECT_EQ(counts[1], counts[2]) << "none was made under poses that are not the light field's";
  EXPECT_THAT(ReadWholeFile(dir / "journal.jsonl"), HasSubstr("pose_update"));
  const DepthMapReading reading = MapsOf(dir);
  EXPECT_EQ(reading.stale, 0u);
  ASSERT_GE(reading.maps.size(), 4u);
  EXPECT_EQ(std::to_string(reading.maps.size()), counts[2]);
  const LightField light_field = ReadLightField(dir);
  const acquisition::SimulatedCamera camera(
      acquisition::SimulationOptions::FromUri(DeviceUri::Parse(device)));
  std::vector<Eigen::Vector3d> recorded, truth;
  for (const View& view : light_field.views) {
    recorded.push_back(view.cam_from_world.OriginInSource());
    truth.push_back(camera.hand().CamFromWorld(view.device_time_s).OriginInSource());
  }
  const auto scene_from_world = AlignPoints(recorded, truth);
  ASSERT_TRUE(scene_from_world);
  std::vector<double> errors;
  for (const View& view : light_field.views)
    if (const auto found = reading.maps.find(view.id); found != reading.maps.end())
      for (const double error :
           DepthErrors(found->second->Get(), view.cam_from_world, camera.scene(), *scene_from_world))
        errors.push_back(error);
  EXPECT_LT(Quantile(errors, 0.5), 0.006);
  EXPECT_LT(Quantile(errors, 0.8), 0.02);
  auto db = SubjectDb(dir, "--fields soft --proxy mesh --proxy soft");
  ASSERT_TRUE((db.contains({"soft", "soft"}) && db.contains({"soft", "mesh"})));
  EXPECT_GT((db[{"soft", "soft"}]), (db[{"soft", "mesh"}]) - 0.05);
}

TEST(GeometryCapture, NoGeometryMakesNone) {
  const ScratchFolder scratch;
  const CommandResult run = Capture(scratch / "lf", "--frames 60 --no-geometry");
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_TRUE(JsonFromText(run.output)["geometry"].is_null());
  EXPECT_FALSE(fs::exists(scratch / "lf" / "proxy.ply"));
  EXPECT_FALSE(fs::exists(scratch / "lf" / "depth"));
}

TEST(GeometryCapture, OlderMeshIsKept) {
  const ScratchFolder scratch;
  const fs::path dir = scratch / "lf";
  ASSERT_EQ(Capture(dir, "--frames 30 --no-geometry").exit_code, 0);
  std::ofstream(dir / "proxy.ply") << "of another program";
  const CommandResult run = Capture(dir, "--resume --frames 60");
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_EQ(ReadWholeFile(dir / "kept" / "proxy.ply"), "of another program");
  EXPECT_THAT(run.errors, HasSubstr("kept"));
  EXPECT_FALSE(ReadMeshFile(dir / "proxy.ply").mesh.triangles.empty()) << "earlier views and new ones";
}

TEST(GeometryCapture, ResumedCaptureRenewsTheDepthMaps) {
  const ScratchFolder scratch;
  const fs::path dir = scratch / "lf";
  ASSERT_EQ(Capture(dir, "--frames 30 --deterministic").exit_code, 0);
  const std::size_t before = MapsOf(dir).maps.size();
  const std::string index = ReadWholeFile(dir / "depth" / "maps.json"),
                    mesh = ReadWholeFile(dir / "proxy.ply");
  const auto files = FilesIn(dir / "depth");
  ASSERT_GE(before, 2u);
  const CommandResult run = Capture(dir, "--resume --frames 45 --deterministic");
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  const DepthMapReading reading = MapsOf(dir);
  EXPECT_EQ(reading.stale, 0u);
  EXPECT_GT(reading.maps.size(), before) << "earlier views and new ones";
  EXPECT_EQ(reading.maps.size(), JsonFromText(run.output)["geometry"]["written_maps"]);
  EXPECT_EQ(FilesIn(dir / "depth").size(), reading.maps.size() + 1) << "no old ones beside them";
  EXPECT_TRUE(ReadWholeFile(dir / "kept" / "proxy.ply") == mesh);
  EXPECT_TRUE(FilesIn(dir / "kept" / "depth") == files) << "they may be finer ones, as the mesh";
  EXPECT_THAT(run.errors,
              ::testing::ContainsRegex("views were added: a new mesh of [0-9]+ triangles, .*the one that "
                                       "was there \\([0-9]+ triangles\\), which is kept: "));
  EXPECT_THAT(run.errors, HasSubstr((dir / "kept/proxy.ply").string() + ", with its depth maps: " +
                                    (dir / "kept/depth").string() + "; 'ulf proxy " + dir.string() + "'"));

  // Killed between the new mesh and the new index: what is there then does not count.
  std::ofstream(dir / "depth" / "maps.json") << index;
  EXPECT_THROW(MapsOf(dir), ulf::Error);
  EXPECT_EQ(OwnProxy("soft", *ReadLightField(dir).subject, dir)->Name(), "mesh");
}

// A session that records nothing leaves the mesh alone, which may be a finer one.
TEST(GeometryCapture, MeshOfTheSameViewsStays) {
  const ScratchFolder scratch;
  const fs::path dir = scratch / "lf";
  ASSERT_EQ(Capture(dir, "--frames 60").exit_code, 0);
  const std::size_t views = ReadLightField(dir).views.size();
  const auto maps = FilesIn(dir / "depth");
  render::WriteMeshPly(dir / "proxy.ply", {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}});
  const std::string finer = ReadWholeFile(dir / "proxy.ply");
  const CommandResult run = Capture(dir, "--resume --frames 1");
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  ASSERT_EQ(ReadLightField(dir).views.size(), views);
  EXPECT_EQ(ReadWholeFile(dir / "proxy.ply"), finer);
  EXPECT_TRUE(FilesIn(dir / "depth") == maps);
  EXPECT_FALSE(fs::exists(dir / "kept" / "proxy.ply"));
  EXPECT_THAT(run.errors, HasSubstr("the mesh that is there stays"));
  EXPECT_TRUE(JsonFromText(run.output)["geometry"].is_null());

  // As where a session was killed after it had added views.
  LightField fewer = ReadLightField(dir);
  fewer.views.pop_back();
  render::WriteMeshPly(dir / "proxy.ply", {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}},
                       render::OriginComments("ulf capture", fewer));
  EXPECT_THAT(Capture(dir, "--resume --frames 1").errors, HasSubstr("though it is not of the views"));
  std::ofstream(dir / "proxy.ply") << "no mesh";
  EXPECT_THAT(Capture(dir, "--resume --frames 1").errors,
              HasSubstr("the one that is there cannot be used: " + (dir / "proxy.ply").string()));
  std::ofstream(dir / "proxy.ply") << finer;

  // A view that is taken back is no new one.
  std::ofstream(scratch / "requests.txt") << "take-back views 1\n";
  const CommandResult less =
      Capture(dir, "--resume --frames 1 --requests " + (scratch / "requests.txt").string());
  ASSERT_EQ(less.exit_code, 0) << less.errors;
  ASSERT_EQ(ReadLightField(dir).views.size(), views - 1) << less.errors;
  EXPECT_TRUE(ReadWholeFile(dir / "proxy.ply") == finer);
  EXPECT_THAT(
      less.errors,
      HasSubstr("no view was added: the mesh that is there stays, though it is not of the views as they are "
                "now; 'ulf proxy " +
                dir.string() + "'"));
}

// What `dir` has, as if a capture had made it just now.
coverage::FinishedGeometry AsFinished(const fs::path& dir) {
  coverage::FinishedGeometry finished;
  const auto mesh = std::make_shared<coverage::LiveMesh>();
  mesh->mesh = std::make_shared<TriangleMesh>(ReadMeshFile(dir / "proxy.ply").mesh);
  finished.mesh = mesh;
  const DepthMapReading maps = MapsOf(dir);
  for (const View& view : ReadLightField(dir).views)
    if (const auto map = maps.maps.find(view.id); map != maps.maps.end()) {
      finished.maps_for_rendering[view.id] = map->second->Get();
      finished.map_poses[view.id] = view.cam_from_world;
    }
  return finished;
}

TEST(GeometryCapture, FinerMeshStaysUntilANewOneIsAsGood) {
  const ScratchFolder scratch;
  const fs::path dir = scratch / "lf";
  ASSERT_EQ(Capture(dir, "--frames 45 --deterministic").exit_code, 0);
  const coverage::FinishedGeometry same = AsFinished(dir);
  const std::size_t maps = same.maps_for_rendering.size();
  ASSERT_GE(maps, 3u);
  EXPECT_EQ(coverage::WhyExistingIsBetter(dir, same), "");

  coverage::FinishedGeometry fewer = same;
  fewer.maps_for_rendering.erase(fewer.maps_for_rendering.begin());
  EXPECT_THAT(coverage::WhyExistingIsBetter(dir, fewer),
              HasSubstr(std::to_string(maps) + " depth maps of 320 px, and a new one would have " +
                        std::to_string(maps - 1) + " of 320 px"));

  coverage::FinishedGeometry coarser = same;
  for (auto& [id, map] : coarser.maps_for_rendering) {
    map.camera = map.camera.ScaledTo(160, 120);
    cv::resize(map.inverse_depth, map.inverse_depth, {160, 120}, 0, 0, cv::INTER_NEAREST);
  }
  EXPECT_THAT(coverage::WhyExistingIsBetter(dir, coarser), HasSubstr("of 160 px"));

  // As many maps, all of one side of the subject.
  coverage::FinishedGeometry elsewhere = same;
  const auto& map = same.maps_for_rendering.begin()->second;
  for (int id = 1001; elsewhere.maps_for_rendering.size() < maps + 3; ++id)
    elsewhere.maps_for_rendering[id] = map;  // of views that are not there
  for (const auto& [id, of_view] : same.maps_for_rendering) elsewhere.maps_for_rendering.erase(id);
  EXPECT_THAT(coverage::WhyExistingIsBetter(dir, elsewhere),
              HasSubstr("none of them near " + std::to_string(maps) + " views that had one"));

  // A mesh without maps is known by its triangles alone.
  fs::remove_all(dir / "depth");
  EXPECT_EQ(coverage::WhyExistingIsBetter(dir, same), "");
  auto half = std::make_shared<TriangleMesh>(*same.mesh->mesh);
  half->triangles.resize(half->triangles.size() / 2);
  const auto half_mesh = std::make_shared<coverage::LiveMesh>();
  half_mesh->mesh = half;
  coverage::FinishedGeometry fewer_triangles = same;
  fewer_triangles.mesh = half_mesh;
  EXPECT_THAT(coverage::WhyExistingIsBetter(dir, fewer_triangles),
              HasSubstr("triangles, and a new one would have"));
  std::ofstream(dir / "proxy.ply") << "nothing that can be read";
  EXPECT_EQ(coverage::WhyExistingIsBetter(dir, fewer_triangles), "");
}

TEST(GeometryCapture, ResumeGoesOnFromExistingMaps) {
  const ScratchFolder scratch;
  const fs::path dir = scratch / "lf";
  ASSERT_EQ(Capture(dir, "--frames 45 --deterministic").exit_code, 0);
  const LightField light_field = ReadLightField(dir);
  const DepthMapReading maps = MapsOf(dir);
  const std::vector<coverage::KnownMap> known = coverage::ReadKnownMaps(light_field);
  ASSERT_EQ(known.size(), maps.maps.size());
  for (const coverage::KnownMap& map : known) {
    const ViewDepthMap& on_disk = maps.maps.at(map.view_id)->Get();
    EXPECT_TRUE(map.camera == on_disk.camera);
    EXPECT_EQ(map.plane_step, on_disk.step);
    int places = 0;
    for (int y = 0; y < map.depth.rows; ++y)
      for (int x = 0; x < map.depth.cols; ++x)
        if (const float depth = map.depth.at<float>(y, x); depth > 0) {
          ++places;
          ASSERT_NEAR(depth * on_disk.InverseDepthAt(x, y), 1, 1e-5);
        }
    EXPECT_GT(places, map.depth.rows * map.depth.cols / 3) << map.view_id;
  }
  // A larger mesh of another program stays, and the one that was made for the new views does not
  // take its place.
  fs::remove_all(dir / "depth");
  TriangleMesh large = ReadMeshFile(dir / "proxy.ply").mesh;
  const auto triangles = large.triangles;
  for (int i = 0; i < 20; ++i)
    large.triangles.insert(large.triangles.end(), triangles.begin(), triangles.end());
  render::WriteMeshPly(dir / "proxy.ply", large, {});
  const std::string bytes = ReadWholeFile(dir / "proxy.ply");
  const CommandResult run = Capture(dir, "--resume --frames 70 --deterministic");
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_GT(ReadLightField(dir).views.size(), light_field.views.size());
  EXPECT_TRUE(ReadWholeFile(dir / "proxy.ply") == bytes);
  EXPECT_FALSE(fs::exists(dir / "kept/proxy.ply"));
  EXPECT_THAT(run.errors, HasSubstr("views were added: the mesh that is there stays, because a new one would "
                                    "not be as good everywhere ("));
  EXPECT_TRUE(JsonFromText(run.output)["geometry"].is_null());
  test::PrintFaultRow("views added to a light field with a finer mesh than their capture makes", 1,
                      "nothing; the finer mesh stays", std::nullopt);
}

// Views for which there was no time, and those that were recorded with another pose, are not the mesh's.
TEST(GeometryCapture, AMeshTellsTheViewsThatItIsOf) {
  const ScratchFolder scratch;
  const fs::path dir = scratch / "lf";
  ASSERT_EQ(Capture(dir, "--frames 30 --deterministic").exit_code, 0);
  const LightField light_field = ReadLightField(dir);
  const DepthMapReading maps = MapsOf(dir);
  ASSERT_GE(maps.maps.size(), 2u);
  const coverage::FinishedGeometry whole = AsFinished(dir);
  const auto state_of = [&](coverage::FinishedGeometry finished) {
    coverage::WriteGeometry(dir, finished, [](const std::string&) {});
    return *render::GeometryStateOf(ReadLightField(dir));
  };
  const std::size_t views = light_field.views.size();
  EXPECT_EQ(state_of(whole).origin->views, views);
  EXPECT_EQ(state_of(whole).mesh_fits, true);

  coverage::FinishedGeometry hurried = whole;
  hurried.views_left_out = {light_field.views.front().id};
  const std::optional<render::GeometryState> of_hurried = state_of(hurried);
  EXPECT_EQ(of_hurried->origin->views, views) << "that there were";
  EXPECT_EQ(of_hurried->origin->left_out, 1u);
  EXPECT_EQ(of_hurried->mesh_fits, false);
  EXPECT_THAT(test::RunUlf("info " + dir.string()).output,
              ::testing::AllOf(HasSubstr(fmt::format("(by ulf capture of {} of {} views, as they are now)",
                                                     views - 1, views)),
                               HasSubstr("makes both anew")));
  const auto told = JsonFromText(test::RunUlf("info --json " + dir.string()).output)["geometry"];
  EXPECT_EQ(told["views"], views);
  EXPECT_EQ(told["left_out"], 1);
  EXPECT_EQ(told["fits"], false);

  coverage::FinishedGeometry without_unreadable = whole;
  without_unreadable.unreadable_views = {light_field.views.back().id};
  EXPECT_EQ(state_of(without_unreadable).origin->left_out, 1u);

  coverage::FinishedGeometry without_all_maps = whole;
  without_all_maps.missing_maps = 1;
  EXPECT_EQ(state_of(without_all_maps).origin->left_out, 1u);

  coverage::FinishedGeometry moved = whole;
  moved.map_poses.begin()->second.translation.x() += 0.1;
  EXPECT_EQ(state_of(moved).origin->views, views);
  EXPECT_EQ(state_of(moved).mesh_fits, false);
  EXPECT_EQ(state_of(moved).maps, maps.maps.size() - 1);
}

// A folder where no mesh can be written: the views are all there, the mesh that was there is untouched.
TEST(GeometryCapture, UnwritableMeshCostsNothingElse) {
  const ScratchFolder scratch;
  const fs::path dir = scratch / "lf";
  ASSERT_EQ(Capture(dir, "--frames 60 --no-geometry").exit_code, 0);
  const std::size_t before = ReadLightField(dir).views.size();
  std::ofstream(dir / "proxy.ply") << "of another program";
  std::ofstream(dir / "kept") << "not a folder";
  const CommandResult run = Capture(dir, "--resume --frames 90");
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.errors, HasSubstr("ulf proxy"));
  EXPECT_GE(ReadLightField(dir).views.size(), before);
  EXPECT_EQ(ReadWholeFile(dir / "proxy.ply"), "of another program");
  EXPECT_FALSE(fs::exists(dir / "depth"));
}

TEST(GeometryCapture, UnwritableMapsCostNothingElse) {
  const ScratchFolder scratch;
  const fs::path dir = scratch / "lf";
  ASSERT_EQ(Capture(dir, "--frames 30 --no-geometry").exit_code, 0);
  std::ofstream(dir / "depth") << "not a folder";
  const CommandResult run = Capture(dir, "--resume --frames 60");
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.errors, HasSubstr("without depth maps, which 'ulf proxy " + dir.string()));
  const auto json = JsonFromText(run.output);
  EXPECT_EQ(json["geometry"]["written_maps"], 0);
  EXPECT_EQ(ReadMeshFile(dir / "proxy.ply").mesh.triangles.size(), json["geometry"]["triangles"]);
  EXPECT_EQ(ReadWholeFile(dir / "depth"), "not a folder");
}

// A disk that has room for the capture and none for its mesh: the views are all there, and that is said.
TEST(GeometryCaptureOnASmallDisk, FullDiskCostsMeshAlone) {
  const ScratchFolder scratch;
  const fs::path disk = scratch / "disk", dir = disk / "lf";
  fs::create_directory(disk);
  constexpr std::uint64_t kBytes = 32 << 20, kLeft = 700 << 10;
  if (const auto why = test::MountSmallDisk(disk, kBytes)) GTEST_SKIP() << *why;
  ASSERT_EQ(Capture(dir, "--frames 90 --no-geometry").exit_code, 0);
  const std::size_t before = ReadLightField(dir).views.size();
  // Room for what a short session writes; a mesh of these views takes some two megabytes.
  std::ofstream(disk / "room") << std::string(kLeft, 'x');
  test::FillDisk(disk / "filled");
  fs::remove(disk / "room");
  const CommandResult run = Capture(dir, "--resume --frames 2 --deterministic");  // all maps: no small mesh
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.errors, HasSubstr("no new mesh was written, and a mesh that was there stays; 'ulf proxy " +
                                    dir.string()));
  EXPECT_GE(ReadLightField(dir).views.size(), before);
  EXPECT_FALSE(fs::exists(dir / "proxy.ply")) << "no half of a mesh";
  for (const auto& file : fs::directory_iterator(dir))
    EXPECT_THAT(file.path().filename().string(), ::testing::Not(HasSubstr("proxy")))
        << "nothing is left behind";
}

// The same with room for the mesh and none for the depth maps beside it.
TEST(GeometryCaptureOnASmallDisk, FullDiskCostsMapsAlone) {
  const ScratchFolder scratch;
  const fs::path disk = scratch / "disk", dir = disk / "lf";
  fs::create_directory(disk);
  constexpr std::uint64_t kBytes = 32 << 20, kLeft = 700 << 10;
  if (const auto why = test::MountSmallDisk(disk, kBytes)) GTEST_SKIP() << *why;
  ASSERT_EQ(Capture(dir, "--frames 90 --deterministic").exit_code, 0);
  const std::size_t before = ReadLightField(dir).views.size();
  const std::string mesh = ReadWholeFile(dir / "proxy.ply");
  std::uint64_t of_maps = 0;
  for (const auto& [name, bytes] : FilesIn(dir / "depth")) of_maps += bytes.size();
  ASSERT_GT(of_maps, 3 * kLeft);
  fs::remove(dir / "proxy.ply");
  fs::remove_all(dir / "depth");
  std::ofstream(disk / "room") << std::string(kLeft + mesh.size(), 'x');
  test::FillDisk(disk / "filled");
  fs::remove(disk / "room");
  const CommandResult run = Capture(dir, "--resume --frames 2 --deterministic");
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.errors, HasSubstr("without depth maps, which 'ulf proxy " + dir.string()));
  EXPECT_EQ(JsonFromText(run.output)["geometry"]["written_maps"], 0);
  EXPECT_GE(ReadLightField(dir).views.size(), before);
  EXPECT_FALSE(ReadMeshFile(dir / "proxy.ply").mesh.triangles.empty());
  EXPECT_FALSE(fs::exists(dir / "depth")) << "no part of them";
}

// A kill while maps are being made: no mesh, a light field that opens, and geometry of all views
// when it goes on.
TEST(GeometryCapture, KilledCaptureResumesAllGeometry) {
  const ScratchFolder scratch;
  const fs::path dir = scratch / "lf";
  const char* binary = std::getenv("ULF_BINARY");
  ASSERT_TRUE(binary) << "ULF_BINARY is not set: run through ctest";
  test::ChildProcess capture({binary, "capture",
                              "sim:studio?width=320&height=240&look_away=0&row_deg=5&speed_deg_s=25",
                              "--headless", "--poses", "known", "--subject", "0,0,0.07,0.162", "--quality",
                              "fast", "-o", dir.string()});
  constexpr std::size_t kViews = 14;
  std::size_t views = 0;
  for (int i = 0; i < 600 && views < kViews; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    if (fs::exists(dir / "journal.jsonl")) views = ReadLightField(dir).views.size();
  }
  capture.Kill();
  ASSERT_GE(views, kViews);
  EXPECT_FALSE(fs::exists(dir / "proxy.ply"));
  const std::size_t kept = ReadLightField(dir).views.size();
  EXPECT_GE(kept, kViews);
  const CommandResult run = Capture(dir, "--resume --frames 20");
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_GE(ReadLightField(dir).views.size(), kept);
  EXPECT_GE(JsonFromText(run.output)["geometry"]["maps"], 4);
  EXPECT_GT(ReadMeshFile(dir / "proxy.ply").mesh.triangles.size(), 3000u);
}

TEST(GeometryCapture, DeterministicGeometryIsRepeatable) {
  const ScratchFolder scratch;
  for (const char* name : {"a", "b"})
    ASSERT_EQ(Capture(scratch / name, "--frames 50 --deterministic").exit_code, 0);
  const std::string bytes = ReadWholeFile(scratch / "a" / "proxy.ply");
  EXPECT_GT(bytes.size(), 10000u);
  EXPECT_TRUE(bytes == ReadWholeFile(scratch / "b" / "proxy.ply"));
  EXPECT_GT(FilesIn(scratch / "a" / "depth").size(), 3u);
  EXPECT_TRUE(FilesIn(scratch / "a" / "depth") == FilesIn(scratch / "b" / "depth"));
}

}  // namespace
}  // namespace ulf::geometry_capture_test
