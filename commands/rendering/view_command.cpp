#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <future>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands/commands.h"
#include "commands/number_checks.h"
#include "commands/rendering/aperture_options.h"
#include "commands/rendering/scene_options.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/host_time.h"
#include "core/base/quantile.h"
#include "core/image/image.h"
#include "render/display/key_names.h"
#include "render/display/surface.h"
#include "render/gl/gl_context.h"
#include "render/proxy/proxy_choice.h"
#include "render/quality/choice.h"
#include "render/viewer/viewer.h"

namespace ulf::commands {
namespace {

using SteadyClock = std::chrono::steady_clock;
constexpr double kPatienceSeconds = 0.5;  // for input

struct ViewArgs : SceneArgs {
  std::string field = render::kAuto;
  FieldArgs field_details;
  std::string proxy = render::kAuto;
  ApertureArgs aperture;
  int width = 1280, height = 720;
  bool full_screen = false;
  std::string out = ".";
  std::string screenshot;
  std::string keys;
  double frame_ms = 0;  // 0: nothing is compared
  bool explain = false;
  bool json = false;
};

// Without --frame-ms nothing is compared: that takes longer than looking at each.
render::FieldOptions FieldOf(const ViewArgs& args) {
  render::FieldOptions field = FieldDetails(args.field_details);
  if (args.field != render::kAuto) field.kind = render::FieldFromName(args.field);
  return field;
}

// The proxies of the key P, beginning with the one of the command line, or with the light field's own mesh or
// points.
std::vector<render::OfferedProxy> ProxiesOf(const ViewArgs& args, const Subject& subject) {
  std::vector<std::string> names;
  if (args.proxy != render::kAuto) names.push_back(args.proxy);
  const std::vector<std::string> own = render::OwnProxies(args.dir);
  names.insert(names.end(), own.rbegin(), own.rend());
  names.push_back("plane");
  std::vector<render::OfferedProxy> proxies;
  for (const std::string& name : names) {
    const auto same = [&](const render::OfferedProxy& proxy) { return proxy.name == name; };
    if (std::ranges::none_of(proxies, same))
      proxies.push_back({name, [name, subject, dir = args.dir, is_asked = name == args.proxy] {
                           return is_asked ? render::ProxyFromName(name, subject, dir)
                                           : render::OwnProxy(name, subject, dir);
                         }});
  }
  return proxies;
}

// In a thread of its own, since a renderer has a context of its own: the window's stays current in this one.
render::Choice ChosenFor(const ViewArgs& args, const render::RenderScene& scene, const cv::Size& screen) {
  const render::ViewerCamera camera = render::StartingCamera(scene);
  const render::ChoiceOptions options{
      .in_motion = render::InMotion{camera.For(screen), camera.CamFromWorld(), args.frame_ms}};
  return std::async(std::launch::async,
                    [&] {
                      const auto kind = render::RendererKind::kGl;
                      const auto proxies =
                          render::ProxiesToTry(scene, args.proxy, FieldOf(args), args.dir, kind);
                      return render::ChooseByName(scene, args.field, FieldDetails(args.field_details),
                                                  proxies, kind, options);
                    })
      .get();
}

// What was chosen is what the viewer begins with.
void Begin(const render::Choice& choice, render::ViewerOptions& options) {
  options.field = choice.field;
  const std::string name = choice.proxy->Name();
  std::erase_if(options.proxies, [&](const render::OfferedProxy& proxy) { return proxy.name == name; });
  options.proxies.insert(options.proxies.begin(), {name, [proxy = choice.proxy] { return proxy; }});
}

// The aperture for a path of one picture, the viewer's first one.
void Open(const ApertureArgs& args, const cv::Size& screen, render::Viewer& viewer) {
  if (!args.Asked()) return;
  const render::ViewerCamera& camera = viewer.state().camera;
  const render::CameraPath here{{camera.CamFromWorld()}, {camera.For(screen)}, {}};
  viewer.Open(AperturesAlong(args, here, viewer.renderer().scene()).front());
}

// Calls opens(); its error names the command that does not need OpenGL.
template <typename Opens>
auto OpenGlOrHint(Opens&& opens) {
  try {
    return opens();
  } catch (const Error& error) {
    throw Error("{}; ulf view needs OpenGL; ulf render --renderer reference makes pictures without it",
                error.what());
  }
}

std::unique_ptr<render::Surface> OpenSurface(const ViewArgs& args) {
  const cv::Size size(args.width, args.height);
  if (!args.screenshot.empty())
    return OpenGlOrHint([&] { return std::make_unique<render::OffscreenSurface>(size); });
  try {
    auto window = render::OpenWindow("ulf view " + args.dir, size);
    if (args.full_screen) window->ToggleFullScreen();
    return window;
  } catch (const render::SurfaceGone&) {
    throw;
  } catch (const Error& error) {
    OpenGlOrHint(
        [] { return std::make_unique<render::GlContext>(); });  // without OpenGL --screenshot fails, too
    throw Error(
        "{}; ulf view needs a desktop session with OpenGL, or --screenshot FILE.png for a picture without a "
        "window",
        error.what());
  }
}

// Shows a message while the light field is read.
void ShowWaiting(render::Surface& surface) {
  auto painter = std::make_unique<render::Painter>();
  try {
    const cv::Size screen = surface.Size();
    if (screen.empty()) return;
    const double scale = ScaleOf(surface);
    surface.Bind();
    painter->Begin(screen, scale);
    painter->Box({0, 0, double(screen.width), double(screen.height)}, {18, 18, 18}, 0);
    render::PlainPanels(*painter, screen, scale).Instruction("reading the light field", render::ink::kText);
    painter->End();
    surface.Present();
  } catch (const render::SurfaceGone&) {
    render::Abandon(std::move(painter));
    throw;
  }
}

// Times since the start. A picture is complete when no photograph is missing.
struct FirstPicture {
  double seconds = 0, complete_seconds = 0;
};

void Report(const ViewArgs& args, const render::Viewer& viewer, const FirstPicture& first,
            const std::vector<ModelChoice>& explained) {
  const double median_ms = Median(viewer.frame_ms());
  if (args.json) {
    nlohmann::ordered_json json{{"frames", viewer.frames()},
                                {"median_ms", median_ms},
                                {"first_picture_s", first.seconds},
                                {"complete_picture_s", first.complete_seconds},
                                {"field", render::FieldName(viewer.renderer().field().kind)},
                                {"proxy", viewer.renderer().scene().proxy->Name()},
                                {"renderer", viewer.renderer().Name()}};
    if (args.explain)
      for (const ModelChoice& choice : explained) json["explain"].push_back(ToJson(choice));
    fmt::print("{}\n", json.dump());
    return;
  }
  fmt::print("{}, {:.1f} ms in the median, the first {:.2f} s after the start, complete at {:.2f} s, on {}\n",
             Counted(viewer.frames(), "frame"), median_ms, first.seconds, first.complete_seconds,
             viewer.renderer().Name());
}

void TakePicture(const ViewArgs& args, render::Surface& surface, render::Viewer& viewer) {
  auto& offscreen = dynamic_cast<render::OffscreenSurface&>(surface);
  for (const render::InputEvent& key : render::KeysFromNames(args.keys)) {
    offscreen.Push(key);
    if (!viewer.Step(0)) return;
  }
  while (viewer.loading()) viewer.Step(kPatienceSeconds);
  WritePictureFile(args.screenshot, offscreen.Read());
}

// Runs until the user leaves.
FirstPicture Show(const ViewArgs& args, SteadyClock::time_point start, render::Surface& surface,
                  render::Viewer& viewer) {
  FirstPicture first;
  bool goes_on = viewer.Step(0);
  first.seconds = SecondsSince(start);
  while (goes_on && viewer.loading()) goes_on = viewer.Step(kPatienceSeconds);
  first.complete_seconds = SecondsSince(start);
  if (!args.screenshot.empty())
    TakePicture(args, surface, viewer);
  else
    while (goes_on) goes_on = viewer.Step(kPatienceSeconds);
  return first;
}

int RunView(const ViewArgs& args) {
  const auto start = SteadyClock::now();
  const render::FieldOptions field = FieldOf(args);
  CheckApertureOptions(args.aperture, args.dir);
  render::KeysFromNames(args.keys);  // throws for a wrong name before anything is opened
  const std::filesystem::path screenshot(args.screenshot);
  if (!args.screenshot.empty() && screenshot.extension() != ".png" && screenshot.extension() != ".jpg")
    throw UsageError("--screenshot {}: give a name ending in .png or .jpg", args.screenshot);
  if (!std::filesystem::exists(args.dir)) Load(args);  // throws: where nothing is, no display helps
  auto surface = OpenSurface(args);
  std::unique_ptr<render::Viewer> viewer;
  try {
    if (args.screenshot.empty()) ShowWaiting(*surface);
    auto scene = Load(args);
    spdlog::info("{}", scene->mesh.Description());
    const auto proxies = ProxiesOf(args, scene->subject);
    if (args.light == "fit")
      if (const auto light = LightOf(args, *scene, proxies.front().make()))
        scene = render::WithLight(*scene, *light);
    render::ViewerOptions options{.field = field,
                                  .proxies = proxies,
                                  .out = args.out,
                                  .gpu_memory_mb = args.gpu_memory_mb,
                                  .sensor_width_mm = args.aperture.sensor_width_mm,
                                  .reduces_motion = args.screenshot.empty()};
    std::vector<ModelChoice> explained;
    if (args.frame_ms > 0) {
      const render::Choice choice = ChosenFor(args, *scene, surface->Size());
      Begin(choice, options);
      explained = choice.explained;
      if (!args.explain && !choice.why.empty()) spdlog::info("{}", choice.why);
      if (args.explain && !args.json)
        for (const ModelChoice& one : explained) fmt::print(stderr, "{}", ToText(one));
    }
    viewer = std::make_unique<render::Viewer>(*surface, scene, options);
    Open(args.aperture, surface->Size(), *viewer);
    Report(args, *viewer, Show(args, start, *surface, *viewer), explained);
  } catch (const render::SurfaceGone& gone) {
    render::Abandon(std::move(viewer));
    render::Abandon(std::move(surface));
    // A thread of the viewer may still be reading a photograph and cannot be stopped now. A normal exit would
    // unload the libraries that it uses.
    fmt::print(stderr, "ulf: {}, and the viewer with its window\n", gone.what());
    std::fflush(nullptr);
    std::_Exit(kFailed);
  }
  viewer.reset();  // before its surface
  return kOk;
}

}  // namespace

void AddViewCommand(CLI::App& app, ChosenCommand& chosen) {
  const auto args = std::make_shared<ViewArgs>();
  CLI::App* sub = app.add_subcommand("view", "Opens a light field in a window to move about in");
  AddSceneOptions(*sub, *args);
  sub->remove_option(sub->get_option("--renderer"));
  sub->add_option("--field", args->field,
                  "Blending field at the start: subdivision (auto), linear, lumigraph, lumigraph-per-pixel, "
                  "nearest, soft");
  AddFieldDetails(*sub, args->field_details);
  sub->add_option("--proxy", args->proxy,
                  "Geometry at the start: auto (the light field's mesh, with its depth maps where there are "
                  "some, else its tracked points, else the "
                  "plane), mesh (DIR/proxy.ply), soft (with DIR/depth), points, planes, plane, plane:0.9, "
                  "plane:x,y,z,d, or a PLY or OBJ file");
  auto* frame_ms =
      sub->add_option(
             "--frame-ms", args->frame_ms,
             "Compare fields and geometry on left-out views first, which takes a while, and begin with the "
             "best that take at most this many milliseconds a picture here (without: nothing is compared)")
          ->check(Positive());
  sub->add_flag("--explain", args->explain, "Print why they were chosen")->needs(frame_ms);
  AddApertureOptions(*sub, args->aperture);
  sub->add_option("--width", args->width, "Width of the window (1280)")->check(CLI::Range(64, 16384));
  sub->add_option("--height", args->height, "Height of the window (720)")->check(CLI::Range(64, 16384));
  sub->add_flag("--full-screen", args->full_screen, "Fill the screen");
  sub->add_option("-o,--output", args->out, "Folder for pictures (S) and keyframes (K) (the current one)");
  auto* screenshot =
      sub->add_option("--screenshot", args->screenshot,
                      "Open no window; write one picture (.png, .jpg) of what the window would show");
  sub->add_option("--keys", args->keys,
                  "Keys that are pressed before the picture is taken: b,m,Left,Shift+Up (? shows the keys of "
                  "the window)")
      ->needs(screenshot);
  sub->add_flag("--json", args->json, "Report as one JSON object");
  sub->footer("Example: ulf view lightfield");
  sub->callback([&chosen, args] { chosen = [args] { return RunView(*args); }; });
}

}  // namespace ulf::commands
