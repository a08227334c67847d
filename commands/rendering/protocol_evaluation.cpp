#include "commands/rendering/protocol_evaluation.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "commands/options/command_line.h"
#include "commands/rendering/refined_split.h"
#include "commands/reports/explain.h"
#include "core/base/atomic_file.h"
#include "core/base/counted.h"
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
#include "render/quality/error_shares.h"
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

struct Costs {
  double wall_s = 0, processor_s = 0;
};

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

struct TestView {
  std::string name;
  render::ViewScore score;
  render::PaperQuality papers;
  render::ErrorShares errors;
  long masked_px = 0;
};

struct ProtocolResult {
  std::string light_field;  // as the user named it
  render::ProtocolSplit split;
  int width = 0, height = 0;
  std::string renderer, field, proxy, why;
  std::string refined;  // empty: poses and lens are unrefined
  std::vector<ModelChoice> explained;
  Costs refining, geometry, choice;
  int depth_maps = 0;
  std::optional<render::LightFit> light;
  double ms_per_picture = 0;
  std::vector<TestView> views;
};

render::PaperQuality MeanOf(const std::vector<TestView>& views) {
  render::PaperQuality mean;
  for (double render::PaperQuality::*value :
       {&render::PaperQuality::psnr_db, &render::PaperQuality::ssim, &render::PaperQuality::ssim_uniform,
        &render::PaperQuality::ssim_padded}) {
    for (const TestView& view : views) mean.*value += view.papers.*value;
    mean.*value /= static_cast<double>(views.size());
  }
  return mean;
}

nlohmann::json JsonOf(const render::PaperQuality& quality) {
  return {{"psnr_db", quality.psnr_db},
          {"ssim", quality.ssim},
          {"ssim_uniform", quality.ssim_uniform},
          {"ssim_padded", quality.ssim_padded}};
}

render::ErrorShares MeanErrorsOf(const std::vector<TestView>& views) {
  render::ErrorShares mean;
  const double share = 1 / static_cast<double>(views.size());
  for (const TestView& view : views) {
    for (std::size_t kind = 0; kind < mean.of_error.size(); ++kind) {
      mean.of_error[kind] += share * view.errors.of_error[kind];
      mean.of_pixels[kind] += share * view.errors.of_pixels[kind];
    }
    mean.of_worst_hundredth += share * view.errors.of_worst_hundredth;
  }
  return mean;
}

nlohmann::json JsonOf(const render::ErrorShares& shares) {
  nlohmann::json json;
  for (std::size_t kind = 0; kind < shares.of_error.size(); ++kind)
    json[std::string(render::kErrorKindNames[kind])] = {{"of_error", shares.of_error[kind]},
                                                        {"of_pixels", shares.of_pixels[kind]}};
  json["worst_hundredth_of_pixels"] = {{"of_error", shares.of_worst_hundredth}, {"of_pixels", 0.01}};
  return json;
}

std::string TextOf(const render::ErrorShares& shares) {
  std::string text = "\nsquared error";
  for (std::size_t kind = 0; kind < shares.of_error.size(); ++kind)
    text +=
        fmt::format("{} {}: {:.0f} % in {:.0f} % of the pixels", kind == 0 ? "" : ",",
                    render::kErrorKindNames[kind], 100 * shares.of_error[kind], 100 * shares.of_pixels[kind]);
  return text + fmt::format("; {:.0f} % in the worst hundredth\n", 100 * shares.of_worst_hundredth);
}

nlohmann::json JsonOf(const Costs& costs) {
  return {{"wall_s", costs.wall_s}, {"processor_s", costs.processor_s}};
}

nlohmann::json JsonOf(const render::LightFit& light) {
  return {{"found", light.Words()},
          {"points", light.points},
          {"stops", light.stops},
          {"corner_stops", light.corner_stops}};
}

