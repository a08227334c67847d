// How restless pictures are along a camera path whose true pictures are known: blending fields and proxies of
// one light field, as `ulf render` draws them.
//
//   temporal_quality DIR --path orbit [--frames 480] [--truth sim:studio?seed=7] [--strips F.png]
//                    [--plot F.svg] [--json]
//
// Options of the scene, the fields and the proxies are those of `ulf evaluate`. The table goes to standard
// output.
#include <fmt/core.h>

#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "commands/options/scene_options.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/base/output_path.h"
#include "core/base/progress.h"
#include "core/image/files/picture_file.h"
#include "core/light_field/folder/light_field_io.h"
#include "render/fields/field_options.h"
#include "render/gl/gl_renderer.h"
#include "render/output/path_files.h"
#include "tests/charts/temporal/temporal_evaluation.h"
#include "tests/charts/temporal/truth.h"
#include "tests/measure/provenance.h"
#include "tests/measure/runner.h"

namespace ulf::test {
namespace {

struct TemporalArgs : commands::SceneArgs {
  std::string path = "orbit";
  std::string truth;  // empty: the light field's own device, if that is the simulator
  int frames = 0, width = 0;
  std::vector<std::string> fields{"nearest", "linear", "subdivision", "lumigraph", "lumigraph-per-pixel",
                                  "soft"};
  commands::FieldArgs field_details;
  std::string strips, plot;  // files to write
  bool json = false;
};

std::string TruthNameOf(const TemporalArgs& args) {
  if (!args.truth.empty()) return args.truth;
  const std::string uri = ReadLightField(args.dir).device_uri;
  if (uri.starts_with("sim:")) return uri;
  throw Error(
      "{} was not captured from the simulator, so that the true pictures of the path are unknown; give them "
      "as a folder with --truth",
      args.dir);
}

// A path with a camera for each pose. Where the truth can take any camera, the lens zooms until photographs
// fill the pictures.
render::CameraPath PathOf(const TemporalArgs& args,
                          const std::shared_ptr<const render::RenderScene>& scene_pointer,
                          const TruthSource& truth) {
  const render::RenderScene& scene = *scene_pointer;
  CameraModel camera = scene.views.front().camera.WithoutDistortion();
  if (args.width > 0)
    camera = camera.ScaledTo(args.width, std::max(1, camera.height * args.width / camera.width));
  render::CameraPath path = render::MakePath(
      {.path = args.path, .frames = args.frames, .camera = camera, .light_field = args.dir}, scene);
  render::RequireFrames(path, args.frames, std::to_string(args.frames));
  if (path.cameras.empty()) path.cameras.assign(path.cam_from_world.size(), camera);
  double zoom = 1;
  if (render::IsNamedPath(args.path) && truth.TakesAnyCamera())
    zoom = render::FillingZoom(
               *render::MakeRenderer(scene_pointer, {.renderer = commands::RendererFromName(args.renderer)}),
               path, path.cameras.front())
               .zoom;
  for (CameraModel& each : path.cameras) {
    if (each.width != path.cameras.front().width || each.height != path.cameras.front().height)
      throw Error("--path {}: its pictures differ in size; give a path with one size", args.path);
    each.fx *= zoom;
    each.fy *= zoom;
  }
  return path;
}

nlohmann::json JsonOf(const TemporalSummary& summary, const TemporalArgs& args, const std::string& truth) {
  nlohmann::json report{{"views", summary.views},
                        {"frames", summary.frames},
                        {"width_px", summary.width},
                        {"height_px", summary.height},
                        {"path", args.path},
                        {"truth", truth},
                        {"renderer", summary.renderer},
                        {"results", nlohmann::json::array()}};
  const auto or_null = [](const std::optional<double>& value, bool squared) {
    return value ? nlohmann::json(squared ? *value * *value : *value) : nlohmann::json();
  };
  for (const TemporalScore& score : summary.results)
    report["results"].push_back(
        {{"field", render::FieldName(score.asked.kind)},
         {"field_used", render::FieldName(score.used.kind)},
         {"level", std::to_string(score.used.level)},
         {"proxy", score.proxy},
         {"temporal_error", score.temporal_error},
         {"temporal_error_disc", score.temporal_error_disc},
         {"temporal_energy", score.temporal_error * score.temporal_error},
         {"temporal_energy_disc", score.temporal_error_disc * score.temporal_error_disc},
         {"step_error", or_null(score.step_error, false)},
         {"step_error_disc", or_null(score.step_error_disc, false)},
         {"step_energy", or_null(score.step_error, true)},
         {"step_energy_disc", or_null(score.step_error_disc, true)},
         {"psnr_db", score.psnr_db},
         {"ms_per_frame", score.ms_per_frame},
         {"over_time", score.over_time}});
  return report;
}

void PrintTable(const TemporalSummary& summary, const TemporalArgs& args, const std::string& truth) {
  fmt::print("{}, {} of {}x{} along {}, against {}, {}\n\n", Counted(summary.views, "view"),
             Counted(summary.frames, "picture"), summary.width, summary.height, args.path, truth,
             summary.renderer);
  fmt::print("{:<22} {:<12} {:>6}  {:>9} {:>9}  {:>9} {:>9}  {:>7}  {:>8}\n", "field", "proxy", "level",
             "temporal", "disc", "steps", "disc", "PSNR", "ms");
  const auto or_dash = [](const std::optional<double>& value) {
    return value ? fmt::format("{:.3f}", *value) : "-";
  };
  for (const TemporalScore& score : summary.results)
    fmt::print(
        "{:<22} {:<12} {:>6}  {:9.3f} {:9.3f}  {:>9} {:>9}  {:7.2f}  {:8.1f}{}\n",
        render::FieldName(score.asked.kind), score.proxy,
        render::UsesMesh(score.used.kind) ? std::to_string(score.used.level) : "", score.temporal_error,
        score.temporal_error_disc, or_dash(score.step_error), or_dash(score.step_error_disc), score.psnr_db,
        score.ms_per_frame,
        score.asked.kind == score.used.kind ? "" : "  (used: " + render::FieldName(score.used.kind) + ")");
  fmt::print(
      "\ntemporal: second difference over time of (rendering - truth), RMS, in levels of 255; disc: in the "
      "subject's silhouette; steps: the same at points of the scene, smoothed{}.\n",
      summary.results.empty() || summary.results.front().step_error ? ""
                                                                    : " (not known: the truth has no depth)");
}

int Run(TemporalArgs args) {
  if (!args.strips.empty()) RequireWritable(args.strips);
  const std::string truth_name = TruthNameOf(args);
  const auto truth = TruthFromName(truth_name);
  const auto scene = Load(args);
  std::vector<render::FieldOptions> fields;
  for (const std::string& name : args.fields) {
    fields.push_back(FieldDetails(args.field_details));
    fields.back().kind = render::FieldFromName(name);
  }
  const TemporalOptions options{.path = PathOf(args, scene, *truth),
                                .fields = fields,
                                .proxies = Proxies(args, *scene, fields.front()),
                                .renderer = commands::RendererFromName(args.renderer),
                                .gpu_memory_mb = args.gpu_memory_mb};
  const bool draws = !args.strips.empty() || !args.plot.empty();
  const std::string made_by = draws ? Provenance("temporal_quality " + args.dir) : "";
  Progress progress("evaluating");
  const TemporalSummary summary = EvaluateOverTime(scene, options, *truth, &progress);
  if (!args.strips.empty()) WritePictureFile(args.strips, StripPicture(summary, made_by));
  if (!args.plot.empty()) DrawTemporalChart(summary, args.plot, made_by);
  if (args.json)
    fmt::print("{}\n", JsonText(JsonOf(summary, args, truth_name), 1));
  else
    PrintTable(summary, args, truth_name);
  return 0;
}

}  // namespace
}  // namespace ulf::test

