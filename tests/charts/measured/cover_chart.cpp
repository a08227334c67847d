// Views against the quality of pictures: recording by the bound, and by errors that are measured while
// capturing. Pictures are rendered over the light field's own mesh at places between the views, against the
// simulator's pictures there.
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "acquisition/simulator/simulated_camera.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/base/parallel_for.h"
#include "core/base/quantile.h"
#include "core/base/shell_word.h"
#include "core/light_field/folder/light_field_io.h"
#include "render/fields/field_options.h"
#include "render/gl/gl_renderer.h"
#include "render/proxy/mesh_file.h"
#include "render/quality/evaluate.h"
#include "tests/measure/runner.h"
#include "tests/render/scenes/held_photograph.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::test {
namespace {

namespace fs = std::filesystem;

constexpr int kPlaces = 40;

// A way to decide what is covered, and to hold the camera.
struct Way {
  const char* series;
  const char* name;
  std::vector<std::string> options;  // of `ulf capture`
  const char* person = "";           // who holds the camera; empty: a hand that scans by a plan
};

struct CoverRun {
  int views = 0;
  double covered = 0;                  // as the capture says
  double median_db = 0, worst_db = 0;  // on the subject's disc: the middle and the worst tenth of the places
};

CoverRun Capture(const std::string& scene_name, const Way& way, const SimulatedCamera& camera,
                 double most_seconds, const fs::path& folder) {
  const Subject& subject = camera.scene().subject();
  const Eigen::Vector3d& center = subject.center_in_world;
  std::string words = fmt::format(
      "capture 'sim:{}?seed={}&look_away=0' -o {} --headless --deterministic --poses known --until-covered "
      "60x40 "
      "--max-seconds {:g} --json --subject={},{},{},{}",
      scene_name, kFirstSeed, ShellWord(folder.string()), most_seconds, center.x(), center.y(), center.z(),
      subject.radius);
  for (const std::string& word : way.options) words += " " + ShellWord(word);
  if (*way.person) words += fmt::format(" --operator {}", ShellWord(way.person));
  const CommandResult result = RunProgram(ShellWord(ULF_BINARY), words);
  if (result.exit_code != 0) throw Error("ulf {}: {}", words, result.errors);
  const nlohmann::json json = JsonFromText(result.output);
  CoverRun run;
  run.views = json.at("recorded");
  if (const auto covered = json.find("covered"); covered != json.end() && covered->is_number())
    run.covered = *covered;
  return run;
}

CoverRun RunCover(const std::string& scene_name, const Way& way, double most_seconds) {
  SimulationOptions simulated;
  simulated.scene = scene_name;
  simulated.seed = kFirstSeed;
  simulated.looks_away = false;
  const SimulatedCamera camera(simulated);
  const ScratchFolder scratch;
  const fs::path folder = scratch / "lf";
  CoverRun run = Capture(scene_name, way, camera, most_seconds, folder);

  const auto scene = LoadScene(ReadLightField(folder), {});
  const auto mesh = std::make_shared<const TriangleMesh>(ReadMeshFile(folder / kMeshProxyFile).mesh);
  GlRenderer renderer(WithProxy(*scene, std::make_shared<MeshProxy>(scene->subject, mesh)),
                      {.field = {.kind = FieldKind::kSubdivision, .level = 1}});
  HandOptions options = dynamic_cast<const Hand&>(camera.hand()).options();
  options.seed += 1000;
  options.cap_azimuth *= 0.85;
  options.cap_elevation *= 0.85;
  options.margin = 0;
  options.looks_away = false;
  const Hand hand(options);
  const CameraModel pinhole = camera.camera().WithoutDistortion();
  std::vector<double> disc_db;
  for (int i = 0; i < kPlaces; ++i) {
    const Rigid3 pose = hand.CamFromWorld(hand.FirstPassEndS() * (0.05 + 0.95 * (i + 0.5) / kPlaces));
    SceneView truth;
    truth.camera = camera.camera();
    truth.cam_from_world = pose;
    truth.photograph = HoldPhotograph(MakePyramid(camera.CleanSrgb(pose)));
    const UndistortedPhotograph photograph = Undistort(truth);
    const cv::Mat picture = Srgb8FromLinear(renderer.Render(pinhole, pose).linear);
    const cv::Mat disc = SubjectDisc(pinhole, pose, camera.scene().subject()) & photograph.valid;
    disc_db.push_back(CompareImages(picture, photograph.srgb8, disc).psnr_db);
  }
  constexpr double kWorstTenth = 0.1;
  run.median_db = Median(disc_db);
  run.worst_db = Quantile(disc_db, kWorstTenth);
  return run;
}

std::vector<std::string> Measured(const std::string& db) {
  return {"--quality", "fast", "--cover", "measured:" + db};
}

std::vector<Way> Ways(const Effort& effort) {
  if (effort.quick)
    return {{"bound", "20 px", {"--threshold-px", "20"}}, {"measured", "33 dB", Measured("33")}};
  return {{"bound", "12 px", {"--quality", "fast"}},
          {"bound", "20 px", {"--threshold-px", "20"}},
          {"measured", "33 dB", Measured("33")},
          {"measured", "36 dB", Measured("36")},
          {"bound, guided person", "12 px", {"--quality", "fast"}, "guided:101"},
          {"measured, guided person", "33 dB", Measured("33"), "guided:101"}};
}

Chart MeasureCover(const Effort& effort) {
  const std::vector<Way> ways = Ways(effort);
  const std::vector<std::string> scenes =
      effort.Of(std::vector<std::string>{"studio"}, {"studio", "gloss", "plant", "picture"});
  constexpr double kFull = 0.97;  // of the cap; a capture ends at 0.98, and its last adjustment moves views
  std::vector<CoverRun> runs(scenes.size() * ways.size());
  ParallelFor(
      runs.size(),
      [&](std::size_t i) {
        runs[i] = RunCover(scenes[i / ways.size()], ways[i % ways.size()], effort.Of(20.0, 150.0));
      },
      static_cast<double>(runs.size()));
  Chart chart;
  for (std::size_t s = 0; s < scenes.size(); ++s) {
    ChartPanel panel{
        .title = scenes[s], .cost = {"views", true}, .error = {"disc [dB]", false, true}, .compared = false};
    for (std::size_t w = 0; w < ways.size(); ++w) {
      const CoverRun& run = runs[s * ways.size() + w];
      panel.points.push_back({ways[w].series,
                              run.covered < kFull ? std::string(ways[w].name) + ", cut off" : ways[w].name,
                              Spread::Exactly(run.views),
                              {run.median_db, run.worst_db, run.median_db}});
    }
    chart.panels.push_back(panel);
  }
  return chart;
}

CHART(cover, MeasureCover, "Views against quality: recorded by the bound, and by measured errors", R"(A cap
  of 60 x 40 degrees, at most 150 s of the camera's time, poses known, one seed; pictures from the light
  field's own mesh at 40 places between the views, against the simulator's, on the subject's disc: the
  middle of the places, from the worst tenth up. By measured errors: from 12 px, where nothing is measured,
  to 7 and 36.)");

}  // namespace
}  // namespace ulf::test
