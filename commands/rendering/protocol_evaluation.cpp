#include "commands/rendering/protocol_evaluation.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <opencv2/core.hpp>

#include "commands/options/command_line.h"
#include "commands/rendering/refined_split.h"
#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/host_time.h"
#include "core/base/json_text.h"
#include "core/base/progress.h"
#include "core/image/files/picture_file.h"
#include "core/light_field/exchange/staged_folder.h"
#include "core/light_field/folder/light_field_io.h"
#include "render/proxy/mesh_file.h"
#include "render/proxy/planes_proxy.h"
#include "render/proxy/points_proxy.h"
#include "render/proxy/soft_proxy.h"
#include "render/quality/choice.h"
#include "render/quality/evaluate.h"
#include "render/quality/protocol.h"
#include "render/stereo/proxy_builder.h"

namespace ulf::commands {
namespace {

namespace fs = std::filesystem;

// Returns the time of all threads of this process.
double ProcessorSeconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

class CostWatch {
 public:
  Costs Lap() {
    const double processor = ProcessorSeconds();
    return {watch_.LapSeconds(), processor - std::exchange(before_, processor)};
  }

 private:
  Stopwatch watch_;
  double before_ = ProcessorSeconds();
};

// Returns plane, planes, points and mesh, or the named ones among them.
std::vector<std::string> ProxyNames(const std::vector<std::string>& asked) {
  const std::vector<std::string> all{"plane", render::kPlanesProxy, "points", "mesh",
                                     "soft"};  // the last two come from one reconstruction
  for (const std::string& name : asked)
    if (std::ranges::find(all, name) == all.end())
      throw UsageError(
          "--proxy {}: with --protocol geometry is made from the given photographs alone: plane, planes, "
          "points, mesh or soft",
          name);
  return asked.empty() ? std::vector<std::string>(all.begin(), all.end() - 1) : asked;
}

// Is black where the photograph has no light, which does not count.
cv::Mat DifferencePicture(const cv::Mat& rendered, const cv::Mat& photograph, const cv::Mat& valid) {
  constexpr double kTimes = 4;
  cv::Mat difference;
  cv::absdiff(rendered, photograph, difference);
  difference *= kTimes;
  difference.setTo(0, valid == 0);
  return difference;
}

}  // namespace

void AddProtocolOptions(CLI::App& sub, ProtocolArgs& args) {
  sub.add_option(
      "--protocol", args.protocol,
      "Measure as papers do: llff, nerf-synthetic, every:N, or a file that names the photographs to leave "
      "out; geometry, points and all choices are made without them "
      "(docs/measured/rendering.md#beside-published-tables)");
  sub.add_option("--against", args.against,
                 "Another light field with the same photographs, posed or chosen otherwise: both render the "
                 "same left-out ones (--every or --protocol, of those that both have), each from its other "
                 "views by its own poses");
  sub.add_option(
      "-o,--output", args.out,
      "With --protocol or --against: new folder for pictures, photographs, differences, table, JSON "
      "and mesh");
  sub.add_flag(
      "--refine", args.refine,
      "With --protocol: refine lens and poses first; the given views among themselves, the left-out "
      "ones only to find where they were taken from (docs/measured/rendering.md#beside-published-tables)");
  sub.add_option("--geometry-size", args.geometry_px,
                 "With --protocol or --against: longer side of the photographs of which geometry is made, in "
                 "pixels (as ulf proxy)")
      ->check(CLI::Range(32, 4096));
  sub.add_option(
         "--geometry-maps", args.geometry_maps,
         "With --protocol or --against: largest number of given views that get a depth map (60, as ulf "
         "proxy)")
      ->check(CLI::Range(2, 100000));
}

std::string NameInSet(const View& view) {
  const fs::path path = fs::path(view.image_path).lexically_normal();
  const fs::path below = path.lexically_relative("images");
  return (below.empty() || *below.begin() == ".." ? path : below).generic_string();
}

void RequireDifferentNames(const LightField& light_field, const std::vector<int>& views) {
  std::map<std::string, std::string> names;
  for (const int index : views) {
    const View& view = light_field.views[static_cast<std::size_t>(index)];
    const std::string name = NameInSet(view);
    const auto [same, is_new] = names.emplace(fs::path(name).replace_extension().generic_string(), name);
    if (!is_new)
      throw Error("{}: {} and {} would be written to one file; leave out -o, or rename one of them",
                  light_field.root.string(), same->second, name);
  }
}

ProtocolResult EvaluateSplit(LightField all, const render::ProtocolSplit& split, const ProtocolArgs& args,
                             const SceneArgs& scene_args, const std::vector<render::FieldOptions>& fields,
                             const fs::path& folder, Progress& progress, const LeaveOutPixels& leave_out) {
  const std::vector<std::string> proxy_names = ProxyNames(scene_args.proxies);
  ProtocolResult result;
  result.light_field = scene_args.dir;
  result.split = split;
  CostWatch watch;
  if (args.refine) {
    RefinedSplit refined = RefineForProtocol(all, result.split, progress);
    result.refining = watch.Lap();
    result.refined = refined.summary;
    all = std::move(refined.light_field);
  }
  const render::RendererKind renderer = RendererFromName(scene_args.renderer);
  render::SceneOptions options = OptionsOf(scene_args);
  const LightField given = render::SubsetOfViews(all, result.split.given);
  if (!options.subject) options.subject = given.subject;
  auto given_scene = render::LoadScene(given, options);

  std::vector<std::shared_ptr<const render::Proxy>> proxies;
  for (const std::string& name : proxy_names) {
    if (name == "plane") {
      proxies.push_back(std::make_shared<render::PlaneProxy>(given_scene->subject));
      proxies.push_back(render::FitPlane(*given_scene,
                                         fields.empty() ? render::EveryField().front() : fields.front(),
                                         renderer, {.gpu_memory_mb = scene_args.gpu_memory_mb}));
    }
    if (name == render::kPlanesProxy &&
        (proxy_names.size() == 1 || render::FindPlanes(given).why_none.empty()))
      proxies.push_back(render::MakePlanesProxy(given_scene->subject, given));
    if (name == "points" && given.points.size() >= render::PointsProxy::kFewest)
      proxies.push_back(std::make_shared<render::PointsProxy>(given_scene->subject, given.points));
    if (name != "mesh" && name != "soft") continue;
    render::ProxyOptions geometry;
    if (args.geometry_px > 0) geometry.size_px = args.geometry_px;
    if (args.geometry_maps > 0) geometry.depth_maps = args.geometry_maps;
    geometry.keep_maps = true;
    try {
      watch.Lap();
      render::ProxyMesh mesh =
          render::BuildProxy(*render::LoadForGeometry(given, options, geometry.size_px), geometry, &progress);
      result.geometry = watch.Lap();
      result.depth_maps = mesh.summary.depth_maps;
      if (!folder.empty()) render::WriteMeshPly(folder / render::kMeshProxyFile, mesh.mesh);
      proxies.push_back(std::make_shared<render::SoftProxy>(
          given_scene->subject, std::make_shared<render::TriangleMesh>(std::move(mesh.mesh)),
          render::SoftProxy::InMemory(std::move(mesh.maps))));
    } catch (const Error& error) {
      if (proxy_names.size() == 1) throw;
      spdlog::warn("no mesh: {}", error.what());
    }
  }
  if (proxies.empty())
    throw Error("{}: the given photographs show too few points for --proxy points; leave it out",
                scene_args.dir);
  result.light = LightOf(scene_args, *given_scene, proxies.back());
  if (result.light) given_scene = render::WithLight(*given_scene, *result.light);
  watch.Lap();
  const render::Choice choice =
      render::ChooseByEvidence(*given_scene, fields.empty() ? render::EveryField() : fields, proxies,
                               renderer, {.gpu_memory_mb = scene_args.gpu_memory_mb});
  result.choice = watch.Lap();
  result.why = choice.why.empty() ? "as asked" : choice.why;
  result.explained = choice.explained;
  if (result.light) result.explained.push_back(result.light->explained);

  std::vector<int> used = result.split.given;
  used.insert(used.end(), result.split.test.begin(), result.split.test.end());
  std::ranges::sort(used);
  LightField both = given;
  both.views.clear();
  render::EvaluateOptions evaluation{.fields = {choice.field},
                                     .proxies = {choice.proxy},
                                     .renderer = renderer,
                                     .gpu_memory_mb = scene_args.gpu_memory_mb};
  std::map<int, int> index_of;  // by View::id
  for (const int view : used) {
    if (std::ranges::binary_search(result.split.test, view))
      evaluation.left_out.push_back(static_cast<int>(both.views.size()));
    both.views.push_back(all.views[static_cast<std::size_t>(view)]);
    index_of[both.views.back().id] = view;
  }
  std::map<int, TestView> seen;
  evaluation.look = [&](const render::ComparedPicture& picture) {
    const auto view = std::ranges::find(both.views, picture.view_id, &View::id);
    TestView& test = seen[picture.view_id];
    test.name = NameInSet(*view);
    cv::Mat valid = picture.valid;
    if (leave_out) leave_out(index_of.at(picture.view_id), valid = valid.clone());
    test.papers = render::CompareAsPapers(picture.rendered, picture.photograph, valid);
    test.errors =
        render::ShareErrors(picture.rendered, picture.photograph, valid, picture.depth, picture.confidence);
    test.masked_px = static_cast<long>(valid.total()) - cv::countNonZero(valid);
    if (folder.empty()) return;
    const auto write = [&](const char* kind, const cv::Mat& pixels) {
      const fs::path path = folder / kind / fs::path(test.name).replace_extension(".png");
      MakeFolder(path.parent_path());
      WritePictureFile(path.string(), pixels);
    };
    write("rendered", picture.rendered);
    write("photographs", picture.photograph);
    write("differences", DifferencePicture(picture.rendered, picture.photograph, valid));
  };
  auto scene = render::LoadScene(both, options);
  if (result.light) scene = render::WithLight(*scene, *result.light);
  const render::EvaluateSummary summary = render::Evaluate(*scene, evaluation, &progress);
  const render::FieldScore& score = summary.results.front();
  result.width = summary.width;
  result.height = summary.height;
  result.renderer = summary.renderer;
  result.field = render::FieldText(score.used);
  result.proxy = score.proxy;
  result.ms_per_picture = score.ms_per_frame;
  for (const render::ViewScore& view : score.views) {
    seen.at(view.view_id).score = view;
    result.views.push_back(seen.at(view.view_id));
  }
  return result;
}

int RunProtocol(const ProtocolArgs& args, const SceneArgs& scene_args,
                const std::vector<render::FieldOptions>& fields, bool json) {
  ProxyNames(scene_args.proxies);  // checks before anything is read
  LightField all = ReadLightField(scene_args.dir);
  const render::ProtocolSplit split = render::SplitByProtocol(all, args.protocol);
  std::optional<StagedFolder> folder;
  if (!args.out.empty()) {
    RequireDifferentNames(all, split.test);
    folder.emplace(args.out);
  }
  Progress progress("evaluating", json);
  const ProtocolResult result = EvaluateSplit(std::move(all), split, args, scene_args, fields,
                                              folder ? folder->path() : fs::path(), progress);
  if (folder) {
    WriteFileAtomically(folder->path() / "result.json", JsonText(ToJson(result), 1) + "\n");
    WriteFileAtomically(folder->path() / "result.txt", ToText(result));
    folder->Commit();
  }
  fmt::print("{}", json ? JsonText(ToJson(result), 1) + "\n" : ToText(result));
  return kOk;
}

}  // namespace ulf::commands
