#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands/options/chosen_model.h"
#include "commands/options/command_line.h"
#include "commands/options/option_values.h"
#include "commands/options/subcommands.h"
#include "commands/rendering/render_settings.h"
#include "commands/reports/explain.h"
#include "core/base/atomic_file.h"
#include "core/base/available_memory.h"
#include "core/base/counted.h"
#include "core/base/json_text.h"
#include "core/base/output_path.h"
#include "core/base/progress.h"
#include "core/base/shell_word.h"
#include "core/geometry/angles.h"
#include "render/fields/field_options.h"
#include "render/output/camera_path.h"
#include "render/output/path_files.h"
#include "render/output/picture_files.h"
#include "render/output/tiled_rendering.h"
#include "render/output/video.h"
#include "render/proxy/mesh_file.h"
#include "render/proxy/proxy_choice.h"
#include "render/quality/choice.h"

namespace ulf::commands {
namespace {

constexpr int kLargestPicture = 16384;  // pixels: the largest that was tried (large_long_test)

// Returns the camera with the requested size: width or height alone keeps the shape, both keep the horizontal
// field of view.
CameraModel Sized(CameraModel camera, const RenderArgs& args) {
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

// Returns the camera with the requested lens.
CameraModel WithLens(CameraModel camera, const RenderArgs& args) {
  const double focal_px =
      args.fov_deg > 0 ? 0.5 * camera.width / std::tan(Radians(0.5 * args.fov_deg)) : args.focal_px;
  if (focal_px > 0) camera.fx = camera.fy = focal_px;
  return camera;
}

// Returns the requested path, with a camera for each pose. The requested lens is that of a named path's first
// picture.
render::CameraPath PathOf(const RenderArgs& args, const render::RenderScene& scene, int frames) {
  const CameraModel asked = WithLens(Sized(scene.views.front().camera.WithoutDistortion(), args), args);
  render::CameraPath path = render::MakePath(
      {.path = args.path, .frames = frames, .camera = asked, .fps = args.fps, .light_field = args.dir},
      scene);
  if (path.cameras.empty()) path.cameras.assign(path.cam_from_world.size(), asked);
  if (!render::IsNamedPath(args.path))
    for (CameraModel& camera : path.cameras) camera = WithLens(Sized(camera, args), args);
  if (args.aperture.IsSet()) path.apertures.clear();
  return path;
}

// Returns how many times the pictures were zoomed.
double Zoom(const RenderArgs& args, render::Renderer& renderer, render::CameraPath& path) {
  const bool lens_is_free = render::IsNamedPath(args.path) && args.focal_px == 0 && args.fov_deg == 0;
  // A subject that is cut out never fills a picture.
  render::FillingLens filling{args.zoom > 0 ? args.zoom : 1.0};
  if (args.zoom == 0 && lens_is_free && !renderer.scene().is_cut_out)
    filling = render::FillingZoom(renderer, path, path.cameras.front());
  const double zoom = filling.zoom;
  if (args.zoom == 0 && zoom > 1)
    spdlog::info("zoomed {:.2f} times, so that photographs {} (--zoom 1 switches this off)", zoom,
                 filling.black_at_worst > 0
                     ? fmt::format("almost fill the pictures: up to {:.2g} % of one stays black",
                                   100 * filling.black_at_worst)
                     : "fill the pictures");
  for (CameraModel& camera : path.cameras) {
    camera.fx *= zoom;
    camera.fy *= zoom;
  }
  return zoom;
}

// Says it where a picture's name was given and the path has more than one picture.
void WarnOfOthers(const RenderArgs& args, const render::FrameRange& range, int all) {
  const int asked = std::min(range.end.value_or(all), all) - range.first;
  if (asked < 2) return;
  const std::string others = asked == 2 ? "the other one is" : fmt::format("the other {} are", asked - 1);
  spdlog::warn(
      "{}: holds one picture, number {} of the path; {} not drawn: name a video (OUT.mp4) or a folder for "
      "all, or another picture by --frames {}:{}{}",
      args.out, range.first, others, range.first + 1, range.first + 2,
      range.count > 0 ? fmt::format("/{}", all) : "");
}

// The statistics of a run of ulf render.
struct RenderReport {
  int rendered = 0, kept = 0;
  int blank = 0;  // empty pictures
  double ms = 0;  // all pictures except the first, when drivers compile shaders
  long filled = 0, empty = 0, pixels = 0;

  void Add(const render::Rendering& picture) {
    ms = rendered <= 1 ? picture.ms : ms + picture.ms;
    ++rendered;
    filled += picture.filled_px;
    empty += picture.empty_px;
    blank += picture.empty_px == static_cast<long>(picture.linear.total());
    pixels += static_cast<long>(picture.linear.total());
  }
  double MsPerFrame() const { return ms / std::max(1, rendered - 1); }
  double Share(long count) const {
    return static_cast<double>(count) / static_cast<double>(std::max(1L, pixels));
  }
};

std::string ClippedWords(const render::PhotographStore::Counts& counts) {
  return fmt::format(
      "clipped {:.2f} % of the pixels of {} read{}",
      100.0 * static_cast<double>(counts.clipped_px) / static_cast<double>(counts.pixels),
      Counted(counts.photographs, "photograph"),
      counts.masked_px == 0
          ? ""
          : fmt::format(
                "; {:.0f} % of these, in longer exposures, have no weight where others show the place",
                100.0 * static_cast<double>(counts.masked_px) / static_cast<double>(counts.clipped_px)));
}

void Print(const RenderArgs& args, const render::Renderer& renderer, const RenderReport& report,
           const std::vector<ModelChoice>& explained) {
  const auto photographs = renderer.scene().store->counts();
  if (report.blank > 0)
    spdlog::warn(
        "pictures that show nothing: {} of {}; no view sees what the camera looks at there: is the path in "
        "this light field's world, and the subject where the views look (--subject x,y,z,radius)?",
        report.blank, report.rendered);
  constexpr double kFar = 0.25;  // share of the pixels. Guessed.
  if (const double unseen = report.Share(report.filled + report.empty);
      report.blank == 0 && unseen > kFar && !renderer.scene().is_cut_out &&
      renderer.field().kind != render::FieldKind::kNearest)
    spdlog::warn(
        "{:.0f} % of the pixels are empty or filled from other views: the path is far outside the recorded "
        "viewpoints",
        100 * unseen);
  if (args.json) {
    nlohmann::ordered_json json{{"frames", report.rendered},
                                {"kept", report.kept},
                                {"output", args.out},
                                {"field", render::FieldName(renderer.field().kind)},
                                {"level", std::to_string(renderer.field().level)},
                                {"proxy", renderer.scene().proxy->Name()},
                                {"renderer", renderer.Name()},
                                {"ms_per_frame", report.MsPerFrame()},
                                {"filled_share", report.Share(report.filled)},
                                {"empty_share", report.Share(report.empty)},
                                {"photographs",
                                 {{"read", photographs.photographs},
                                  {"pixels", photographs.pixels},
                                  {"clipped", photographs.clipped_px},
                                  {"clipped_without_weight", photographs.masked_px}}}};
    if (args.explain) AddExplained(json, explained);
    fmt::print("{}\n", JsonText(json, 1));
    return;
  }
  if (report.rendered == 0 && report.kept > 0) {
    fmt::print("{}: {}, all existed already\n", args.out, Counted(report.kept, "picture"));
    return;
  }
  const std::string kept =
      report.kept > 0 ? fmt::format("{} existed already, ", Counted(report.kept, "picture")) : "";
  fmt::print("{}: {}{}, {} weights, {:.1f} ms each on {}; filled {:.2f} %, empty {:.2f} % of the pixels\n",
             args.out, kept, Counted(report.rendered, "picture"), render::FieldName(renderer.field().kind),
             report.MsPerFrame(), renderer.Name(), 100 * report.Share(report.filled),
             100 * report.Share(report.empty));
  if (photographs.clipped_px > 0) fmt::print("{}\n", ClippedWords(photographs));
}

render::PictureEncoding EncodingOf(const RenderArgs& args) {
  const render::PictureEncoding encoding{
      .format = render::FormatOf(args.out, args.format),
      .exposure_stops = args.exposure_stops,
      .background =
          args.background.empty() ? std::nullopt : std::optional(BackgroundFromText(args.background)),
      .closes_narrow_gaps = !args.no_fill,
      .exr_compression = args.exr_compression == "piz" ? ExrCompression::kPiz : ExrCompression::kZip};
  if (args.weights && encoding.format != render::PictureFormat::kExr)
    throw UsageError("--weights: only EXR holds layers; give -o OUT.exr or --format exr");
  return encoding;
}

std::shared_ptr<const render::RenderScene> SceneOf(const RenderArgs& args,
                                                   const render::PictureEncoding& encoding) {
  FieldDetails(args.field_details);  // checks before anything is loaded
  if (args.field != render::kAuto) render::FieldFromName(args.field);
  SceneArgs scene_args = args;
  if (encoding.format != render::PictureFormat::kPng) scene_args.form = render::PhotographForm::kLinear;
  const auto scene = Load(scene_args);
  spdlog::info("{}", scene->ViewpointsInWords());
  return scene;
}

// Returns the options that choose this proxy and this field without a comparison.
std::string OptionsFor(const RenderArgs& args, const render::Choice& choice) {
  const render::FieldOptions& field = choice.field;
  const render::FieldOptions usual, details = FieldDetails(args.field_details);
  const bool was_sought = args.proxy == render::kAuto || args.proxy == render::kFittedPlane;
  std::string text =
      fmt::format("--proxy {} --field {}", was_sought ? choice.proxy->Name() : ShellWord(args.proxy),
                  render::FieldName(field.kind));
  if (field.kind == render::FieldKind::kSubdivision) {
    if (field.level != usual.level) text += " --level " + std::to_string(field.level);
    if (field.rules != usual.rules) text += " --subdivision " + args.field_details.rules;
  }
  if (field.kind == render::FieldKind::kSoft && field.soft_width != usual.soft_width)
    text += fmt::format(" --soft-width {}", field.soft_width);
  if (details.lumigraph_k != usual.lumigraph_k)
    text += fmt::format(" --lumigraph-views {}", details.lumigraph_k);
  if (details.lumigraph_resolution != usual.lumigraph_resolution)
    text += fmt::format(" --lumigraph-resolution {}", details.lumigraph_resolution);
  if (details.lumigraph_triangles != usual.lumigraph_triangles)
    text += fmt::format(" --lumigraph-triangles {}", details.lumigraph_triangles);
  return text;
}

struct ChosenRenderer {
  std::unique_ptr<render::Renderer> renderer;
  std::vector<ModelChoice> explained;
};

ChosenRenderer ChosenRendererOf(const RenderArgs& args, const render::PictureEncoding& encoding,
                                const std::shared_ptr<const render::RenderScene>& plain) {
  const std::string field = args.field == render::kAuto && args.aperture.IsSet()
                                ? render::FieldName(render::FieldKind::kSubdivision)
                                : args.field;
  render::FieldOptions details = FieldDetails(args.field_details);
  if (field != render::kAuto) details.kind = render::FieldFromName(field);
  const render::RendererKind kind = RendererFromName(args.renderer);
  const ChosenModel chosen = ChooseModel(args, plain, args.proxy, field, details, kind);
  const auto& [scene, choice, explained] = chosen;
  LogExplanation(args.explain, args.json, choice.why, explained);
  if (!choice.candidates.empty())
    spdlog::info("to skip this comparison the next time: {}", OptionsFor(args, choice));
  if (args.proxy == render::kAuto &&
      !std::filesystem::exists(std::filesystem::path(args.dir) / render::kMeshProxyFile))
    spdlog::info("a mesh usually gives better pictures; make it with: ulf proxy {}", ShellWord(args.dir));
  const render::RenderOptions options{.field = choice.field,
                                      .renderer = kind,
                                      .fill = !args.no_fill,
                                      .show_field = args.show_field,
                                      .depth = encoding.format == render::PictureFormat::kExr,
                                      .weights = args.weights,
                                      .gpu_memory_mb = args.gpu_memory_mb};
  return {RendererOf(args, chosen, options), explained};
}

int RunRender(const RenderArgs& args) {
  const render::FrameRange range = render::ParseFrames(args.frames);
  render::PictureEncoding encoding = EncodingOf(args);
  CheckApertureOptions(args.aperture, args.dir);
  const bool single = render::IsSinglePicture(args.out);
  if (render::IsVideo(args.out))
    RequireWritable(args.out);
  else
    RequireFolderCanBeMade(single ? FolderOf(args.out).string() : args.out);
  const auto plain = SceneOf(args, encoding);
  render::CameraPath path = PathOf(args, *plain, single && args.frames.empty() ? 1 : range.count);
  render::RequireFrames(path, range.count, args.frames);
  const int all = static_cast<int>(path.cam_from_world.size());
  if (range.first >= all)
    throw UsageError("--frames {}: the path has {}, counted from 0", args.frames, Counted(all, "picture"));
  if (range.end.value_or(all) > all)
    spdlog::warn("--frames {}: the path ends after {}", args.frames, Counted(all, "picture"));
  const int end = single ? range.first + 1 : std::min(range.end.value_or(all), all);
  encoding.knows_colors = plain->knows_colors;
  for (int i = range.first; i < end; ++i) {
    const CameraModel& camera = path.cameras[static_cast<std::size_t>(i)];
    render::RequireMemory(camera.width, camera.height, encoding, AvailableMemory());
  }
  if (single) WarnOfOthers(args, range, all);
  const bool fills_folder = !single && !render::IsVideo(args.out);
  std::map<std::string, std::string> settings;
  if (fills_folder) {
    settings = SettingsKnownEarly(args, *plain, path);
    render::RequireFolderFor(args.out, settings, NamedChoices(args), args.overwrite);
  }
  const auto [renderer, explained] = ChosenRendererOf(args, encoding, plain);
  const double zoom = Zoom(args, *renderer, path);
  if (args.aperture.IsSet()) path.apertures = AperturesAlong(args.aperture, path, renderer->scene());
  if (!path.apertures.empty()) {
    RequireRings(renderer->field(), renderer->scene().mesh);
    WarnOfWidth(path.apertures, renderer->scene());
  }

  if (fills_folder) AddChoices(*renderer, zoom, path.apertures, settings);
  std::unique_ptr<render::PictureSink> video;
  std::unique_ptr<render::PictureFiles> files;
  if (render::IsVideo(args.out))
    video = render::OpenPictureSink(args.out, args.fps);
  else
    files = std::make_unique<render::PictureFiles>(args.out, encoding, settings, args.overwrite);
  Progress progress("rendering");
  RenderReport report;
  for (int i = range.first; i < end; ++i) {
    if (files && files->Has(i)) {
      ++report.kept;
      continue;
    }
    const auto at = static_cast<std::size_t>(i);
    if (!path.apertures.empty()) renderer->SetAperture(path.apertures[at]);
    if (i + 1 < end) renderer->Prefetch(path.cameras[at + 1], path.cam_from_world[at + 1]);
    const render::Rendering picture =
        render::RenderInTiles(*renderer, path.cameras[at], path.cam_from_world[at]);
    if (video)
      video->Add(render::DisplayPicture(picture, encoding));
    else
      files->Write(i, picture);
    report.Add(picture);
    progress.Show(static_cast<double>(i + 1 - range.first) / (end - range.first),
                  fmt::format("picture {}", i));
  }
  if (video) video->Close();
  Print(args, *renderer, report, explained);
  return kOk;
}

}  // namespace

void AddRenderCommand(CLI::App& app, ChosenCommand& chosen) {
  const auto [sub, args] =
      NewSubcommand(app, chosen, "render", "Renders a light field along a camera path", RunRender);
  AddSceneOptions(*sub, *args);
  OfferValues(
      sub->add_option(
          "--path", args->path,
          "Camera path (orbit): orbit, rise (across rows of views), sweep (along one), dolly (towards the "
          "subject), vertigo (a dolly that zooms out), spiral, walk (through the "
          "views), a file of TUM poses, another light field "
          "or set (its poses, without its photographs), or a JSON file of keyframes or of nerfstudio's "
          "viewer"),
      "orbit,rise,sweep,dolly,vertigo,spiral,walk,FILE");
  OfferValues(sub->add_option("--field", args->field,
                              "Blending field (auto: the best on left-out views): auto, subdivision, linear, "
                              "lumigraph, lumigraph-per-pixel, soft, nearest"),
              kKnownFields);
  AddFieldDetails(*sub, args->field_details);
  OfferValues(
      sub->add_option("--proxy", args->proxy,
                      "Geometry for the photographs (auto: the best on left-out views): auto, plane (through "
                      "the subject, facing the camera), plane:0.9 (at that share of its distance), "
                      "plane:fitted (where left-out views are shown best), plane:x,y,z,d (normal . point = "
                      "d), planes (the few on which most tracked points lie), points (the tracked points, "
                      "triangulated in each picture), mesh (DIR/proxy.ply, of the capture or ulf proxy), "
                      "soft (the same with the views' depth maps in DIR/depth), or a PLY or OBJ file"),
      kKnownProxies);
  sub->add_option("--frames", args->frames,
                  "N: number of pictures of a named path (120; 1 for a single picture) or of keyframes (by "
                  "their times); other paths have a picture for each pose. A:B: only the pictures A to B - "
                  "1; A:B/N: those of a path of N");
  sub->add_option("--width", args->width,
                  "Width of the pictures in pixels (the photographs'); alone it keeps their shape")
      ->check(CLI::Range(1, kLargestPicture));
  sub->add_option("--height", args->height,
                  "Height of the pictures in pixels (the photographs'); alone it keeps their shape")
      ->check(CLI::Range(1, kLargestPicture));
  auto* focal = sub->add_option("--focal-px", args->focal_px,
                                "Focal length in pixels of the pictures (the photographs' or the path's); of "
                                "a vertigo's first picture")
                    ->check(Positive());
  sub->add_option("--fov-deg", args->fov_deg, "The same as a horizontal field of view in degrees")
      ->check(CLI::Range(0.01, 179.0))
      ->excludes(focal);
  sub->add_option("--zoom", args->zoom,
                  "Factor of the focal length (named paths without a given lens zoom until photographs fill "
                  "the pictures)")
      ->check(Positive());
  AddApertureOptions(*sub, args->aperture);
  sub->add_option("--fps", args->fps, "Frame rate of a video (30)")->check(Positive());
  sub->add_option("-o,--output", args->out,
                  "OUT.mp4, OUT.png or OUT.exr (one picture), or a folder for numbered pictures; a render "
                  "that was stopped keeps the pictures in the folder and continues")
      ->required();
  sub->add_option("--format", args->format,
                  "Format of pictures: png, png16 (16 bits), exr (linear light, depth, confidence) (png)")
      ->check(CLI::IsMember({"png", "png16", "exr"}));
  sub->add_option("--exr-compression", args->exr_compression, "Compression of EXR: zip or piz (zip)")
      ->check(CLI::IsMember({"zip", "piz"}));
  sub->add_option("--exposure", args->exposure_stops,
                  "Make PNG and video brighter by this many stops (0); EXR keeps the light")
      ->check(CLI::Range(-100.0, 100.0));
  sub->add_option("--background", args->background,
                  "What is laid behind a subject that is cut out (a turntable's): white, black or R,G,B "
                  "(default: PNG and EXR are transparent there, a video black)");
  sub->add_flag("--weights", args->weights, "Write a layer with each view's weight into EXR files (slow)");
  sub->add_flag(
      "--overwrite", args->overwrite,
      "Replace the pictures in the folder; removes all of them if they were rendered with other settings");
  sub->add_flag("--blending-field", args->show_field, "Show the blending field: a colour for each view");
  sub->add_flag("--no-fill", args->no_fill, "Leave pixels black that the field's own views do not see");
  sub->add_flag("--explain", args->explain, "Print why this proxy and this blending field were chosen");
  sub->add_flag("--json", args->json, "Report as one JSON object");
  sub->footer("Example: ulf render lightfield --path orbit --width 640 -o orbit.mp4");
}

}  // namespace ulf::commands