nlohmann::json JsonOf(const ProtocolResult& result) {
  nlohmann::json json{{"light_field", result.light_field},
                      {"protocol", result.split.name},
                      {"given", result.split.given.size()},
                      {"test", result.split.test.size()},
                      {"width_px", result.width},
                      {"height_px", result.height},
                      {"renderer", result.renderer},
                      {"field", result.field},
                      {"proxy", result.proxy},
                      {"chosen_by", result.why},
                      {"refined", result.refined},
                      {"refining", JsonOf(result.refining)},
                      {"light", result.light ? JsonOf(*result.light) : nullptr},
                      {"geometry", JsonOf(result.geometry)},
                      {"depth_maps", result.depth_maps},
                      {"choice", JsonOf(result.choice)},
                      {"ms_per_picture", result.ms_per_picture},
                      {"lpips", nullptr},
                      {"mean", JsonOf(MeanOf(result.views))},
                      {"errors", JsonOf(MeanErrorsOf(result.views))},
                      {"views", nlohmann::json::array()}};
  AddExplained(json, result.explained);
  for (const TestView& view : result.views) {
    nlohmann::json each = JsonOf(view.papers);
    each["name"] = view.name;
    each["masked_px"] = view.masked_px;
    each["filled_px"] = view.score.filled_px;
    each["empty_px"] = view.score.empty_px;
    each["ms"] = view.score.ms;
    each["psnr_disc_db"] = view.score.disc.psnr_db;
    each["ssim_disc"] = view.score.disc.ssim;
    json["views"].push_back(each);
  }
  return json;
}

std::string TextOf(const ProtocolResult& result) {
  std::string text = fmt::format("{}, protocol {}: {} left out of {}, {}x{}, {}\n", result.light_field,
                                 result.split.name, Counted(result.split.test.size(), "photograph"),
                                 result.split.test.size() + result.split.given.size(), result.width,
                                 result.height, result.renderer);
  if (!result.refined.empty()) text += result.refined + "\n";
  text += fmt::format("{}, proxy {}; {}\n", result.field, result.proxy, result.why);
  if (result.light) text += result.light->Words() + "\n";
  text += "\n";
  std::size_t widest = 4;
  for (const TestView& view : result.views) widest = std::max(widest, view.name.size());
  const auto row = [&](const std::string& name, const render::PaperQuality& quality) {
    text += fmt::format("{:<{}}  {:7.2f}  {:6.4f}  {:12.4f}  {:11.4f}\n", name, widest, quality.psnr_db,
                        quality.ssim, quality.ssim_uniform, quality.ssim_padded);
  };
  text += fmt::format("{:<{}}  {:>7}  {:>6}  {:>12}  {:>11}\n", "", widest, "PSNR", "SSIM", "SSIM uniform",
                      "SSIM padded");
  long masked_px = 0;
  for (const TestView& view : result.views) {
    row(view.name, view.papers);
    masked_px += view.masked_px;
  }
  row("mean", MeanOf(result.views));
  text += TextOf(MeanErrorsOf(result.views));
  text += fmt::format(
      "\ngeometry {:.1f} s ({:.1f} s of processor), choices {:.1f} s ({:.1f}), {:.0f} ms a picture\n",
      result.geometry.wall_s, result.geometry.processor_s, result.choice.wall_s, result.choice.processor_s,
      result.ms_per_picture);
  if (masked_px > 0)
    text += fmt::format(
        "{} pixels of these photographs are masked, or lie beyond their edge after undistortion: they do not "
        "count\n",
        masked_px);
  return text;
}

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

// Returns the name in the set, relative to images/ if it lies there; it never leaves the output folder.
std::string NameOf(const View& view) {
  const fs::path path = fs::path(view.image_path).lexically_normal();
  const fs::path below = path.lexically_relative("images");
  return (below.empty() || *below.begin() == ".." ? path : below).generic_string();
}

