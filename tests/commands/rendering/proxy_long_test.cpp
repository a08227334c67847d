// Tests: commands/rendering/proxy_command, render/stereo/proxy_builder.
//
// Meshes of real photographs, judged by rendering views that were left out of mesh and rendering alike.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/base/json_text.h"
#include "tests/support/test_paths.h"

namespace ulf::proxy_long_test {
namespace {

using test::RunUlf;

// Mean PSNR of the left-out views by lumigraph weights, for the plane and for the mesh; the figures are
// printed.
struct Scores {
  double plane_db = 0, mesh_db = 0;
  nlohmann::json mesh = {};
};

Scores Measure(const std::filesystem::path& data, const std::string& import_options) {
  const test::ScratchFolder scratch;
  const std::string field = (scratch / "field").string();
  Scores scores;
  for (const std::string& command :
       {"import " + data.string() + " " + import_options + " -o " + field,
        "proxy " + field + " --leave-out-every 8 --json",
        "evaluate " + field + " --every 8 --fields lumigraph --proxy plane --proxy mesh --json"}) {
    const auto result = RunUlf(command);
    EXPECT_EQ(result.exit_code, 0) << result.errors;
    if (result.exit_code != 0) return scores;
    if (command.starts_with("proxy")) scores.mesh = JsonFromText(result.output);
    if (!command.starts_with("evaluate")) continue;
    const auto report = JsonFromText(result.output);
    scores.plane_db = report["results"][0]["all"]["psnr_db"];
    scores.mesh_db = report["results"][1]["all"]["psnr_db"];
    EXPECT_NE(report["results"][0]["proxy"], report["results"][1]["proxy"]);
  }
  fmt::print("{}: plane {:.2f} dB, mesh {:.2f} dB; {}\n", data.filename().string(), scores.plane_db,
             scores.mesh_db, JsonText(scores.mesh));
  return scores;
}

TEST(ProxyOfPhotographs, ShowsAFoxHeldInTheHand) {
  ULF_NEED_TEST_DATA(data, "fox_half");
  const Scores scores = Measure(data, "");
  EXPECT_GE(scores.mesh_db, 25.5);
  EXPECT_GE(scores.mesh_db, scores.plane_db + 4.5);
  EXPECT_LE(scores.mesh["triangles"], 400000);
  EXPECT_LE(scores.mesh["peak_mib"], 4096);
}

TEST(ProxyOfPhotographs, ShowsAShopFromAGrid) {
  ULF_NEED_TEST_DATA(data, "shop_grid_even");
  const Scores scores = Measure(data, "--subject 0,0,-8.12,1.5");
  EXPECT_GE(scores.mesh_db, scores.plane_db + 4.5);
  EXPECT_LE(scores.mesh["triangles"], 400000);
  EXPECT_LE(scores.mesh["peak_mib"], 4096);
}

}  // namespace
}  // namespace ulf::proxy_long_test
