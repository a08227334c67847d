// Tests: commands/light_field/export_command, commands/light_field/export_files,
// commands/light_field/export_scene, core/light_field/exchange/staged_folder.
//
// Exports that end early leave nothing: on a full disk, in every form, and when they are killed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <thread>

#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "render/proxy/mesh_file.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/child_process.h"
#include "tests/support/own_namespaces.h"
#include "tests/support/test_paths.h"

namespace ulf::export_accidents_test {
namespace {

namespace fs = std::filesystem;
using testing::AnyOf;
using testing::ElementsAre;
using testing::HasSubstr;

void WriteField(const fs::path& dir) {
  test::SceneSpec spec{.viewpoints = test::CapViewpoints(8, 0.25, 1.5, 0.05, 3), .width = 320, .height = 240};
  spec.focal_px = 270;
  spec.with_square = true;
  test::WriteLightField(dir, spec, true);
  render::WriteMeshPly(dir / render::kMeshProxyFile, *test::PlaneAndSquare());
  LightFieldWriter writer = LightFieldWriter::Resume(dir);
  writer.SetPoints(test::PointsOfPlaneAndSquare(200, 60));
  writer.Close(1);
}

std::vector<std::string> NamesIn(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename());
  std::ranges::sort(names);
  return names;
}

TEST(ExportAccidents, AFullDiskLeavesNothingOfAnyForm) {
  const test::ScratchFolder scratch;
  if (const auto problem = test::MountSmallDisk(scratch.path(), 24 << 20)) GTEST_SKIP() << *problem;
  const std::string dir = (scratch / "lf").string(), out = (scratch / "out").string();
  WriteField(dir);
  test::RunUlf("export colmap " + dir + " -o " + out + " --known-points");  // pyramids and the like are made
  fs::remove_all(out);
  struct Form {
    std::string arguments;
    std::uint64_t free_bytes;
  };
  const std::string points = " --known-points";
  for (const auto& [form, free_bytes] :
       {Form{"colmap --undistort --binary" + points, 100 << 10}, Form{"colmap" + points, 100 << 10},
        Form{"nerfstudio" + points, 100 << 10}, Form{"instant-ngp", 100 << 10},
        Form{"nerf-synthetic", 100 << 10}, Form{"realityscan", 100 << 10},
        Form{"metashape" + points, 100 << 10}, Form{"gltf --texture 512", 4 << 10}, Form{"tum", 0},
        Form{"ply" + points, 0}}) {
    test::FillDisk(scratch / "ballast");
    fs::resize_file(scratch / "ballast", fs::file_size(scratch / "ballast") - free_bytes);
    const test::CommandResult told = test::RunUlf("export " + form + " " + dir + " -o " + out);
    EXPECT_EQ(told.exit_code, 1) << form << told.errors;
    EXPECT_THAT(told.errors, AnyOf(HasSubstr("free some space"), HasSubstr("make room"))) << form;
    EXPECT_THAT(NamesIn(scratch.path()), ElementsAre("ballast", "lf")) << form;
  }
}

TEST(ExportAccidents, TheNextRemovesWhatAKillLeft) {
  const test::ScratchFolder scratch;
  const std::string dir = (scratch / "lf").string(), out = (scratch / "out").string();
  WriteField(dir);
  const std::vector<std::string> command{std::getenv("ULF_BINARY"), "export", "gltf", dir, "-o", out};
  {
    test::ChildProcess child(command);
    const auto begun = std::chrono::steady_clock::now();
    while (NamesIn(scratch.path()).size() < 2 &&
           std::chrono::steady_clock::now() - begun < std::chrono::seconds(20))
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    child.Kill();
  }
  const std::vector<std::string> left = NamesIn(scratch.path());
  ASSERT_EQ(left.size(), 2u) << "it was killed while it wrote";
  EXPECT_TRUE(left[0].starts_with(".out.")) << left[0] << ": nobody takes it for an export";
  const test::CommandResult again =
      test::RunUlf("export tum " + dir + " -o " + (scratch / "poses.txt").string());
  EXPECT_EQ(again.exit_code, 0) << again.errors;
  const test::CommandResult next = test::RunUlf("export instant-ngp " + dir + " -o " + out);
  EXPECT_EQ(next.exit_code, 0) << next.errors;
  EXPECT_THAT(NamesIn(scratch.path()), ElementsAre("lf", "out", "poses.txt"));
}

}  // namespace
}  // namespace ulf::export_accidents_test
