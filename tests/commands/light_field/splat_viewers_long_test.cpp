// Tests: commands/light_field/export_splat, render/splats/make_splats, render/splats/splat_files,
// render/splats/spz_file.
//
// `ulf export splat` of simulated captures from which every eighth view was taken back: what others read and
// draw of it. PlayCanvas' splat-transform must read all numbers, and Spark draws some of the views that were
// taken back, beside their photographs, ulf's own pictures of the Gaussians, and the mesh of the same depth
// maps. Software OpenGL takes seconds for a picture of some hundred thousand Gaussians: captures are
// small, and pictures few.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "core/base/atomic_file.h"
#include "core/base/json_text.h"
#include "core/image/image.h"
#include "core/light_field/folder/light_field_io.h"
#include "render/gl/gl_renderer.h"
#include "render/proxy/proxy_choice.h"
#include "render/quality/evaluate.h"
#include "render/splats/splat_renderer.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::splat_viewers_long_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::RunUlf;
using test::ScratchFolder;

void Ulf(const std::string& arguments) {
  const auto run = RunUlf(arguments);
  ASSERT_EQ(run.exit_code, 0) << arguments << "\n" << run.errors;
}

json Printed(const std::string& command, const fs::path& scratch) {
  const fs::path out = scratch / "printed";
  EXPECT_EQ(std::system((command + " >" + out.string()).c_str()), 0) << command;
  return JsonOrDiscarded(ReadWholeFile(out));
}

// A PLY of floats: the values of each property.
std::map<std::string, std::vector<float>> ReadFloats(const fs::path& ply) {
  const std::string bytes = ReadWholeFile(ply);
  const std::size_t end = bytes.find("end_header\n") + 11;
  std::istringstream header(bytes.substr(0, end));
  std::vector<std::string> names;
  std::size_t count = 0;
  for (std::string line; std::getline(header, line);) {
    if (line.starts_with("property float ")) names.push_back(line.substr(15));
    if (line.starts_with("element vertex ")) count = std::stoul(line.substr(15));
  }
  EXPECT_EQ(bytes.size(), end + 4 * count * names.size()) << ply;
  std::map<std::string, std::vector<float>> values;
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t n = 0; n < names.size(); ++n) {
      float value;
      std::memcpy(&value, bytes.data() + end + 4 * (i * names.size() + n), 4);
      values[names[n]].push_back(value);
    }
  return values;
}

float MostDifference(const std::vector<float>& a, const std::vector<float>& b) {
  float most = a.size() == b.size() ? 0 : INFINITY;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) most = std::max(most, std::abs(a[i] - b[i]));
  return most;
}

// The Gaussians of a file of ours.
Gaussians GaussiansOf(const std::map<std::string, std::vector<float>>& floats) {
  Gaussians gaussians(floats.at("x").size());
  const auto set = [&](const std::string& name, const auto& field) {
    const std::vector<float>& values = floats.at(name);
    for (std::size_t i = 0; i < gaussians.size(); ++i) field(gaussians[i]) = values[i];
  };
  for (int i = 0; i < 3; ++i) {
    set(std::string(1, "xyz"[i]), [i](Gaussian& g) -> float& { return g.position_in_world[i]; });
    set("scale_" + std::to_string(i), [i](Gaussian& g) -> float& { return g.scale[i]; });
    set("rot_" + std::to_string(i + 1), [i](Gaussian& g) -> float& { return g.world_from_axes.coeffs()[i]; });
    set("f_dc_" + std::to_string(i), [i](Gaussian& g) -> float& { return g.harmonics[0][i]; });
    for (std::size_t h = 1; h < 4; ++h)
      set("f_rest_" + std::to_string(3 * i + static_cast<int>(h) - 1),
          [i, h](Gaussian& g) -> float& { return g.harmonics[h][i]; });
  }
  set("rot_0", [](Gaussian& g) -> float& { return g.world_from_axes.w(); });
  set("opacity", [](Gaussian& g) -> float& { return g.opacity; });
  for (Gaussian& gaussian : gaussians) {
    gaussian.scale = gaussian.scale.array().exp();
    gaussian.opacity = 1 / (1 + std::exp(-gaussian.opacity));
  }
  return gaussians;
}

