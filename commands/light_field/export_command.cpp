// `ulf export FORM` exports a light field for other programs, with points measured again if the form has
// points, or as a page.
#include <fmt/core.h>

#include <algorithm>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands/light_field/export_depths.h"
#include "commands/light_field/export_light.h"
#include "commands/light_field/export_scene.h"
#include "commands/light_field/export_shutter.h"
#include "commands/light_field/measured_points.h"
#include "commands/options/subcommands.h"
#include "commands/options/use_threads.h"
#include "core/base/counted.h"
#include "core/base/json_text.h"
#include "core/base/progress.h"
#include "core/base/stop_signal.h"
#include "core/light_field/exchange/export_light_field.h"
#include "core/light_field/folder/light_field_io.h"
#include "tracking/refine/refine_input.h"

namespace ulf::commands {
namespace {

struct ExportArgs : LightArgs {
  std::string dir;
  std::string output;
  std::string subject;
  bool undistort = false;
  bool binary = false;
  bool known_points = false;
  bool depth = false;
  bool global_shutter = false;
  int threads = 0;  // 0: all processors
  bool json = false;
};

nlohmann::ordered_json CameraJson(const Undistortion& camera) {
  return {{"width", camera.to.width}, {"height", camera.to.height},     {"fx", camera.to.fx},
          {"fy", camera.to.fy},       {"changed", !camera.is_identity}, {"kept_share", camera.kept_share}};
}

std::string Described(const Undistortion& camera, std::size_t number) {
  if (camera.is_identity)
    return fmt::format("camera {}: {}x{}, without distortion as it is\n", number, camera.to.width,
                       camera.to.height);
  return fmt::format("camera {}: {}x{} becomes {}x{}; {:.1f} % of the picture is kept{}\n", number,
                     camera.from.width, camera.from.height, camera.to.width, camera.to.height,
                     100 * camera.kept_share,
                     camera.is_limited ? ", nothing beyond 60 degrees from the axis" : "");
}

void PrintPoints(const PointStatistics& points) {
  fmt::print("points: {}", points.points);
  if (points.tracked > 0 && points.tracked < points.points)
    fmt::print(", {} of them measured", points.tracked);
  if (points.tracked > 0)
    fmt::print(", seen {} times ({:.1f} views each), {:.3f} px off (mean)", points.observations,
               points.mean_track_length, points.mean_error_px);
  fmt::print("\n");
}

// Only COLMAP has any.
void PrintCommands(const std::vector<std::string>& commands, const ColmapVersion& colmap) {
  if (commands.empty()) return;
  if (!colmap.number.empty())
    fmt::print("COLMAP's own points under these poses (for COLMAP {}, which is installed here):\n",
               colmap.number);
  else
    fmt::print(
        "COLMAP's own points under these poses (for COLMAP 3.13 and later, because none is installed here; "
        "3.12 says SiftExtraction.num_threads, earlier ones need no num_threads, and without a display or a "
        "GPU add --FeatureExtraction.use_gpu 0 and --FeatureMatching.use_gpu 0, before 3.13 "
        "--SiftExtraction.use_gpu 0 and --SiftMatching.use_gpu 0):\n");
  for (const std::string& command : commands) fmt::print("    {}\n", command);
}

void PrintText(const ExportArgs& args, const ExportSummary& summary, const MeasuredPoints& measured,
               const ExportedDepths& depths, const ExportOptions& options) {
  const bool has_points = HasPoints(options.form);
  const std::string how = summary.copied == 0 ? "all drawn anew"
                          : summary.made == 0 ? "all copied as they are"
                                              : fmt::format("{} of them copied as they are", summary.copied);
  fmt::print("{}: {}, {}{}\n", args.output, Counted(summary.copied + summary.made, "view"), how,
             summary.masks > 0 ? fmt::format(", {}", Counted(summary.masks, "mask")) : "");
  for (std::size_t i = 0; i < summary.cameras.size(); ++i)
    fmt::print("{}", Described(summary.cameras[i], i + 1));
  if (has_points) PrintPoints(summary.points);
  fmt::print("{}", DepthsText(depths, summary.depths));
  fmt::print("{}", PointDoubtsText(measured));
  for (const std::string& doubt : summary.doubts) fmt::print("{}\n", doubt);
  PrintCommands(summary.commands, options.colmap);
}

bool IsColmap(ExportForm form) {
  return form == ExportForm::kColmapText || form == ExportForm::kColmapBinary;
}

int RunExport(const ExportArgs& args, ExportForm form) {
  LightField light_field = ReadLightField(args.dir);
  if (!args.subject.empty()) light_field.subject = ParseSubject(args.subject);
  UseThreads(args.threads);
  Progress progress("export", args.json);
  ExportOptions options;
  options.form = form;
  options.undistort = args.undistort;
  options.stop = [] { return StopOnSignal::Requested(); };
  MeasuredPoints measured;
  const bool measures = HasPoints(form) && !args.known_points;
  const double points_share = measures ? 0.8 : 0;  // of the time; guessed
  RequireExportable(light_field, args.output, options);
  RequireRoomFor(light_field, args.output, options);
  ExportedDepths depths;
  if (args.depth) depths = DepthsOf(light_field, form);
  options.depths = depths.source;
  if (IsColmap(form)) options.colmap = InstalledColmap();
  const auto light_words = SetLight(args, light_field, options);
  ExportedShutter shutter = ShutterOf(light_field, args.global_shutter, form);
  if (measures)
    measured = MeasurePointsAnew(light_field, [&](double done, const std::string& stage) {
      progress.Show(points_share * done, stage);
    });
  if (HasPoints(form))
    light_field.points = tracking::WithoutMasked(std::move(light_field.points), light_field);
  SetShutter(light_field, args.global_shutter, shutter, options);
  const LightField& exported = shutter.at_one_instant ? *shutter.at_one_instant : light_field;
  const StopOnSignal signals;  // from here on a stop removes the output
  options.progress = [&](double share, const std::string& what) {
    progress.Show(points_share + (1 - points_share) * share, what);
  };
  ExportSummary summary = ExportLightField(exported, args.output, options);
  std::ranges::move(light_words(summary), std::back_inserter(summary.doubts));
  if (HasPoints(form) && summary.points.points == 0)
    summary.doubts.push_back(NoPointsInWords(exported, measured, IsColmap(form)));
  if (!shutter.words.empty()) summary.doubts.push_back(shutter.words);
  if (!args.json) {
    PrintText(args, summary, measured, depths, options);
    return kOk;
  }
  nlohmann::ordered_json json{{"output", args.output},
                              {"views", summary.copied + summary.made},
                              {"copied", summary.copied},
                              {"masks", summary.masks},
                              {"doubts", summary.doubts},
                              {"points", summary.points.points},
                              {"measured_points", summary.points.tracked},
                              {"observations", summary.points.observations},
                              {"mean_error_px", summary.points.mean_error_px}};
  if (!summary.commands.empty()) json["commands"] = summary.commands;
  if (measured.done) json["pose_error_px"] = measured.pose_error_px;
  if (args.depth) json["depths"] = DepthsJson(depths, summary.depths);
  for (const Undistortion& camera : summary.cameras) json["cameras"].push_back(CameraJson(camera));
  fmt::print("{}\n", JsonText(json, 2));
  return kOk;
}

// A form of export_light_field.h on the command line.
struct FormOption {
  ExportForm form;
  const char* name;
  const char* what;
  const char* subject = nullptr;  // use of the subject; null: none
};
constexpr FormOption kForms[] = {
    {ExportForm::kColmapText, "colmap", "COLMAP's folder: images, sparse/0 with tracks, masks"},
    {ExportForm::kNerfstudio, "nerfstudio",
     "nerfstudio's folder: images, transforms.json, points.ply, masks"},
    {ExportForm::kInstantNgp, "instant-ngp",
     "instant-ngp's folder: images, dynamic masks, transforms.json with the subject in the unit cube",
     "That fills the unit cube"},
    {ExportForm::kNerfSynthetic, "nerf-synthetic",
     "A set as NeRF's synthetic ones: RGBA images of one pinhole camera, every 8th view for testing",
     "That stands at the origin"},
    {ExportForm::kRealityScan, "realityscan",
     "Images with RealityScan's (RealityCapture's) XMP files beside them"},
    {ExportForm::kMetashape, "metashape", "Images with Agisoft Metashape's cameras.xml, points.ply, masks"}};

void AddForm(CLI::App& command, ChosenCommand& chosen, const FormOption& option) {
  auto args = std::make_shared<ExportArgs>();
  CLI::App* form = command.add_subcommand(option.name, option.what);
  form->add_option("DIR", args->dir, "Light field, or a set with transforms.json")->required();
  form->add_option("-o,--output", args->output, "New folder")->required();
  if (option.form != ExportForm::kNerfSynthetic)
    form->add_flag("--undistort", args->undistort,
                   "Undistort photographs, with the principal point in the centre (default: copy them)");
  if (option.form == ExportForm::kColmapText)
    form->add_flag("--binary", args->binary, "Write the binary model (default: text)");
  if (option.subject != nullptr)
    form->add_option("--subject", args->subject,
                     fmt::format("{}: centre and radius x,y,z,r (the light field's)", option.subject));
  if (HasPoints(option.form))
    form->add_flag("--known-points", args->known_points,
                   "Export the light field's own points (default: measure all points that its views share)");
  form->add_flag(
      "--global-shutter", args->global_shutter,
      "Draw photographs of a rolling shutter as of one instant, by the mesh and the camera's velocity");
  AddLightOptions(*form, *args, option.form != ExportForm::kNerfSynthetic);
  if (HasDepths(option.form))
    form->add_flag(
        "--depth", args->depth,
        "Write depth maps of the photographs to depths/, from the light field's mesh and depth maps");
  form->add_option("--threads", args->threads, "Number of threads (default: all processors)")
      ->check(CLI::Range(1, 256));
  form->add_flag("--json", args->json, "Print one JSON object");
  form->callback([args, to = option.form, &chosen] {
    const ExportForm form_of = args->binary ? ExportForm::kColmapBinary : to;
    chosen = [args, form_of] { return RunExport(*args, form_of); };
  });
}

}  // namespace

void AddExportCommand(CLI::App& app, ChosenCommand& chosen) {
  CLI::App* command = app.add_subcommand("export", "A light field for other programs (docs/exchange.md)");
  command->require_subcommand(1);
  for (const FormOption& form : kForms) AddForm(*command, chosen, form);
  AddFileForms(*command, chosen);
  AddSceneForms(*command, chosen);
  AddExportSplat(*command, chosen);
  AddExportWeb(*command, chosen);
  command->footer("Example: ulf export colmap vase -o vase_colmap --undistort --binary");
}

}  // namespace ulf::commands