// Two photographs that differ by their ending alone would be written to one file.
void RequireDifferentNames(const LightField& light_field, const std::vector<int>& views) {
  std::map<std::string, std::string> names;
  for (const int index : views) {
    const View& view = light_field.views[static_cast<std::size_t>(index)];
    const std::string name = NameOf(view);
    const auto [same, is_new] = names.emplace(fs::path(name).replace_extension().generic_string(), name);
    if (!is_new)
      throw Error("{}: {} and {} would be written to one file; leave out -o, or rename one of them",
                  light_field.root.string(), same->second, name);
  }
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
  auto* protocol = sub.add_option(
      "--protocol", args.protocol,
      "Measure as papers do: llff, nerf-synthetic, every:N, or a file that names the photographs to leave "
      "out; geometry, points and all choices are made without them "
      "(docs/measured/rendering.md#beside-published-tables)");
  sub.add_option("-o,--output", args.out,
                 "With --protocol: new folder for pictures, photographs, differences, table, JSON and mesh")
      ->needs(protocol);
  sub.add_flag(
         "--refine", args.refine,
         "With --protocol: refine lens and poses first; the given views among themselves, the left-out "
         "ones only to find where they were taken from (docs/measured/rendering.md#beside-published-tables)")
      ->needs(protocol);
  sub.add_option("--geometry-size", args.geometry_px,
                 "With --protocol: longer side of the photographs of which geometry is made, in pixels (as "
                 "ulf proxy)")
      ->check(CLI::Range(32, 4096))
      ->needs(protocol);
  sub.add_option("--geometry-maps", args.geometry_maps,
                 "With --protocol: largest number of given views that get a depth map (60, as ulf proxy)")
      ->check(CLI::Range(2, 100000))
      ->needs(protocol);
}

int RunProtocol(const ProtocolArgs& args, const SceneArgs& scene_args,
                const std::vector<render::FieldOptions>& fields, bool json) {
  const std::vector<std::string> proxy_names = ProxyNames(scene_args.proxies);
  LightField all = ReadLightField(scene_args.dir);
  ProtocolResult result;
  result.light_field = scene_args.dir;
  result.split = render::SplitByProtocol(all, args.protocol);
  std::optional<StagedFolder> folder;
  if (!args.out.empty()) {
    RequireDifferentNames(all, result.split.test);
    folder.emplace(args.out);
  }

  Progress progress("evaluating", json);
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
      if (folder) render::WriteMeshPly(folder->path() / render::kMeshProxyFile, mesh.mesh);
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
  for (const int view : used) {
    if (std::ranges::binary_search(result.split.test, view))
      evaluation.left_out.push_back(static_cast<int>(both.views.size()));
    both.views.push_back(all.views[static_cast<std::size_t>(view)]);
  }
  std::map<int, TestView> seen;
  evaluation.look = [&](const render::ComparedPicture& picture) {
    const auto view = std::ranges::find(both.views, picture.view_id, &View::id);
    TestView& test = seen[picture.view_id];
    test.name = NameOf(*view);
    test.papers = render::CompareAsPapers(picture.rendered, picture.photograph, picture.valid);
    test.errors = render::ShareErrors(picture.rendered, picture.photograph, picture.valid, picture.depth,
                                      picture.confidence);
    test.masked_px = static_cast<long>(picture.valid.total()) - cv::countNonZero(picture.valid);
    if (!folder) return;
    const auto write = [&](const char* kind, const cv::Mat& pixels) {
      const fs::path path = folder->path() / kind / fs::path(test.name).replace_extension(".png");
      MakeFolder(path.parent_path());
      WritePictureFile(path.string(), pixels);
    };
    write("rendered", picture.rendered);
    write("photographs", picture.photograph);
    write("differences", DifferencePicture(picture.rendered, picture.photograph, picture.valid));
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
  if (folder) {
    WriteFileAtomically(folder->path() / "result.json", JsonText(JsonOf(result), 1) + "\n");
    WriteFileAtomically(folder->path() / "result.txt", TextOf(result));
    folder->Commit();
  }
  fmt::print("{}", json ? JsonText(JsonOf(result), 1) + "\n" : TextOf(result));
  return kOk;
}

}  // namespace ulf::commands
