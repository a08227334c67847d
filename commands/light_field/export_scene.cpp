#include "commands/light_field/export_scene.h"
#include "commands/options/option_values.h"
#include "commands/options/subcommands.h"

#include <fmt/core.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <tuple>

#include "commands/options/chosen_model.h"
#include "commands/options/mesh_option.h"
#include "commands/options/scene_options.h"
#include "core/base/atomic_file.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/base/progress.h"
#include "core/base/stop_signal.h"
#include "core/geometry/angles.h"
#include "core/image/files/png_picture.h"
#include "core/image/undistortion.h"
#include "core/light_field/exchange/export_light_field.h"
#include "core/light_field/exchange/staged_folder.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/formats/transforms_camera.h"
#include "render/fields/field_options.h"
#include "render/output/gltf_file.h"
#include "render/output/quilt.h"
#include "render/output/surface_views.h"
#include "render/output/texture_atlas.h"
#include "render/proxy/mesh_resolution.h"
#include "render/proxy/proxy_choice.h"

namespace ulf::commands {
namespace {

namespace fs = std::filesystem;

struct SceneExportArgs : SceneArgs {
  std::string output;
  bool json = false;
};

struct GltfArgs : SceneExportArgs {
  std::string mesh = "mesh";
  int texture_px = 8192;
  int triangles = 500000;
};

struct QuiltArgs : SceneExportArgs {
  std::string display = "portrait";
  std::string tiles, size;
  double aspect = 0;
  double cone_deg = 0;
  double zoom = 1;
  std::string proxy = render::kAuto, field = render::kAuto;
};

std::string LightFieldName(const std::string& dir) {
  const fs::path path = fs::absolute(dir).lexically_normal();
  const fs::path name = path.has_filename() ? path.filename() : path.parent_path().filename();
  const std::string text = (fs::is_directory(path) ? name : path.parent_path().filename()).string();
  return text.empty() ? "light_field" : text;
}

void ThrowIfStopped() {
  if (StopOnSignal::Requested()) throw Error("stopped before the end, as asked; nothing was exported");
}

// ---- glTF ----

// The largest ratio of a triangle's edge to its distance from a view: larger ones reach out of pictures, and
// charts take only whole triangles. Guessed.
constexpr double kMostSlope = 0.04;

std::vector<render::GltfCamera> GltfCamerasOf(const LightField& light_field) {
  std::vector<CameraModel> straight;
  for (std::size_t i = 0; i < light_field.cameras.size(); ++i)
    straight.push_back(
        UndistortionOf(light_field.cameras[i], fmt::format("{}: camera {}", light_field.root.string(), i + 1))
            .to);
  std::vector<render::GltfCamera> cameras;
  for (const View& view : light_field.views) {
    nlohmann::json extras = {{"image", view.image_path}};
    WriteCamera(light_field.CameraOf(view), extras);
    cameras.push_back({fs::path(view.image_path).stem().string(),
                       straight[static_cast<std::size_t>(view.camera)], view.cam_from_world,
                       std::move(extras)});
  }
  return cameras;
}

int RunGltf(const GltfArgs& args) {
  const LightField light_field = ReadLightField(args.dir);
  RequireOutside(light_field.root, args.output);
  StagedFolder folder(args.output);
  // This comes before photographs, because a missing mesh is the most frequent obstacle.
  RequireProxyOfLightField(args.mesh, args.dir);
  const auto proxy =
      render::ProxyFromName(args.mesh, render::SubjectOf(light_field, OptionsOf(args).subject), args.dir);
  if (!proxy->Occluder())
    throw UsageError("--mesh {}: is no mesh; give 'mesh', which ulf proxy makes, or a PLY or OBJ file",
                     args.mesh);
  const StopOnSignal signals;
  Progress progress("export", args.json);
  render::GltfModel model;
  model.name = LightFieldName(args.dir);
  model.cameras = GltfCamerasOf(light_field);
  model.units = light_field.units;
  std::shared_ptr<const render::RenderScene> scene = render::LoadScene(light_field, OptionsOf(args));
  model.up_in_world = scene->up_in_world;
  constexpr double kNearOfRadius = 0.01;  // cameras keep this distance from surfaces, in any unit
  model.near_distance = kNearOfRadius * scene->subject.radius;
  if (const auto light = LightOf(args, *scene, proxy)) scene = render::WithLight(*scene, *light);
  const auto most_triangles = static_cast<std::size_t>(args.triangles);
  const auto mesh = std::make_shared<const render::TriangleMesh>(render::Split(
      render::Simplified(*proxy->Occluder(), most_triangles), scene->Centers(), kMostSlope, most_triangles));
  scene = render::WithProxy(*scene, std::make_shared<render::MeshProxy>(scene->subject, mesh));

  progress.Show(0.05, "which views see the surface");
  const std::vector<render::ViewShares> shares = render::SharesOfVertices(*scene, *mesh);
  ThrowIfStopped();
  progress.Show(0.3, "colours of vertices");
  model.mesh = *mesh;
  model.colors = render::ColorsOfVertices(*scene, *mesh, shares);
  const fs::path colored = folder.path() / (model.name + "_vertex_colors.glb");
  WriteFileAtomically(colored, render::GlbBytes(model));
  ThrowIfStopped();
  progress.Show(0.4, "charts of the texture");
  const render::TextureAtlas atlas = render::MakeTextureAtlas(*scene, *mesh, args.texture_px);
  ThrowIfStopped();
  progress.Show(0.6, "baking the texture");
  model.texture_png = PngBytes(render::BakeTexture(*scene, atlas, shares));
  model.texture_size = {atlas.width, atlas.height};
  model.mesh = atlas.mesh;
  model.texel = atlas.texel;
  model.colors.clear();
  const fs::path textured = folder.path() / (model.name + ".glb");
  const std::string bytes = render::GlbBytes(model);
  WriteFileAtomically(textured, bytes);
  ThrowIfStopped();
  folder.Commit();

  if (args.json) {
    const nlohmann::ordered_json json{{"output", args.output},
                                      {"cameras", model.cameras.size()},
                                      {"triangles", atlas.mesh.triangles.size()},
                                      {"unseen_triangles", atlas.unseen},
                                      {"of_triangles", proxy->Occluder()->triangles.size()},
                                      {"charts", atlas.Charts()},
                                      {"texture", {atlas.width, atlas.height}},
                                      {"texels_per_pixel", atlas.scale},
                                      {"bytes", bytes.size()}};
    fmt::print("{}\n", JsonText(json, 2));
    return kOk;
  }
  fmt::print(
      "{}/{}: {}, {}; a texture of {}x{} in {}, {:.2f} texels for a pixel of a photograph; {:.1f} MB\n",
      args.output, textured.filename().string(), Counted(model.cameras.size(), "camera"),
      Counted(atlas.mesh.triangles.size(), "triangle"), atlas.width, atlas.height,
      Counted(atlas.Charts(), "chart"), atlas.scale, static_cast<double>(bytes.size()) / 1e6);
  if (atlas.unseen > 0) fmt::print("{} that no view sees left out\n", Counted(atlas.unseen, "triangle"));
  if (mesh->triangles.size() < proxy->Occluder()->triangles.size())
    fmt::print("made coarser from {} triangles (--triangles)\n", proxy->Occluder()->triangles.size());
  fmt::print("{}/{}: all {} with a colour for each vertex\n", args.output, colored.filename().string(),
             Counted(mesh->triangles.size(), "triangle"));
  return kOk;
}

// ---- Quilts ----

// Parses "8x6".
std::pair<int, int> TwoNumbers(const std::string& text, const char* option) {
  int a = 0, b = 0, used = 0;
  constexpr int kMost = 32768;
  if (std::sscanf(text.c_str(), "%dx%d%n", &a, &b, &used) != 2 ||
      static_cast<std::size_t>(used) != text.size() || a < 1 || b < 1 || a > kMost || b > kMost)
    throw UsageError("{} {}: two whole numbers from 1 to {}, such as 8x6", option, text, kMost);
  return {a, b};
}

render::QuiltOptions QuiltOptionsOf(const QuiltArgs& args) {
  render::QuiltOptions options{.format = render::QuiltOfDisplay(args.display), .zoom = args.zoom};
  if (!args.tiles.empty())
    std::tie(options.format.columns, options.format.rows) = TwoNumbers(args.tiles, "--tiles");
  if (!args.size.empty())
    std::tie(options.format.width_px, options.format.height_px) = TwoNumbers(args.size, "--size");
  if (args.aspect > 0) options.format.aspect = args.aspect;
  if (args.cone_deg > 0) options.view_cone = Radians(args.cone_deg);
  return options;
}

void SayWhatTheConeIs(const render::QuiltViews& views) {
  constexpr double kUsual = Radians(35);  // the maker's recommendation
  if (views.outside > 0)
    fmt::print("{} of {} viewpoints lie outside the recorded ones: their tiles are guessed at the sides\n",
               views.outside, views.cameras.size());
  else if (views.view_cone < kUsual)
    fmt::print(
        "the recorded viewpoints carry {:.1f} degrees from side to side, less than the {:.0f} of such "
        "displays: depth will look shallow; record farther to the sides\n",
        Degrees(views.view_cone), Degrees(kUsual));
}

int RunQuilt(const QuiltArgs& args) {
  const render::QuiltOptions options = QuiltOptionsOf(args);
  const LightField light_field = ReadLightField(args.dir);
  RequireOutside(light_field.root, args.output);
  StagedFolder folder(args.output);
  const StopOnSignal signals;
  Progress progress("export", args.json);
  render::FieldOptions field;
  if (args.field != render::kAuto) field.kind = render::FieldFromName(args.field);
  const auto plain = render::LoadScene(light_field, OptionsOf(args));
  // This comes before fields and geometry are compared, which change no viewpoint.
  if (!(render::QuiltViewsOf(*plain, options).view_cone > 0))
    throw UsageError(
        "{}: the recorded viewpoints carry no view to the side of their middle; give --cone DEGREES to try "
        "all the same, or record viewpoints beside each other",
        args.dir);
  const render::RendererKind kind = RendererFromName(args.renderer);
  const ChosenModel chosen = ChooseModel(args, plain, args.proxy, args.field, field, kind);
  const auto renderer = RendererOf(
      args, chosen, {.field = chosen.choice.field, .renderer = kind, .gpu_memory_mb = args.gpu_memory_mb});
  const render::QuiltViews views = render::QuiltViewsOf(renderer->scene(), options);
  const int tiles = static_cast<int>(views.cameras.size());
  const cv::Mat quilt = render::DrawQuilt(*renderer, views, options.format, [&](int done) {
    ThrowIfStopped();
    progress.Show(static_cast<double>(done) / tiles, fmt::format("tile {} of {}", done, tiles));
  });
  const std::string name = render::QuiltName(LightFieldName(args.dir), options.format);
  WriteFileAtomically(folder.path() / name, PngBytes(quilt));
  folder.Commit();
  if (args.json) {
    const nlohmann::ordered_json json{{"output", args.output},
                                      {"file", name},
                                      {"tiles", tiles},
                                      {"size", {quilt.cols, quilt.rows}},
                                      {"view_cone_deg", Degrees(views.view_cone)},
                                      {"outside", views.outside},
                                      {"field", render::FieldName(renderer->field().kind)},
                                      {"proxy", renderer->scene().proxy->Name()}};
    fmt::print("{}\n", JsonText(json, 2));
    return kOk;
  }
  fmt::print("{}/{}: {} in {}x{} pixels, a view cone of {:.1f} degrees\n", args.output, name,
             Counted(tiles, "tile"), quilt.cols, quilt.rows, Degrees(views.view_cone));
  SayWhatTheConeIs(views);
  return kOk;
}

void AddCommon(CLI::App& form, SceneExportArgs& args) {
  AddSceneOptions(form, args);
  form.add_option("-o,--output", args.output, "New folder")->required();
  form.add_flag("--json", args.json, "Print one JSON object");
}

}  // namespace

void AddSceneForms(CLI::App& command, ChosenCommand& chosen) {
  const auto [gltf, gltf_args] =
      NewSubcommand(command, chosen, "gltf",
                    "The mesh as glTF (.glb) with a texture baked from the views and "
                    "their cameras, for Blender and others",
                    RunGltf);
  gltf->alias("blender");
  AddCommon(*gltf, *gltf_args);
  gltf->add_option(
      "--mesh", gltf_args->mesh,
      "The mesh: DIR/proxy.ply, which ulf proxy makes (mesh), or a PLY or OBJ file in DIR's world");
  gltf->add_option("--texture", gltf_args->texture_px, "Most pixels on a side of the texture (8192)")
      ->check(CLI::IsMember({256, 512, 1024, 2048, 4096, 8192, 16384}));
  gltf->add_option("--triangles", gltf_args->triangles,
                   "Most triangles; a larger mesh is made coarser (500000)")
      ->check(CLI::Range(100, 100000000));

  const auto [quilt, quilt_args] = NewSubcommand(
      command, chosen, "quilt",
      "A quilt for light-field displays (Looking Glass): many sheared views in one picture", RunQuilt);
  AddCommon(*quilt, *quilt_args);
  std::string displays;
  for (const render::NamedQuilt& known : render::QuiltDisplays())
    displays += (displays.empty() ? "" : ", ") + std::string(known.display);
  quilt->add_option("--display", quilt_args->display, "Settings by display (portrait): " + displays);
  quilt->add_option("--tiles", quilt_args->tiles,
                    "Columns and rows in place of the display's, such as 10x10");
  quilt->add_option("--size", quilt_args->size,
                    "Pixels of the whole in place of the display's, such as 4096x4096");
  quilt->add_option("--aspect", quilt_args->aspect, "Width over height of the display, such as 0.75")
      ->check(CLI::Range(0.1, 10.0));
  quilt
      ->add_option("--cone", quilt_args->cone_deg,
                   "Degrees from the leftmost viewpoint to the rightmost (what the recorded viewpoints "
                   "carry, at most 54)")
      ->check(CLI::Range(1.0, 120.0));
  quilt
      ->add_option("--zoom", quilt_args->zoom,
                   "Above 1: nearer than the whole subject; below: more of what is around it (1)")
      ->check(Positive());
  OfferValues(quilt->add_option("--proxy", quilt_args->proxy,
                                "Geometry for the photographs, as of ulf render (auto)"),
              kKnownProxies);
  OfferValues(quilt->add_option("--field", quilt_args->field, "Blending field, as of ulf render (auto)"),
              kKnownFields);
}

}  // namespace ulf::commands