int main(int argc, char** argv) {
  CLI::App app("How restless pictures are along a camera path", "temporal_quality");
  ulf::test::TemporalArgs args;
  ulf::commands::AddSceneOptions(app, args);
  app.add_option("--path", args.path, "Camera path of ulf render")->capture_default_str();
  app.add_option("--truth", args.truth,
                 "True pictures of the path: the simulator, or a folder of frame_00000.png or .exr");
  app.add_option("--frames", args.frames, "Number of pictures of a named path (120)")
      ->check(CLI::Range(3, 100000));
  app.add_option("--width", args.width, "Width of the pictures in pixels")->check(CLI::Range(16, 8192));
  app.add_option("--fields", args.fields, "Blending fields to compare, separated by commas")->delimiter(',');
  ulf::commands::AddFieldDetails(app, args.field_details);
  app.add_option("--proxy", args.proxies, "Geometry, as of ulf evaluate; may be given several times")
      ->allow_extra_args(false);
  app.add_option("--strips", args.strips, "PNG file to write: the middle column of the image over time");
  app.add_option("--plot", args.plot, "Chart of the temporal error over time (.png, .svg, .pdf)");
  app.add_flag("--json", args.json, "Report as one JSON object");
  return ulf::test::RunTool(app, argc, argv, [&] { return ulf::test::Run(args); });
}
