// Tests: coverage/session/record/live_geometry, commands/capture/capture_command.
//
// Photographs and video by others through the whole program: captured, geometry, rendered, compared with the
// photographs that were left out. The simulator's sibling is geometry_capture_test.
#include <gmock/gmock.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/base/json_text.h"
#include "core/base/quantile.h"
#include "core/light_field/folder/light_field_io.h"
#include "render/proxy/mesh_file.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::real_sets_long_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::CommandResult;
using test::RunUlf;
using test::ScratchFolder;

// PSNR in dB of the left-out photographs, over a plane and over the mesh.
struct OverPlaneAndMesh {
  double plane_db = 0, mesh_db = 0;
};
OverPlaneAndMesh Evaluated(const fs::path& dir, const std::string& more) {
  const CommandResult run = RunUlf("evaluate " + dir.string() +
                                   " --every 8 --fields lumigraph --proxy plane --proxy mesh --json " + more);
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  const json rows = JsonFromText(run.output)["results"];
  const OverPlaneAndMesh result{rows.at(0)["all"]["psnr_db"], rows.at(1)["all"]["psnr_db"]};
  printf("%s: plane %.2f dB, mesh %.2f dB\n", dir.filename().c_str(), result.plane_db, result.mesh_db);
  return result;
}

// The mesh is the capture's own: it knows the photographs that are left out.
TEST(RealSets, CapturesTheFoxOverItsOwnMesh) {
  ULF_NEED_TEST_DATA(data, "fox_half");
  const ScratchFolder scratch;
  const fs::path dir = scratch / "fox";
  const CommandResult run =
      RunUlf("capture replay:" + data.string() + " --poses known --headless --json -o " + dir.string());
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_GT(JsonFromText(run.output)["recorded"], 30);
  ASSERT_TRUE(fs::exists(dir / "proxy.ply"));
  const OverPlaneAndMesh db = Evaluated(dir, "");
  EXPECT_GT(db.mesh_db, db.plane_db + 3);
  const CommandResult render =
      RunUlf("render " + dir.string() + " --path orbit --frames 0:3 -o " + (scratch / "orbit").string());
  EXPECT_EQ(render.exit_code, 0) << render.errors;
}

// A walk through a kitchen has no subject: its photographs are posed, and ulf proxy makes the mesh, here
// without the photographs that are left out. The subject is the middle of the tracked points.
TEST(RealSets, VideoOfAKitchenIsCapturedAndRendered) {
  ULF_NEED_TEST_DATA(data, "handheld_kitchen");
  const ScratchFolder scratch;
  const fs::path dir = scratch / "kitchen";
  const CommandResult run = RunUlf("capture replay:" + data.string() +
                                   " --focal-px 527.4 --no-subject --headless --json -o " + dir.string());
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  const LightField light_field = ReadLightField(dir);
  EXPECT_GT(light_field.views.size(), 50u);
  ASSERT_GT(light_field.points.size(), 500u);
  Eigen::Vector3d center;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const ScenePoint& point : light_field.points) values.push_back(point.position_in_world[axis]);
    center[axis] = Median(values);
  }
  std::vector<double> distances;
  for (const ScenePoint& point : light_field.points)
    distances.push_back((point.position_in_world - center).norm());
  const std::string subject =
      fmt::format("--subject={},{},{},{}", center.x(), center.y(), center.z(), Median(distances));
  const CommandResult proxy = RunUlf("proxy " + dir.string() + " --leave-out-every 8 " + subject);
  ASSERT_EQ(proxy.exit_code, 0) << proxy.errors;
  const OverPlaneAndMesh db = Evaluated(dir, subject);
  EXPECT_GT(db.mesh_db, db.plane_db + 3);
}

}  // namespace
}  // namespace ulf::real_sets_long_test
