#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <future>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands/options/aperture_options.h"
#include "commands/options/chosen_model.h"
#include "commands/options/command_line.h"
#include "commands/options/mesh_option.h"
#include "commands/options/option_values.h"
#include "commands/options/scene_options.h"
#include "commands/options/subcommands.h"
#include "commands/reports/explain.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/host_time.h"
#include "core/base/json_text.h"
#include "core/base/quantile.h"
#include "core/image/files/picture_file.h"
#include "core/image/image.h"
#include "render/display/surface.h"
#include "render/fields/field_options.h"
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

// Sets the requested kind, if any.
render::FieldOptions FieldOf(const ViewArgs& args) {
  render::FieldOptions field = FieldDetails(args.field_details);
  if (args.field != render::kAuto) field.kind = render::FieldFromName(args.field);
  return field;
}

// Without --frame-ms nothing is compared, because a comparison takes longer than looking at each.
render::FieldOptions StartingField(const ViewArgs& args, const render::RenderScene& scene) {
  const render::FieldOptions field = FieldOf(args);
  // Lumigraph weights have no rings to widen.
  return args.field != render::kAuto || args.aperture.IsSet() ? field : render::DefaultField(scene, field);
}

// Returns the proxies of the key P, beginning with the one of the command line, or with the light field's own
// mesh or points.
std::vector<render::OfferedProxy> ProxiesOf(const ViewArgs& args, const Subject& subject) {
  std::vector<std::string> names;
  if (args.proxy != render::kAuto) names.push_back(args.proxy);
  std::ranges::copy(render::DefaultProxies(args.dir), std::back_inserter(names));
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

// An iconified window has no size.
cv::Size ScreenOf(const ViewArgs& args, const render::Surface& surface) {
  const cv::Size size = surface.Size();
  return size.empty() ? cv::Size(args.width, args.height) : size;
}

// The viewer begins with the choice. A file, a fitted plane and a mesh without its maps are offered under
// another name than that of the proxy that they make.
void Begin(const ViewArgs& args, const render::Choice& choice, render::ViewerOptions& options) {
  options.field = choice.field;
  const std::string name = choice.proxy->Name();
  const bool is_soft_without_maps = args.proxy == render::kAuto && name == "mesh";
  std::erase_if(options.proxies, [&](const render::OfferedProxy& proxy) {
    return proxy.name == name || proxy.name == args.proxy || (is_soft_without_maps && proxy.name == "soft");
  });
  options.proxies.insert(options.proxies.begin(), {name, [proxy = choice.proxy] { return proxy; }});
}

// Opens the aperture for a path of one picture, the viewer's first one.
void Open(const ApertureArgs& args, const cv::Size& screen, render::Viewer& viewer) {
  if (!args.IsSet()) return;
  const render::ViewerCamera& camera = viewer.state().camera;
  const render::CameraPath here{{camera.CamFromWorld()}, {camera.ModelFor(screen)}, {}};
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
    OpenGlOrHint([] { return std::make_unique<render::GlContext>(); });  // --screenshot needs OpenGL, too
    throw Error(
        "{}; ulf view needs a desktop session with OpenGL, or --screenshot FILE.png for a picture without a "
        "window",
        error.what());
  }
}

// Shows a message while nothing can be drawn.
void ShowWaiting(render::Surface& surface, const char* words) {
  auto painter = std::make_unique<render::Painter>();
  try {
    const cv::Size screen = surface.Size();
    if (screen.empty()) return;
    const double scale = ScaleOf(surface);
    surface.Bind();
    painter->Begin(screen, scale);
    painter->Box({0, 0, double(screen.width), double(screen.height)}, {18, 18, 18}, 0);
    render::PlainPanels(*painter, screen, scale).Instruction(words, render::ink::kText);
    painter->End();
    surface.Present();
  } catch (const render::SurfaceGone&) {
    render::Abandon(std::move(painter));
    throw;
  }
}

struct Left {};  // thrown if the window was closed

// Shows the message until the work is done. Throws Left if the user quits.
template <typename Result>
void HandleInput(render::Surface& surface, const std::future<Result>& work, const char* words) {
  constexpr auto kBetweenLooks = std::chrono::milliseconds(50);
  constexpr double kBetweenPictures = 2;  // seconds: another window may have covered the last one
  ShowWaiting(surface, words);
  auto shown = SteadyClock::now();
  cv::Size shown_size = surface.Size();
  render::ViewerInput input({}, 1, 0);
  while (work.wait_for(kBetweenLooks) != std::future_status::ready) {
    for (const render::InputEvent& event : surface.TakeEvents(0)) input.Handle(event, surface.Size());
    for (const render::ViewerRequest& request : input.TakeRequests()) {
      if (request.what == render::ViewerRequest::kLeave) throw Left();
      if (request.what == render::ViewerRequest::kFullScreen) surface.ToggleFullScreen();
    }
    if (surface.Size() == shown_size && SecondsSince(shown) < kBetweenPictures) continue;
    ShowWaiting(surface, words);
    shown = SteadyClock::now();
    shown_size = surface.Size();
  }
}

