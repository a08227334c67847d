#include "render/commands.h"

#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "acquisition/counted.h"
#include "acquisition/error.h"
#include "acquisition/import_export.h"
#include "acquisition/light_field_io.h"
#include "acquisition/number_checks.h"
#include "render/camera_path.h"
#include "render/evaluate.h"
#include "render/renderer.h"
#include "render/video.h"

namespace ulf {
namespace {

constexpr int kLargestPicture = 16384;  // what OpenGL draws into on the machines this was tried on

struct SceneArgs {
  std::string dir;
  std::string subject;
  int size_limit_px = 0;
  double memory_mb = 2048;
  std::string renderer = "gl";
};

struct RenderArgs : SceneArgs {
  std::string path = "orbit";
  std::string field = "subdivision";
  int level = 1;
  int frames = 0;
  int width = 0, height = 0;
  double zoom = 0;  // 0: just enough to fill the pictures of a named path
  double fps = 30;
  std::string out = "orbit.mp4";
  bool show_field = false;
  bool no_fill = false;
  bool json = false;
};

struct EvaluateArgs : SceneArgs {
  int every = 8;
  std::vector<std::string> fields{"nearest", "linear", "subdivision", "lumigraph", "lumigraph-per-pixel"};
  int level = 1;
  bool json = false;
};

RendererKind RendererFromName(const std::string& name) {
  return name == "reference" ? RendererKind::kReference : RendererKind::kGl;
}

std::shared_ptr<const RenderScene> Load(const SceneArgs& args) {
  SceneOptions options{.size_limit_px = args.size_limit_px, .memory_limit_mb = args.memory_mb};
  if (!args.subject.empty()) options.subject = ParseSubject(args.subject);
  const LightField light_field = ReadLightField(args.dir);
  Progress progress("loading");
  return LoadScene(light_field, options, &progress);
}

// The first view's camera without distortion, at another size if asked: one of width and height keeps the
// shape, both keep the horizontal field of view.
CameraModel OutputCamera(const RenderScene& scene, const RenderArgs& args) {
  CameraModel camera = scene.views.front().camera.WithoutDistortion();
  if (args.width == 0 && args.height == 0) return camera;
  const int width =
      args.width > 0
          ? args.width
          : std::max(1, static_cast<int>(std::lround(1.0 * camera.width * args.height / camera.height)));
  const int kept_height =
      std::max(1, static_cast<int>(std::lround(1.0 * camera.height * width / camera.width)));
  camera = camera.ScaledTo(width, kept_height);
  if (args.height > 0 && args.height != kept_height) {
    camera.cy += 0.5 * (args.height - kept_height);
    camera.height = args.height;
  }
  return camera;
}

int RunRender(const RenderArgs& args) {
  const FieldOptions field{.kind = FieldFromName(args.field), .level = args.level};
  const auto scene = Load(args);
  spdlog::info("{}", scene->mesh.Description());
  const auto renderer =
      MakeRenderer(scene, {field, RendererFromName(args.renderer), !args.no_fill, args.show_field});
  if (renderer->field().kind != field.kind)
    spdlog::warn("{} weights are not to be had from these viewpoints: {} weights are used", args.field,
                 FieldName(renderer->field().kind));

  const int frames = args.frames > 0 ? args.frames : IsSinglePicture(args.out) ? 1 : 120;
  CameraPath path = MakePath(args.path, *scene, frames);
  if (IsSinglePicture(args.out)) path.cam_from_world.resize(1);
  CameraModel asked_camera = OutputCamera(*scene, args);
  const bool named_path = args.path == "orbit" || args.path == "dolly";
  const double zoom = args.zoom > 0 ? args.zoom
                      : named_path  ? ZoomThatFills(*renderer, path, asked_camera)
                                    : 1.0;
  if (zoom > 1)
    spdlog::info("zoomed {:.2f} times, so that photographs fill the pictures (--zoom 1: not)", zoom);
  asked_camera.fx *= zoom;
  asked_camera.fy *= zoom;
  const auto sink = OpenPictureSink(args.out, args.fps);
  Progress progress("rendering");
  double ms = 0;
  long filled = 0, empty = 0, pixels = 0;
  for (std::size_t i = 0; i < path.cam_from_world.size(); ++i) {
    const bool own_camera = !path.cameras.empty() && args.width == 0 && args.height == 0;
    const CameraModel& camera = own_camera ? path.cameras[i] : asked_camera;
    const Rendering picture = renderer->Render(camera, path.cam_from_world[i]);
    sink->Add(Srgb8FromLinear(picture.linear));
    if (i > 0 || path.cam_from_world.size() == 1) ms += picture.ms;  // drivers compile at the first frame
    filled += picture.filled_px;
    empty += picture.empty_px;
    pixels += static_cast<long>(picture.linear.total());
    progress.Show(static_cast<double>(i + 1) / static_cast<double>(path.cam_from_world.size()));
  }
  sink->Close();
  const double count = std::max(1.0, static_cast<double>(path.cam_from_world.size()) - 1);
  if (args.json) {
    const nlohmann::json report{{"frames", path.cam_from_world.size()},
                                {"output", args.out},
                                {"field", FieldName(renderer->field().kind)},
                                {"level", renderer->field().level},
                                {"renderer", renderer->Name()},
                                {"ms_per_frame", ms / count},
                                {"filled_share", static_cast<double>(filled) / static_cast<double>(pixels)},
                                {"empty_share", static_cast<double>(empty) / static_cast<double>(pixels)}};
    fmt::print("{}\n", report.dump(1));
    return kOk;
  }
  fmt::print("{}: {}, {} weights, {:.1f} ms each on {}; filled {:.2f} %, empty {:.2f} % of the pixels\n",
             args.out, Counted(path.cam_from_world.size(), "picture"), FieldName(renderer->field().kind),
             ms / count, renderer->Name(), 100.0 * static_cast<double>(filled) / static_cast<double>(pixels),
             100.0 * static_cast<double>(empty) / static_cast<double>(pixels));
  return kOk;
}

nlohmann::json JsonOf(const MeanScore& mean) {
  if (mean.views == 0) return nullptr;
  return {{"views", mean.views},
          {"psnr_db", mean.psnr_db},
          {"ssim", mean.ssim},
          {"psnr_disc_db", mean.psnr_disc_db},
          {"ssim_disc", mean.ssim_disc}};
}

nlohmann::json JsonOf(const FieldScore& result) {
  // The main figures are those of the views inside the hull, of all where none is inside.
  const MeanScore& main = result.inside.views > 0 ? result.inside : result.all;
  nlohmann::json views = nlohmann::json::array();
  for (const ViewScore& score : result.views)
    views.push_back({{"id", score.view_id},
                     {"rim", score.on_rim},
                     {"psnr_db", score.frame.psnr_db},
                     {"ssim", score.frame.ssim},
                     {"psnr_disc_db", score.disc.psnr_db},
                     {"ssim_disc", score.disc.ssim},
                     {"filled_px", score.filled_px},
                     {"empty_px", score.empty_px},
                     {"ms", score.ms}});
  return {{"field", FieldName(result.asked.kind)},
          {"field_used", FieldName(result.used.kind)},
          {"level", result.used.level},
          {"proxy", result.proxy},
          {"psnr_db", main.psnr_db},
          {"ssim", main.ssim},
          {"psnr_disc_db", main.psnr_disc_db},
          {"ssim_disc", main.ssim_disc},
          {"ms_per_frame", result.ms_per_frame},
          {"filled_px", result.filled_px},
          {"empty_px", result.empty_px},
          {"inside", JsonOf(result.inside)},
          {"rim", JsonOf(result.rim)},
          {"all", JsonOf(result.all)},
          {"per_view", views}};
}

void PrintTable(const EvaluateSummary& summary) {
  fmt::print("{} views, {} left out, {}x{}, plane proxy, {}\n{}\n\n", summary.views, summary.held_out,
             summary.width, summary.height, summary.renderer, summary.viewpoints);
  fmt::print("{:<22} {:>6}  {:>7} {:>6}  {:>7} {:>6}  {:>7} {:>6}  {:>8} {:>9} {:>8}\n", "field", "level",
             "PSNR", "SSIM", "disc", "SSIM", "rim", "SSIM", "ms", "filled px", "empty");
  for (const FieldScore& result : summary.results) {
    const MeanScore& main = result.inside.views > 0 ? result.inside : result.all;
    const std::string rim = result.rim.views > 0
                                ? fmt::format("{:7.2f} {:6.4f}", result.rim.psnr_db, result.rim.ssim)
                                : fmt::format("{:>7} {:>6}", "-", "-");
    const bool has_level =
        result.used.kind == FieldKind::kLinear || result.used.kind == FieldKind::kSubdivision;
    const std::string name = FieldName(result.asked.kind);
    fmt::print("{:<22} {:>6}  {:7.2f} {:6.4f}  {:7.2f} {:6.4f}  {}  {:8.1f} {:9} {:8}{}\n", name,
               has_level ? std::to_string(result.used.level) : "", main.psnr_db, main.ssim, main.psnr_disc_db,
               main.ssim_disc, rim, result.ms_per_frame, result.filled_px, result.empty_px,
               result.asked.kind == result.used.kind ? "" : "  (really " + FieldName(result.used.kind) + ")");
  }
  const int rim_views = summary.results.empty() ? 0 : summary.results.front().rim.views;
  if (rim_views == summary.held_out)
    fmt::print("\nPSNR in dB, means over all {} left-out views: each of them lies on the rim of the hull.\n",
               rim_views);
  else if (rim_views > 0)
    fmt::print("\nPSNR in dB, means over the {} left-out views inside the hull; the {} on its rim apart.\n",
               summary.held_out - rim_views, rim_views);
}

int RunEvaluate(const EvaluateArgs& args) {
  EvaluateOptions options{.every = args.every, .renderer = RendererFromName(args.renderer)};
  for (const std::string& name : args.fields)
    options.fields.push_back({.kind = FieldFromName(name), .level = args.level});
  const auto scene = Load(args);
  Progress progress("evaluating");
  const EvaluateSummary summary = Evaluate(*scene, options, &progress);
  if (!args.json) {
    PrintTable(summary);
    return kOk;
  }
  nlohmann::json report{{"views", summary.views},
                        {"held_out", summary.held_out},
                        {"width_px", summary.width},
                        {"height_px", summary.height},
                        {"renderer", summary.renderer},
                        {"viewpoints", summary.viewpoints},
                        {"results", nlohmann::json::array()}};
  for (const FieldScore& result : summary.results) report["results"].push_back(JsonOf(result));
  fmt::print("{}\n", report.dump(1));
  return kOk;
}

void AddSceneOptions(CLI::App& sub, SceneArgs& args) {
  sub.add_option("dir", args.dir, "The light field: a folder with a journal or a transforms.json")
      ->required();
  sub.add_option(
      "--subject", args.subject,
      "Centre and radius x,y,z,r of the subject, where the light field does not say or another is wanted");
  sub.add_option("--size-limit", args.size_limit_px,
                 "Longer side of the loaded photographs in pixels; 0: as they are")
      ->check(NonNegative());
  sub.add_option("--memory-mb", args.memory_mb, "Photographs are halved until they fit")->check(Positive());
  sub.add_option("--renderer", args.renderer, "gl (OpenGL without a window) or reference (plain, slow)")
      ->check(CLI::IsMember({"gl", "reference"}));
}

void AddRender(CLI::App& app, ChosenCommand& chosen) {
  const auto args = std::make_shared<RenderArgs>();
  CLI::App* sub = app.add_subcommand("render", "Renders a light field along a camera path");
  AddSceneOptions(*sub, *args);
  sub->add_option(
      "--path", args->path,
      "orbit, dolly (towards the subject), a TUM pose file, or another light field whose poses to take");
  sub->add_option("--field", args->field,
                  "Blending weights: subdivision, linear, lumigraph, lumigraph-per-pixel, nearest");
  sub->add_option("--level", args->level, "Levels of subdivision")->check(CLI::Range(0, 3));
  sub->add_option("--frames", args->frames, "Pictures on a named path (120; 1 for a single picture)")
      ->check(Positive());
  sub->add_option("--width", args->width, "Of the pictures; alone it keeps their shape")
      ->check(CLI::Range(1, kLargestPicture));
  sub->add_option("--height", args->height, "Of the pictures; alone it keeps their shape")
      ->check(CLI::Range(1, kLargestPicture));
  sub->add_option(
         "--zoom", args->zoom,
         "Focal length over the photographs'; if not said, orbit and dolly zoom until photographs fill them")
      ->check(Positive());
  sub->add_option("--fps", args->fps, "Of a video")->check(Positive());
  sub->add_option("-o,--output", args->out,
                  "OUT.mp4, OUT.png (one picture), or a folder for numbered pictures");
  sub->add_flag("--blending-field", args->show_field, "Show each view's weight in a colour of its own");
  sub->add_flag("--no-fill", args->no_fill, "Leave black what no weighted view covers");
  sub->add_flag("--json", args->json, "Report as one JSON object");
  sub->footer("Example: ulf render lightfield --path orbit --width 640 -o orbit.mp4");
  sub->callback([&chosen, args] { chosen = [args] { return RunRender(*args); }; });
}

void AddEvaluate(CLI::App& app, ChosenCommand& chosen) {
  const auto args = std::make_shared<EvaluateArgs>();
  CLI::App* sub =
      app.add_subcommand("evaluate", "Leaves views out, renders them, and compares with the photographs");
  AddSceneOptions(*sub, *args);
  sub->add_option("--every", args->every, "Leave out every k-th view")->check(CLI::Range(2, 1000000));
  sub->add_option("--fields", args->fields, "Blending weights to compare, comma-separated")->delimiter(',');
  sub->add_option("--level", args->level, "Levels of subdivision")->check(CLI::Range(0, 3));
  sub->add_flag("--json", args->json, "Report as one JSON object");
  sub->footer("Example: ulf evaluate lightfield --every 8 --fields subdivision,lumigraph");
  sub->callback([&chosen, args] { chosen = [args] { return RunEvaluate(*args); }; });
}

}  // namespace

void AddRenderCommands(CLI::App& app, ChosenCommand& chosen) {
  AddRender(app, chosen);
  AddEvaluate(app, chosen);
}

}  // namespace ulf
