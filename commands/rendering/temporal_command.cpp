#include "commands/rendering/temporal_command.h"

#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include <nlohmann/json.hpp>

#include "commands/options/command_line.h"
#include "commands/rendering/simulated_truth.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/base/output_path.h"
#include "core/base/progress.h"
#include "core/image/files/picture_file.h"
#include "core/image/image.h"
#include "core/light_field/light_field_io.h"
#include "render/gl/make_renderer.h"

namespace ulf::commands {
namespace {

std::string TruthNameOf(const TemporalArgs& args, const std::string& dir) {
  if (!args.truth.empty()) return args.truth;
  const std::string uri = ReadLightField(dir).device_uri;
  if (uri.starts_with("sim:")) return uri;
  throw UsageError(
      "--temporal: {} was not captured from the simulator, so that the true pictures of the path are "
      "unknown; give them as a folder with --truth",
      dir);
}

// A path with a camera for each pose. Where the truth can take any camera, the lens zooms until photographs
// fill the pictures.
render::CameraPath PathOf(const TemporalArgs& args, const SceneArgs& scene_args,
                          const std::shared_ptr<const render::RenderScene>& scene_pointer,
                          const render::TruthSource& truth) {
  const render::RenderScene& scene = *scene_pointer;
  CameraModel camera = scene.views.front().camera.WithoutDistortion();
  if (args.width > 0)
    camera = camera.ScaledTo(args.width, std::max(1, camera.height * args.width / camera.width));
  render::CameraPath path = render::MakePath(
      {.path = args.path, .frames = args.frames, .camera = camera, .light_field = scene_args.dir}, scene);
  render::RequireFrames(path, args.frames, std::to_string(args.frames));
  if (path.cameras.empty()) path.cameras.assign(path.cam_from_world.size(), camera);
  double zoom = 1;
  if (render::IsNamedPath(args.path) && truth.TakesAnyCamera())
    zoom = render::FillingZoom(
        *render::MakeRenderer(scene_pointer, {.renderer = RendererFromName(scene_args.renderer)}), path,
        path.cameras.front());
  for (CameraModel& each : path.cameras) {
    if (each.width != path.cameras.front().width || each.height != path.cameras.front().height)
      throw Error("--temporal {}: its pictures differ in size; give a path with one size", args.path);
    each.fx *= zoom;
    each.fy *= zoom;
  }
  return path;
}

nlohmann::json JsonOf(const render::TemporalSummary& summary, const TemporalArgs& args,
                      const std::string& truth) {
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
  for (const render::TemporalScore& score : summary.results)
    report["results"].push_back(
        {{"field", render::FieldName(score.asked.kind)},
         {"field_used", render::FieldName(score.used.kind)},
         {"level", render::LevelName(score.used.level)},
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

void PrintTable(const render::TemporalSummary& summary, const TemporalArgs& args, const std::string& truth) {
  fmt::print("{}, {} of {}x{} along {}, against {}, {}\n\n", Counted(summary.views, "view"),
             Counted(summary.frames, "picture"), summary.width, summary.height, args.path, truth,
             summary.renderer);
  fmt::print("{:<22} {:<12} {:>6}  {:>9} {:>9}  {:>9} {:>9}  {:>7}  {:>8}\n", "field", "proxy", "level",
             "temporal", "disc", "steps", "disc", "PSNR", "ms");
  const auto or_dash = [](const std::optional<double>& value) {
    return value ? fmt::format("{:.3f}", *value) : "-";
  };
  for (const render::TemporalScore& score : summary.results)
    fmt::print(
        "{:<22} {:<12} {:>6}  {:9.3f} {:9.3f}  {:>9} {:>9}  {:7.2f}  {:8.1f}{}\n",
        render::FieldName(score.asked.kind), score.proxy,
        render::UsesMesh(score.used.kind) ? render::LevelName(score.used.level) : "", score.temporal_error,
        score.temporal_error_disc, or_dash(score.step_error), or_dash(score.step_error_disc), score.psnr_db,
        score.ms_per_frame,
        score.asked.kind == score.used.kind ? "" : "  (used: " + render::FieldName(score.used.kind) + ")");
  fmt::print(
      "\ntemporal: second difference over time of (rendering - truth), RMS, in levels of 255; disc: in the "
      "subject's silhouette; steps: the same at points of the scene, smoothed{}.\n",
      summary.results.empty() || summary.results.front().step_error ? ""
                                                                    : " (not known: the truth has no depth)");
}

}  // namespace

void AddTemporalOptions(CLI::App& sub, TemporalArgs& args) {
  auto* path = sub.add_option(
      "--temporal", args.path,
      "Compare pictures over time along a camera path of ulf render, in place of left-out views");
  sub.add_option("--truth", args.truth,
                 "True pictures of the path: the simulator (sim:studio?seed=7) or a folder of "
                 "frame_00000.png or .exr (the simulator that was captured)")
      ->needs(path);
  sub.add_option("--frames", args.frames,
                 "Number of pictures of a named path (120) or of keyframes (by their times)")
      ->check(CLI::Range(3, 100000))
      ->needs(path);
  sub.add_option("--width", args.width,
                 "Width of the pictures in pixels; they keep their shape (the photographs')")
      ->check(CLI::Range(16, 8192))
      ->needs(path);
  sub.add_option("--strips", args.strips, "PNG file to write: the middle column of the image over time")
      ->needs(path);
}

void CheckTemporalOptions(const TemporalArgs& args) {
  if (args.path.empty()) return;
  if (!args.strips.empty()) {
    if (!args.strips.ends_with(".png"))
      throw UsageError("--strips {}: the picture is written as .png", args.strips);
    RequireWritable(args.strips);
  }
}

int RunTemporal(const TemporalArgs& args, const SceneArgs& scene_args,
                const std::vector<render::FieldOptions>& fields, const std::string& plot, bool json) {
  const std::string truth_name = TruthNameOf(args, scene_args.dir);
  const auto truth = TruthFromName(truth_name);
  const auto scene = Load(scene_args);
  const render::TemporalOptions options{.path = PathOf(args, scene_args, scene, *truth),
                                        .fields = fields,
                                        .proxies = Proxies(scene_args, *scene, fields.front()),
                                        .renderer = RendererFromName(scene_args.renderer),
                                        .gpu_memory_mb = scene_args.gpu_memory_mb};
  Progress progress("evaluating");
  const render::TemporalSummary summary = render::EvaluateOverTime(scene, options, *truth, &progress);
  if (!args.strips.empty()) WritePictureFile(args.strips, render::StripPicture(summary));
  if (!plot.empty()) render::DrawTemporalChart(summary, plot);
  if (json)
    fmt::print("{}\n", JsonText(JsonOf(summary, args, truth_name), 1));
  else
    PrintTable(summary, args, truth_name);
  return kOk;
}

}  // namespace ulf::commands
