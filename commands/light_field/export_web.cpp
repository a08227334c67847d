// `ulf export web` exports a light field as a page for browsers.
#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "commands/light_field/export_scene.h"
#include "commands/options/mesh_option.h"
#include "commands/options/option_values.h"
#include "commands/options/scene_options.h"
#include "commands/options/subcommands.h"
#include "core/base/counted.h"
#include "core/base/json_text.h"
#include "core/base/progress.h"
#include "core/base/shell_word.h"
#include "core/base/stop_signal.h"
#include "core/image/image.h"
#include "core/light_field/exchange/export_light_field.h"
#include "core/light_field/folder/light_field_io.h"
#include "render/fields/field_options.h"
#include "render/gl/gl_renderer.h"
#include "render/proxy/proxy_choice.h"
#include "render/quality/choice.h"
#include "render/viewer/viewer_camera.h"
#include "render/web/web_page.h"

namespace ulf::commands {
namespace {

struct WebArgs : SceneArgs {
  std::string output;
  std::string budget = "20MB";
  std::string proxy = render::kAuto;
  std::string title;
  int longest_px = render::WebPageOptions{}.longest_px;
  bool json = false;
};

std::size_t BytesFromText(const std::string& text) {
  double number = 0;
  int end = 0;
  if (std::sscanf(text.c_str(), "%lf%n", &number, &end) == 1 && std::isfinite(number) && number > 0) {
    const std::string unit = text.substr(static_cast<std::size_t>(end));
    const double of_unit = unit == "GB" ? 1e9 : unit == "MB" ? 1e6 : unit == "kB" || unit == "KB" ? 1e3 : 0;
    if (of_unit > 0 && number * of_unit >= 1 && number * of_unit <= 1e12)
      return static_cast<std::size_t>(number * of_unit);
  }
  throw UsageError("--budget {}: a size is a number with kB, MB or GB, such as 20MB", text);
}

// Returns the best geometry of the light field that is the same for all pictures.
std::shared_ptr<const render::Proxy> ProxyFor(const WebArgs& args, const Subject& subject) {
  if (args.proxy != render::kAuto) {
    RequireProxyOfLightField(args.proxy, args.dir);
    const auto proxy = render::ProxyFromName(args.proxy, subject, args.dir);
    if (args.proxy != "plane" && !proxy->Occluder())
      throw UsageError(
          "--proxy {}: a page takes plane, planes, mesh, or a PLY or OBJ file; a mesh is made with: ulf "
          "proxy {}",
          args.proxy, ShellWord(args.dir));
    return proxy;
  }
  std::vector<std::string> names = render::DefaultProxies(args.dir);
  std::ranges::replace(names, "soft", "mesh");  // a page draws the mesh without depth maps
  std::erase(names, "points");
  if (names.front() != "mesh")
    spdlog::info("a mesh usually gives better pictures; make it with: ulf proxy {}", ShellWord(args.dir));
  return render::ProxyFromName(names.front(), subject, args.dir);
}

// Writes the size as --budget takes it, rounded up.
std::string BudgetText(std::size_t bytes) {
  const bool is_small = bytes < 10'000'000;
  return fmt::format("{:.0f}{}", std::ceil((is_small ? 1e-3 : 1e-6) * static_cast<double>(bytes)),
                     is_small ? "kB" : "MB");
}

// Checks before anything but the journal is read.
void RequireBudget(const WebArgs& args, const LightField& light_field, std::size_t budget_bytes) {
  const render::LeastWebPage least = render::LeastPageOf(light_field, OptionsOf(args), budget_bytes);
  if (least.bytes <= budget_bytes) return;
  throw UsageError(
      "--budget {}: {} take at least {}, with pictures of 64 pixels; {} can hold {}; give more (such as {}), "
      "or take views out of a copy (cp -r {} COPY; ulf take-back COPY VIEW)",
      args.budget, Counted(least.views, "view"), BudgetText(least.bytes), args.budget,
      least.views_held == 0 ? "none" : fmt::format("some {}", least.views_held), BudgetText(2 * least.bytes),
      ShellWord(args.dir));
}

// Renders the page's first picture as the page will draw it.
cv::Mat Poster(const WebArgs& args, const std::shared_ptr<const render::RenderScene>& scene) {
  const render::ViewerCamera start = render::StartingCamera(*scene);
  constexpr int kLongestPx = 960;  // larger ones would delay the page's own data. Guessed.
  const CameraModel small = render::Within(start.photograph, kLongestPx);
  const auto renderer = render::MakeRenderer(
      scene, {.field = render::DefaultField(*scene), .renderer = RendererFromName(args.renderer)});
  const render::Rendering picture =
      renderer->Render(start.ModelFor({small.width, small.height}), start.CamFromWorld());
  cv::Mat poster = Srgb8FromLinear(picture.linear);
  if (picture.empty_px > 0) cv::merge(std::vector<cv::Mat>{poster, picture.drawn}, poster);
  return poster;
}

int RunExportWeb(const WebArgs& args) {
  render::WebPageOptions options;
  options.budget_bytes = BytesFromText(args.budget);
  const LightField light_field = ReadLightField(args.dir);
  options.longest_px = args.longest_px;
  options.title =
      args.title.empty() ? std::filesystem::weakly_canonical(args.dir).filename().string() : args.title;
  RequireExportable(light_field, args.output, {});
  RequireBudget(args, light_field, options.budget_bytes);
  const auto proxy = ProxyFor(args, render::SubjectOf(light_field, OptionsOf(args).subject));
  const auto plain = render::LoadScene(light_field, OptionsOf(args));
  const auto light = LightOf(args, *plain, MeshForLight(args, *plain, {proxy}));
  const auto scene = render::WithProxy(light ? *render::WithLight(*plain, *light) : *plain, proxy);
  Progress progress("export", args.json);
  options.progress = [&](double share, const std::string& what) { progress.Show(share, what); };
  options.stop = [] { return StopOnSignal::Requested(); };
  options.poster = Poster(args, scene);
  const StopOnSignal signals;  // from here on a stop removes the output
  const render::WebPageSummary summary = render::ExportWebPage(*scene, args.output, options);
  if (args.json) {
    const nlohmann::ordered_json json{{"output", args.output},
                                      {"views", summary.views},
                                      {"width", summary.width},
                                      {"height", summary.height},
                                      {"quality", summary.quality},
                                      {"proxy", proxy->Name()},
                                      {"field", render::FieldName(render::DefaultField(*scene).kind)},
                                      {"triangles", summary.triangles},
                                      {"triangles_before", summary.triangles_before},
                                      {"bytes", summary.bytes},
                                      {"bytes_before_the_page_draws", summary.first_bytes},
                                      {"files", summary.files}};
    fmt::print("{}\n", JsonText(json, 2));
    return kOk;
  }
  fmt::print(
      "{}: {} of {}x{} at quality {}, {:.2f} MB of {} in {}, {:.2f} MB of them before the page draws\n",
      args.output, Counted(summary.views, "view"), summary.width, summary.height, summary.quality,
      1e-6 * static_cast<double>(summary.bytes), args.budget, Counted(summary.files, "file"),
      1e-6 * static_cast<double>(summary.first_bytes));
  if (summary.triangles > 0)
    fmt::print("geometry: {}, {} of its {}\n", proxy->Name(), Counted(summary.triangles, "triangle"),
               summary.triangles_before);
  else
    fmt::print("geometry: {}\n", proxy->Name());
  fmt::print("open {} in a browser, or lay the folder on any host\n",
             (std::filesystem::path(args.output) / "index.html").string());
  return kOk;
}

}  // namespace

void AddExportWeb(CLI::App& command, ChosenCommand& chosen) {
  const auto [web, args] =
      NewSubcommand(command, chosen, "web",
                    "A page for browsers, which needs no program behind it (docs/web_page.md)", RunExportWeb);
  AddSceneOptions(*web, *args);
  web->add_option("-o,--output", args->output, "New folder")->required();
  web->add_option("--budget", args->budget, "Size of the whole folder, such as 20MB (20MB)");
  OfferValues(
      web->add_option("--proxy", args->proxy,
                      "Geometry (auto: the mesh, else planes, else the plane): auto, plane, planes, mesh, "
                      "or a PLY or OBJ file"),
      "auto,plane,planes,mesh,FILE");
  web->add_option("--title", args->title, "Title of the page (the folder's name)");
  web->add_option(
         "--longest", args->longest_px,
         "Largest longer side of the pictures in pixels; phones keep fewer large ones in memory (1280)")
      ->check(CLI::Range(64, 4096));
  web->add_flag("--json", args->json, "Print one JSON object");
  web->footer("Example: ulf export web vase -o site --budget 20MB");
}

}  // namespace ulf::commands
