// ulf import converts posed photographs by another program to a light field, and poses photographs by COLMAP.

#include <spdlog/spdlog.h>

#include <algorithm>
#include <optional>

#include "acquisition/calibration/calibration_io.h"
#include "commands/options/command_line.h"
#include "commands/options/option_values.h"
#include "commands/options/subcommands.h"
#include "commands/reports/check_reports.h"
#include "core/base/counted.h"
#include "core/base/stop_signal.h"
#include "core/light_field/exchange/colmap_posing.h"
#include "core/light_field/exchange/import_light_field.h"
#include "core/light_field/formats/set_format.h"

namespace ulf::commands {
namespace {

namespace fs = std::filesystem;

struct ImportArgs {
  std::string source;
  std::string dir;
  std::string subject;
  std::string images;
  std::string calibration;
  std::string format = "auto";
  std::string background;
  bool no_subject = false;
  bool check = true;
  bool pose = false;
};

std::string SubjectInWords(const Imported& imported) {
  const LightField& light_field = imported.light_field;
  if (!light_field.subject) return "no subject: posed photographs";
  const Eigen::Vector3d& center = light_field.subject->center_in_world;
  return fmt::format("subject at {:.3f} {:.3f} {:.3f} with radius {:.3f} ({}){}", center.x(), center.y(),
                     center.z(), light_field.subject->radius,
                     light_field.units == "metres" ? "metres" : light_field.units + " units",
                     imported.subject_told_by.empty() ? "" : ", by " + imported.subject_told_by);
}

// Resolves a folder relative to the working directory, or to the set.
fs::path ImagesFolder(const std::string& given, const fs::path& source) {
  if (given.empty() || fs::is_directory(given)) return given;
  const fs::path of_set = (fs::is_directory(source) ? source : source.parent_path()) / given;
  return fs::is_directory(of_set) ? of_set : fs::path(given);
}

void CheckPoses(LightField& light_field) {
  const tracking::PoseCheck check = CheckedPoses(light_field, false).check;
  WarnOnce(light_field.root, light_field.findings);
  if (check.fits_poorly) return;
  std::vector<std::string> names;
  for (const View& view : light_field.views) names.push_back(view.image_path);
  if (check.agree > 0) {
    const std::string fit =
        fmt::format("the photographs fit the poses of {} to {:.1f} px",
                    Counted(static_cast<std::size_t>(check.agree), "view"), check.error_px);
    const std::string untold = tracking::UndecidedInWords(check, names);
    fmt::print("{}{}{}\n", fit, untold.empty() ? "" : "; ", untold);
  } else if (check.contradicted.empty()) {
    fmt::print("whether the photographs fit the poses cannot be told: they show too little in common\n");
  }
}

// Refuses options about poses that are there.
void RequireForPosing(const ImportArgs& args) {
  const auto refuse = [](bool given, const char* option, const char* why) {
    if (given)
      throw UsageError("--pose and {}: the poses are found anew, {}; leave out one of the two", option, why);
  };
  refuse(args.format != ImportArgs{}.format, "--format", "whatever set is there");
  refuse(!args.images.empty(), "--images", "of the photographs in SOURCE itself");
  refuse(!args.calibration.empty(), "--calibration", "and the lens with them");
  refuse(!args.subject.empty(), "--subject", "in a world that is not known before");
}

// A signal ends COLMAP, and later the import as usual.
PosedByColmap Posed(const ImportArgs& args) {
  const StopOnSignal signals;
  return PoseByColmap(args.source, args.dir, StopOnSignal::Requested);
}

int RunImport(const ImportArgs& args) {
  ImportOptions options;
  std::optional<PosedByColmap> posed;
  if (args.pose) RequireForPosing(args);
  if (!args.subject.empty()) options.subject = ParseSubject(args.subject);
  options.without_subject = args.no_subject;
  if (!args.background.empty()) options.background = BackgroundFromText(args.background);
  options.format = SetFormatFromName(args.format);
  options.images = ImagesFolder(args.images, args.source);
  if (!args.calibration.empty()) options.camera = acquisition::ReadCalibration(args.calibration);
  if (args.pose) {
    posed = Posed(args);
    for (const std::string& doubt : posed->doubts) spdlog::warn("{}", doubt);
    options.model = posed->model;
  }
  Imported imported = Import(args.source, args.dir, options);
  LightField& light_field = imported.light_field;
  const auto masked = static_cast<std::size_t>(
      std::ranges::count_if(light_field.views, [](const View& view) { return !view.mask_path.empty(); }));
  fmt::print("{}: {}, {}{}, {}, {}\n", args.dir, imported.format, Counted(light_field.views.size(), "view"),
             masked > 0 ? fmt::format(" ({} masked)", masked) : "",
             Counted(light_field.cameras.size(), "camera"), Counted(light_field.points.size(), "point"));
  fmt::print("{}\n", SubjectInWords(imported));
  if (args.check) CheckPoses(light_field);
  if (!posed || 2 * light_field.views.size() >= posed->photographs) return kOk;
  fmt::print(stderr,
             "ulf: only {} of {} have a pose: neighbours must show mostly the same from places that differ, "
             "of a scene with texture that stands still; {} holds these\n",
             light_field.views.size(), Counted(posed->photographs, "photograph"), args.dir);
  return kFailed;
}

}  // namespace

void AddImportCommand(CLI::App& app, ChosenCommand& chosen) {
  const auto [command, args] = NewSubcommand(
      app, chosen, "import",
      "Take in posed photographs by other programs (docs/exchange.md lists the formats), or pose a folder "
      "of photographs",
      RunImport);
  command->add_option("SOURCE", args->source, "Folder of the set, or the file with its poses")->required();
  command->add_option("-o,--output", args->dir, "New folder for the light field")->required();
  command->add_option("--subject", args->subject,
                      "Subject: x,y,z,radius in world units (default: where the optical axes meet; for sets "
                      "that face one way by their points or depth bounds)");
  command->add_flag(
      "--no-subject", args->no_subject,
      "Posed photographs without a subject, of cameras that look outwards: a walk through a room, "
      "a panorama");
  command->add_option("--images", args->images,
                      "Folder of the photographs, such as images_4 (default: beside the poses, the largest)");
  command
      ->add_option("--format", args->format,
                   "auto, nerfstudio, nerf-synthetic, colmap, llff, bundler, metashape, realityscan, "
                   "meshroom, opensfm, "
                   "openmvg, visualsfm, gaussian-splatting, polycam, tum, euroc, kitti or ulf")
      ->capture_default_str();
  command
      ->add_option("--calibration", args->calibration,
                   "Intrinsics of a set that holds none (tum): a file of ulf or another program, see 'ulf "
                   "calibration'")
      ->check(CLI::ExistingFile);
  command->add_option("--background", args->background,
                      "Lay pictures with alpha over white, black or R,G,B (default: alpha is a mask; for "
                      "nerf-synthetic white)");
  command->add_flag("--pose", args->pose,
                    "SOURCE is a folder of photographs without poses, in any order: COLMAP, which must be "
                    "installed, finds them");
  command->add_flag("!--no-check", args->check, "Do not compare the photographs with their poses");
  command->footer(
      "Example: ulf import fox -o fox_light_field\n         ulf import photographs --pose -o light_field");
}

}  // namespace ulf::commands
