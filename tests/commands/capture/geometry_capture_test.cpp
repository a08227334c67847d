// Tests: coverage/session/record/live_geometry, commands/capture/capture_report.
//
// ulf capture leaves a mesh, or says why there is none; a light field is complete without.
#include <gmock/gmock.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "core/light_field/light_field_io.h"
#include "render/proxy/mesh_file.h"
#include "tests/support/child_process.h"
#include "tests/support/floors.h"
#include "tests/support/small_disk.h"
#include "tests/support/test_paths.h"

namespace ulf {
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

std::string BytesOf(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(GeometryCapture, MeshIsThereWhenTheCaptureEnds) {
  const ScratchFolder scratch;
  const fs::path dir = scratch / "lf";
  const CommandResult run = Capture(dir, "--until-covered 20x14");
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  const auto json = nlohmann::json::parse(run.output);
  EXPECT_GE(json["geometry"]["maps"], 4);
  const MeshReading mesh = ReadMeshFile(dir / "proxy.ply");
  EXPECT_EQ(mesh.mesh.triangles.size(), json["geometry"]["triangles"]);
  EXPECT_GT(mesh.mesh.triangles.size(), 5000u);
  // It serves a rendering at once.
  const CommandResult evaluated =
      RunUlf("evaluate " + dir.string() + " --every 6 --fields lumigraph --proxy plane --proxy mesh --json");
  ASSERT_EQ(evaluated.exit_code, 0) << evaluated.errors;
  const auto rows = nlohmann::json::parse(evaluated.output)["results"];
  ASSERT_EQ(rows.size(), 2u) << evaluated.output;
  const auto psnr_db = [&](int row) { return rows[row]["all"]["psnr_db"].get<double>(); };
  EXPECT_GT(psnr_db(1), psnr_db(0) + 3) << "mesh, plane";
}

TEST(GeometryCapture, NoGeometryMakesNone) {
  const ScratchFolder scratch;
  const CommandResult run = Capture(scratch / "lf", "--frames 60 --no-geometry");
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_TRUE(nlohmann::json::parse(run.output)["geometry"].is_null());
  EXPECT_FALSE(fs::exists(scratch / "lf" / "proxy.ply"));
}

TEST(GeometryCapture, OlderMeshIsKept) {
  const ScratchFolder scratch;
  const fs::path dir = scratch / "lf";
  ASSERT_EQ(Capture(dir, "--frames 30 --no-geometry").exit_code, 0);
  std::ofstream(dir / "proxy.ply") << "of another program";
  const CommandResult run = Capture(dir, "--resume --frames 60");
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_EQ(BytesOf(dir / "kept" / "proxy.ply"), "of another program");
  EXPECT_THAT(run.errors, HasSubstr("kept"));
  EXPECT_FALSE(ReadMeshFile(dir / "proxy.ply").mesh.triangles.empty()) << "earlier views and new ones";
}

// A session that records nothing leaves the mesh alone, which may be a finer one.
TEST(GeometryCapture, MeshOfTheSameViewsStays) {
  const ScratchFolder scratch;
  const fs::path dir = scratch / "lf";
  ASSERT_EQ(Capture(dir, "--frames 60").exit_code, 0);
  const std::size_t views = ReadLightField(dir).views.size();
  std::ofstream(dir / "proxy.ply") << "a finer one";
  const CommandResult run = Capture(dir, "--resume --frames 1");
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  ASSERT_EQ(ReadLightField(dir).views.size(), views);
  EXPECT_EQ(BytesOf(dir / "proxy.ply"), "a finer one");
  EXPECT_FALSE(fs::exists(dir / "kept" / "proxy.ply"));
  EXPECT_THAT(run.errors, HasSubstr("the mesh that is there stays"));
  EXPECT_TRUE(nlohmann::json::parse(run.output)["geometry"].is_null());
}

// A folder where no mesh can be written: the views are all there, the mesh that was there is untouched.
TEST(GeometryCapture, MeshThatCannotBeWrittenCostsNothingElse) {
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
  EXPECT_EQ(BytesOf(dir / "proxy.ply"), "of another program");
}

// A disk that has room for the capture and none for its mesh: the views are all there, and that is said.
TEST(GeometryCaptureOnASmallDisk, FullWhenTheMeshIsWrittenItCostsTheMeshAlone) {
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
  EXPECT_THAT(run.errors, HasSubstr("the light field is complete without a mesh, ulf proxy makes it"));
  EXPECT_GE(ReadLightField(dir).views.size(), before);
  EXPECT_FALSE(fs::exists(dir / "proxy.ply")) << "no half of a mesh";
  for (const auto& file : fs::directory_iterator(dir))
    EXPECT_THAT(file.path().filename().string(), ::testing::Not(HasSubstr("proxy")))
        << "nothing is left behind";
}

// A kill while maps are being made: no mesh, a light field that opens, and geometry of all views when it goes on.
TEST(GeometryCapture, KilledCaptureGoesOnWithTheGeometryOfAllViews) {
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
  EXPECT_GE(nlohmann::json::parse(run.output)["geometry"]["maps"], 4);
  EXPECT_GT(ReadMeshFile(dir / "proxy.ply").mesh.triangles.size(), 3000u);
}

TEST(GeometryCapture, DeterministicMeshIsTheSameTwice) {
  const ScratchFolder scratch;
  for (const char* name : {"a", "b"})
    ASSERT_EQ(Capture(scratch / name, "--frames 50 --deterministic").exit_code, 0);
  const std::string bytes = BytesOf(scratch / "a" / "proxy.ply");
  EXPECT_GT(bytes.size(), 10000u);
  EXPECT_TRUE(bytes == BytesOf(scratch / "b" / "proxy.ply"));
}

}  // namespace
}  // namespace ulf
