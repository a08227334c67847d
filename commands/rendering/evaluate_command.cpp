#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands/options/chosen_model.h"
#include "commands/options/command_line.h"
#include "commands/options/option_values.h"
#include "commands/options/scene_options.h"
#include "commands/options/subcommands.h"
#include "commands/rendering/against.h"
#include "commands/rendering/protocol_evaluation.h"
#include "core/base/atomic_file.h"
#include "core/base/counted.h"
#include "core/base/json_text.h"
#include "core/base/output_path.h"
#include "core/base/progress.h"
#include "render/fields/field_options.h"
#include "render/proxy/proxy_choice.h"
#include "render/quality/evaluate.h"

namespace ulf::commands {
namespace {

struct EvaluateArgs : SceneArgs {
  int every = 8;
  std::vector<std::string> fields{"nearest", "linear", "subdivision", "lumigraph", "lumigraph-per-pixel",
                                  "soft"};
  FieldArgs field_details;
  ProtocolArgs protocol;
  bool fields_are_given = false;
  bool every_is_given = false;
  std::string table;  // file to write
  bool json = false;
};

nlohmann::json JsonOf(const render::MeanScore& mean) {
  if (mean.views == 0) return nullptr;
  return {{"views", mean.views},
          {"psnr_db", mean.psnr_db},
          {"ssim", mean.ssim},
          {"psnr_disc_db", mean.psnr_disc_db},
          {"ssim_disc", mean.ssim_disc}};
}

nlohmann::json JsonOf(const render::FieldScore& result) {
  const render::MeanScore& main = result.Main();
  nlohmann::json views = nlohmann::json::array();
  for (const render::ViewScore& score : result.views)
    views.push_back({{"id", score.view_id},
                     {"rim", score.on_rim},
                     {"psnr_db", score.frame.psnr_db},
                     {"ssim", score.frame.ssim},
                     {"psnr_disc_db", score.disc.psnr_db},
                     {"ssim_disc", score.disc.ssim},
                     {"filled_px", score.filled_px},
                     {"empty_px", score.empty_px},
                     {"ms", score.ms}});
  return {{"field", render::FieldName(result.asked.kind)},
          {"field_used", render::FieldName(result.used.kind)},
          {"level", std::to_string(result.used.level)},
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

// Writes a line for each field over each proxy. Names of proxies may hold commas (plane:0,0,1,2).
std::string CsvOf(const render::EvaluateSummary& summary) {
  std::string table =
      "field,field_used,proxy,views,ms_per_frame,psnr_db,ssim,psnr_disc_db,ssim_disc,psnr_rim_db,ssim_rim\n";
  for (const render::FieldScore& result : summary.results) {
    const render::MeanScore& main = result.Main();
    const std::string rim = result.rim.views > 0
                                ? fmt::format("{:.4f},{:.5f}", result.rim.psnr_db, result.rim.ssim)
                                : std::string(",");
    table += fmt::format("{},{},\"{}\",{},{:.3f},{:.4f},{:.5f},{:.4f},{:.5f},{}\n",
                         render::FieldName(result.asked.kind), render::FieldText(result.used), result.proxy,
                         main.views, result.ms_per_frame, main.psnr_db, main.ssim, main.psnr_disc_db,
                         main.ssim_disc, rim);
  }
  return table;
}

void PrintTable(const render::EvaluateSummary& summary) {
  fmt::print("{}, {} left out, {}x{}, {}\n{}\n\n", Counted(summary.views, "view"), summary.held_out,
             summary.width, summary.height, summary.renderer, summary.viewpoints);
  std::size_t proxy_width = 6;
  for (const render::FieldScore& result : summary.results)
    proxy_width = std::max(proxy_width, result.proxy.size());
  fmt::print("{:<22} {:<{}} {:>6}  {:>7} {:>6}  {:>7} {:>6}  {:>7} {:>6}  {:>8} {:>9} {:>8}\n", "field",
             "proxy", proxy_width, "level", "PSNR", "SSIM", "disc", "SSIM", "rim", "SSIM", "ms", "filled px",
             "empty");
  for (const render::FieldScore& result : summary.results) {
    const render::MeanScore& main = result.Main();
    const std::string rim = result.rim.views > 0
                                ? fmt::format("{:7.2f} {:6.4f}", result.rim.psnr_db, result.rim.ssim)
                                : fmt::format("{:>7} {:>6}", "-", "-");
    const bool has_level = render::UsesMesh(result.used.kind);
    const std::string name = render::FieldName(result.asked.kind);
    fmt::print(
        "{:<22} {:<{}} {:>6}  {:7.2f} {:6.4f}  {:7.2f} {:6.4f}  {}  {:8.1f} {:9} {:8}{}\n", name,
        result.proxy, proxy_width, has_level ? std::to_string(result.used.level) : "", main.psnr_db,
        main.ssim, main.psnr_disc_db, main.ssim_disc, rim, result.ms_per_frame, result.filled_px,
        result.empty_px,
        result.asked.kind == result.used.kind ? "" : "  (used: " + render::FieldName(result.used.kind) + ")");
  }
  const int rim_views = summary.results.empty() ? 0 : summary.results.front().rim.views;
  if (rim_views == summary.held_out)
    fmt::print("\nPSNR in dB, means over {}, all on the rim of the hull.\n",
               Counted(rim_views, "left-out view"));
  else if (rim_views > 0)
    fmt::print("\nPSNR in dB, means over {} inside the hull; the {} on its rim apart.\n",
               Counted(summary.held_out - rim_views, "left-out view"), rim_views);
}

// A field and the geometry under it.
struct Drawn {
  render::FieldOptions field;
  std::string proxy;
  std::string Words() const { return fmt::format("{} over {}", render::FieldText(field), proxy); }
  nlohmann::json Json() const { return {{"field", render::FieldName(field.kind)}, {"proxy", proxy}}; }
};

// Returns what `ulf view` draws at once where nothing is named: it compares nothing.
Drawn DrawnByView(const EvaluateArgs& args, const render::RenderScene& scene) {
  return {render::DefaultField(scene, FieldDetails(args.field_details)),
          render::DefaultProxies(args.dir).front()};
}

// Returns what `ulf render` draws where nothing is named, by the comparison that it makes itself.
Drawn DrawnByRender(const EvaluateArgs& args, const std::shared_ptr<const render::RenderScene>& scene) {
  const render::Choice choice = ChooseModel(args, scene, render::kAuto, render::kAuto,
                                            FieldDetails(args.field_details), RendererFromName(args.renderer))
                                    .choice;
  return {choice.field, choice.proxy->Name()};
}

void RequireNoProtocolOptions(const ProtocolArgs& args) {
  const char* option = !args.out.empty()        ? "-o"
                       : args.refine            ? "--refine"
                       : args.geometry_px > 0   ? "--geometry-size"
                       : args.geometry_maps > 0 ? "--geometry-maps"
                                                : nullptr;
  if (option) throw UsageError("{}: needs --protocol{}", option, args.refine ? "" : " or --against");
}

int RunEvaluate(const EvaluateArgs& args) {
  render::EvaluateOptions options{
      .every = args.every, .renderer = RendererFromName(args.renderer), .gpu_memory_mb = args.gpu_memory_mb};
  for (const std::string& name : args.fields) {
    options.fields.push_back(FieldDetails(args.field_details));
    options.fields.back().kind = render::FieldFromName(name, "fields");
  }
  if (!args.protocol.protocol.empty() && args.every_is_given)
    throw UsageError("--every {}: --protocol says what is left out; give --protocol every:{}", args.every,
                     args.every);
  const std::vector<render::FieldOptions> asked =
      args.fields_are_given ? options.fields : std::vector<render::FieldOptions>{};
  if (!args.protocol.against.empty()) {
    ProtocolArgs both = args.protocol;
    if (both.protocol.empty()) both.protocol = fmt::format("every:{}", args.every);
    return RunAgainst(both, args, asked, args.table, args.json);
  }
  if (!args.protocol.protocol.empty() && !args.table.empty())
    throw UsageError("--table {}: with --protocol give -o FOLDER, which holds the table", args.table);
  if (!args.protocol.protocol.empty()) return RunProtocol(args.protocol, args, asked, args.json);
  RequireNoProtocolOptions(args.protocol);
  if (!args.table.empty()) RequireWritable(args.table);
  const auto scene = Load(args);
  options.proxies = Proxies(args, *scene, options.fields.front());
  if (args.proxies.empty() && options.proxies.size() > 1)
    spdlog::info(
        "all proxies of {} are compared; those that were made with the left-out views score a little too "
        "well (ulf proxy --leave-out-every {} makes a mesh without them)",
        args.dir, args.every);
  Progress progress("evaluating");
  const auto mesh = MeshForLight(args, *scene, options.proxies);
  auto evened = scene;
  if (!mesh) {
    LightOf(args, *scene, nullptr);  // checks that --light fit is possible
  } else if (scene->views.size() > 2) {
    for (std::size_t i = 0; i < scene->views.size(); i += static_cast<std::size_t>(args.every))
      options.left_out.push_back(static_cast<int>(i));
    if (const auto light = LightOf(args, *render::Without(*scene, options.left_out), mesh))
      evened = render::WithLight(*scene, *light);
  } else if (args.light == "fit") {
    throw UsageError("--light fit: with one view left out, nothing is left to compare its light with");
  }
  const render::EvaluateSummary summary = render::Evaluate(*evened, options, &progress);
  if (!args.table.empty()) WriteFileAtomically(args.table, CsvOf(summary));
  const Drawn by_view = DrawnByView(args, *scene), by_render = DrawnByRender(args, scene);
  if (!args.json) {
    PrintTable(summary);
    fmt::print(
        "\nWhere they are not told otherwise, ulf render draws {}, and ulf view {}.\n", by_render.Words(),
        by_view.Words() == by_render.Words() ? "the same" : by_view.Words() + ", without a comparison");
    return kOk;
  }
  nlohmann::json report{
      {"views", summary.views},      {"held_out", summary.held_out}, {"width_px", summary.width},
      {"height_px", summary.height}, {"renderer", summary.renderer}, {"viewpoints", summary.viewpoints},
      {"default", by_view.Json()},   {"render", by_render.Json()},   {"results", nlohmann::json::array()}};
  for (const render::FieldScore& result : summary.results) report["results"].push_back(JsonOf(result));
  fmt::print("{}\n", JsonText(report, 1));
  return kOk;
}

}  // namespace

void AddEvaluateCommand(CLI::App& app, ChosenCommand& chosen) {
  const auto args = std::make_shared<EvaluateArgs>();
  CLI::App* sub = app.add_subcommand(
      "evaluate", "Leaves views out, renders them, and compares them with their photographs");
  AddSceneOptions(*sub, *args);
  sub->add_option("--every", args->every, "Leave out every k-th view (8)")->check(CLI::Range(2, 1000000));
  OfferValues(
      sub->add_option(
          "--fields", args->fields,
          "Blending fields to compare, separated by commas (nearest, linear, subdivision, "
          "lumigraph, lumigraph-per-pixel, soft); with --protocol and --against those to choose from"),
      "nearest,linear,subdivision,lumigraph,lumigraph-per-pixel,soft")
      ->delimiter(',');
  AddFieldDetails(*sub, args->field_details);
  OfferValues(
      sub->add_option("--proxy", args->proxies,
                      "Geometry: plane, plane:0.9 (of the subject's distance), plane:fitted, plane:x,y,z,d, "
                      "planes (the few on which most tracked points lie), points (the tracked points), mesh "
                      "(DIR/proxy.ply), soft (the same with DIR/depth), a PLY or an OBJ file; may be given "
                      "several times (plane, and the light field's planes, points and mesh or soft). A mesh "
                      "should be made without the left-out views (ulf proxy --leave-out-every)"),
      "plane,plane:SHARE,plane:fitted,planes,points,mesh,soft,FILE")
      ->allow_extra_args(false);
  AddProtocolOptions(*sub, args->protocol);
  sub->add_option(
      "--table", args->table,
      "CSV file to write: the scores and the time of a picture, a line for each field over each proxy; with "
      "--against the scores of both, a line for each photograph");
  sub->add_flag("--json", args->json, "Report as one JSON object");
  sub->footer(
      "Example: ulf evaluate vase --every 8 --fields subdivision,lumigraph\n         ulf evaluate refined "
      "--against vase");
  sub->callback([&chosen, args, sub] {
    args->fields_are_given = sub->count("--fields") > 0;
    args->every_is_given = sub->count("--every") > 0;
    chosen = [args] { return RunEvaluate(*args); };
  });
}

}  // namespace ulf::commands