// Views that `kept` lacks, spread over all of these.
std::vector<SceneView> TakenBack(const RenderScene& all, const LightField& kept) {
  constexpr std::size_t kDrawn = 4;
  std::vector<SceneView> lacking, drawn;
  for (const SceneView& view : all.views)
    if (kept.FindView(view.id) == nullptr) lacking.push_back(view);
  for (std::size_t i = 0; i < std::min(kDrawn, lacking.size()); ++i)
    drawn.push_back(lacking[(2 * i + 1) * lacking.size() / (2 * std::min(kDrawn, lacking.size()))]);
  return drawn;
}

json PlanFor(const fs::path& file, const std::vector<SceneView>& views) {
  json plan{{"file", file.string()}, {"views", json::array()}};
  for (const SceneView& view : views) {
    const CameraModel camera = view.camera.WithoutDistortion();
    json& of_view = plan["views"].emplace_back(json{{"name", std::to_string(view.id)},
                                                    {"width", camera.width},
                                                    {"height", camera.height},
                                                    {"fx", camera.fx},
                                                    {"fy", camera.fy},
                                                    {"cx", camera.cx},
                                                    {"cy", camera.cy}});
    const Eigen::Matrix4d pose = view.cam_from_world.Matrix();
    for (int i = 0; i < 16; ++i) of_view["cam_from_world"].push_back(pose(i / 4, i % 4));
  }
  return plan;
}

double MeanPsnr(const std::vector<SceneView>& views,
                const std::function<cv::Mat(const SceneView&)>& picture_of) {
  double sum = 0;
  for (const SceneView& view : views) {
    const UndistortedPhotograph photograph = Undistort(view);
    sum += CompareImages(picture_of(view), photograph.srgb8, photograph.valid).psnr_db;
  }
  return sum / static_cast<double>(views.size());
}

cv::Mat PictureOfSpark(const fs::path& out, const SceneView& view) {
  const std::string bytes = ReadWholeFile(out / (std::to_string(view.id) + ".rgb"));
  cv::Mat picture(view.camera.height, view.camera.width, CV_8UC3);
  EXPECT_EQ(bytes.size(), picture.total() * 3);
  for (std::size_t i = 0; i < picture.total(); ++i)
    for (std::size_t c = 0; c < 3; ++c)
      picture.data[3 * i + c] = static_cast<std::uint8_t>(bytes[3 * i + 2 - c]);
  return picture;
}

struct Scores {
  double mesh_db, ours_db, ply_db, spz_db;
};

// What Spark and we draw of the files, and the renderer of the same geometry.
Scores ScoresOf(const std::vector<SceneView>& taken_back, const fs::path& kept, const fs::path& scratch) {
  Scores scores{};
  const LightField light_field = ReadLightField(kept);
  auto scene = LoadScene(light_field, {});
  scene = WithProxy(*scene, OwnProxy("mesh", scene->subject, kept));
  const auto renderer = MakeRenderer(scene, {.field = {.kind = FieldKind::kSubdivision, .level = 1}});
  scores.mesh_db = MeanPsnr(taken_back, [&](const SceneView& view) {
    return Srgb8FromLinear(renderer->Render(view.camera.WithoutDistortion(), view.cam_from_world).linear);
  });
  const Gaussians gaussians = GaussiansOf(ReadFloats(scratch / "vase.ply"));
  scores.ours_db = MeanPsnr(taken_back, [&](const SceneView& view) {
    cv::Mat bytes;
    DrawSplats(gaussians, view.camera.WithoutDistortion(), view.cam_from_world)
        .srgb.convertTo(bytes, CV_8U, 255);
    return bytes;
  });
  for (const char* ending : {"ply", "spz"}) {
    const fs::path out = scratch / (std::string("spark_") + ending);
    fs::create_directories(out);
    WriteFileAtomically(scratch / "plan.json",
                        JsonText(PlanFor(scratch / (std::string("vase.") + ending), taken_back)));
    const json report = Printed(
        "node " VIEW_SPLATS " " SPLAT_TOOLS " " + (scratch / "plan.json").string() + " " + out.string(),
        scratch);
    EXPECT_EQ(report["failed"], "") << "is everything there? ./run web installs it";
    EXPECT_EQ(report["views"], taken_back.size());
    (ending == std::string("ply") ? scores.ply_db : scores.spz_db) =
        MeanPsnr(taken_back, [&](const SceneView& view) { return PictureOfSpark(out, view); });
  }
  return scores;
}