// Runs in a thread of its own, since a renderer has a context of its own: the window's stays current in this
// one, and its events are handled. Throws Left.
ChosenModel ChooseForViewer(const ViewArgs& args, const std::shared_ptr<const render::RenderScene>& scene,
                            render::Surface& surface) {
  const render::ViewerCamera camera = render::StartingCamera(*scene);
  std::atomic<bool> goes_on = true;
  render::ChoiceOptions options{.in_motion = render::MotionTiming{camera.ModelFor(ScreenOf(args, surface)),
                                                                  camera.CamFromWorld(), args.frame_ms}};
  options.between = [&](const std::string&, double) {
    if (!goes_on) throw Left();
  };
  auto chosen = std::async(std::launch::async, [&] {
    return ChooseModel(args, scene, args.proxy, args.field, FieldOf(args), render::RendererKind::kGl,
                       options);
  });
  try {
    if (args.screenshot.empty()) HandleInput(surface, chosen, "comparing fields and geometry");
  } catch (...) {
    goes_on = false;  // otherwise the future would wait for the whole comparison
    throw;
  }
  return chosen.get();
}

// Times are measured from the start. A picture is complete when no photograph is missing.
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
    if (args.explain) AddExplained(json, explained);
    fmt::print("{}\n", JsonText(json));
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

// Runs until the user quits.
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
  FieldOf(args);  // checks before anything is loaded
  CheckApertureOptions(args.aperture, args.dir);
  render::KeysFromNames(args.keys);  // checks names before anything is opened
  const std::filesystem::path screenshot(args.screenshot);
  if (!args.screenshot.empty() && screenshot.extension() != ".png" && screenshot.extension() != ".jpg")
    throw UsageError("--screenshot {}: give a name ending in .png or .jpg", args.screenshot);
  if (!std::filesystem::exists(args.dir)) Load(args);  // throws before a display is opened
  auto surface = OpenSurface(args);
  std::unique_ptr<render::Viewer> viewer;
  try {
    if (args.screenshot.empty()) ShowWaiting(*surface, "reading the light field");
    auto scene = Load(args);
    spdlog::info("{}", scene->ViewpointsInWords());
    RequireProxyOfLightField(args.proxy, args.dir);
    const auto proxies = ProxiesOf(args, scene->subject);
    if (args.light == "fit" && args.frame_ms == 0)
      if (const auto light = LightOf(args, *scene, MeshForLight(args, *scene, {proxies.front().make()})))
        scene = render::WithLight(*scene, *light);
    render::ViewerOptions options{.field = StartingField(args, *scene),
                                  .proxies = proxies,
                                  .masks = LoadMasks(args, *scene),
                                  .out = args.out,
                                  .gpu_memory_mb = args.gpu_memory_mb,
                                  .sensor_width_mm = args.aperture.sensor_width_mm,
                                  .reduces_motion = args.screenshot.empty()};
    std::vector<ModelChoice> explained;
    if (args.frame_ms > 0) {
      const ChosenModel chosen = ChooseForViewer(args, scene, *surface);
      scene = chosen.scene;
      Begin(args, chosen.choice, options);
      explained = chosen.explained;
      LogExplanation(args.explain, args.json, chosen.choice.why, explained);
    }
    viewer = std::make_unique<render::Viewer>(*surface, scene, options);
    Open(args.aperture, ScreenOf(args, *surface), *viewer);
    Report(args, *viewer, Show(args, start, *surface, *viewer), explained);
  } catch (const Left&) {
    spdlog::info("closed while fields and geometry were compared");
  } catch (const render::SurfaceGone& gone) {
    render::Abandon(std::move(viewer));
    render::Abandon(std::move(surface));
    // A thread of the viewer may still be reading a photograph and cannot be stopped now. A normal exit would
    // unload the libraries that it uses.
    fmt::print(stderr, "ulf: {}, and the viewer with its window\n", gone.what());
    std::fflush(nullptr);
    std::_Exit(kFailed);
  }
  viewer.reset();  // before the surface that it uses
  return kOk;
}

}  // namespace

void AddViewCommand(CLI::App& app, ChosenCommand& chosen) {
  const auto [sub, args] =
      NewSubcommand(app, chosen, "view", "Opens a light field in a window to move about in", RunView);
  AddSceneOptions(*sub, *args);
  sub->remove_option(sub->get_option("--renderer"));
  OfferValues(
      sub->add_option("--field", args->field,
                      "Blending field at the start: auto (subdivision, or lumigraph of fewer than ten "
                      "views; with --frame-ms the best that is quick enough), subdivision, linear, "
                      "lumigraph, lumigraph-per-pixel, nearest, soft"),
      kKnownFields);
  AddFieldDetails(*sub, args->field_details);
  OfferValues(
      sub->add_option("--proxy", args->proxy,
                      "Geometry at the start: auto (the light field's mesh, with its depth maps where "
                      "there are some, else its tracked points, else the plane; with --frame-ms the best "
                      "that is quick enough), mesh (DIR/proxy.ply), soft (with DIR/depth), points, planes, "
                      "plane, plane:0.9, plane:x,y,z,d, or a PLY or OBJ file"),
      kKnownProxies);
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
  sub->footer("Example: ulf view lightfield\n\nKeys of the window (docs/rendering.md#viewer):" +
              KeyLines(render::kViewerKeys));
}

}  // namespace ulf::commands