// The same in the axes of .spz (x right, y up, z back), cut to the ranges that its bytes hold.
std::vector<float> AsSpzHolds(const std::string& name, std::vector<float> values) {
  constexpr float kMostColor = 0.5f / 0.15f, kMostHarmonic = 1;
  const bool is_harmonic = name.starts_with("f_rest_");
  const bool is_turned = name == "y" || name == "z" || (is_harmonic && std::stoi(name.substr(7)) % 3 < 2);
  for (float& value : values) {
    if (is_turned) value = -value;
    if (name.starts_with("f_dc_")) value = std::clamp(value, -kMostColor, kMostColor);
    if (is_harmonic) value = std::clamp(value, -kMostHarmonic, kMostHarmonic);
  }
  return values;
}

void ExpectSameGaussians(const fs::path& scratch) {
  const auto ours = ReadFloats(scratch / "vase.ply");
  for (const char* from : {"vase.ply", "vase.spz"}) {
    const fs::path back = scratch / (std::string(from) + ".back.ply");
    ASSERT_EQ(
        std::system(("node " SPLAT_TOOLS "/node_modules/@playcanvas/splat-transform/bin/cli.mjs -w -q " +
                     (scratch / from).string() + " " + back.string())
                        .c_str()),
        0);
    const auto theirs = ReadFloats(back);
    const bool exact = std::string(from) == "vase.ply";
    for (const auto& [name, values] : ours) {
      if (!exact && name.starts_with("n")) continue;
      if (!exact && (name.starts_with("rot") || name == "opacity" || name.starts_with("scale"))) continue;
      ASSERT_TRUE(theirs.contains(name)) << from << " " << name;
      const float most = name.size() == 1 ? 2e-4f : 0.014f;
      if (exact)
        EXPECT_EQ(MostDifference(values, theirs.at(name)), 0) << name;
      else
        EXPECT_LE(MostDifference(AsSpzHolds(name, values), theirs.at(name)), most) << name;
    }
  }
}

class SplatViewers : public testing::TestWithParam<const char*> {};

TEST_P(SplatViewers, DrawLeftOutViewsAsTheMeshRendererDoes) {
  const ScratchFolder scratch;
  const fs::path all = scratch / "all", kept = scratch / "kept";
  Ulf("capture '" + std::string(GetParam()) + "' -o " + all.string() +
      " --headless --deterministic --poses known --subject 0,0,0.07,0.162 --quality fast --no-geometry "
      "--until-covered 24x16");
  fs::copy(all, kept, fs::copy_options::recursive);
  const LightField light_field = ReadLightField(all);
  std::string numbers;
  for (std::size_t i = 0; i < light_field.views.size(); i += 8)
    numbers += " " + std::to_string(light_field.views[i].id);
  Ulf("take-back " + kept.string() + numbers);
  Ulf("proxy " + kept.string());
  for (const char* ending : {".ply", ".spz"})
    Ulf("export splat " + kept.string() + " --most 300000 -o " + (scratch / "vase").string() + ending);
  ExpectSameGaussians(scratch.path());
  const auto scene = LoadScene(light_field, {});
  const std::vector<SceneView> taken_back = TakenBack(*scene, ReadLightField(kept));
  ASSERT_GT(taken_back.size(), 2u);
  const Scores scores = ScoresOf(taken_back, kept, scratch.path());
  std::printf(
      "%s: %zu views, %zu of those left out: mesh %.2f dB, Gaussians %.2f, by Spark of .ply %.2f, of "
      ".spz %.2f\n",
      GetParam(), light_field.views.size(), taken_back.size(), scores.mesh_db, scores.ours_db, scores.ply_db,
      scores.spz_db);
  EXPECT_GT(scores.ours_db, scores.mesh_db - 3);
  EXPECT_GT(scores.ply_db, scores.ours_db - 0.5);
  EXPECT_GT(scores.spz_db, scores.ply_db - 0.5);
}
INSTANTIATE_TEST_SUITE_P(Captures, SplatViewers,
                         testing::Values("sim:studio?seed=21", "sim:studio?seed=22", "sim:gloss?seed=21"));

}  // namespace
}  // namespace ulf::splat_viewers_long_test
