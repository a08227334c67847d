// `ulf export tum` and `ulf export ply`: one file, with the poses or with the points.
#include <fmt/core.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "commands/light_field/export_scene.h"
#include "commands/light_field/measured_points.h"
#include "commands/options/subcommands.h"
#include "core/base/atomic_file.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/base/output_path.h"
#include "core/base/progress.h"
#include "core/base/shell_word.h"
#include "core/geometry/trajectory.h"
#include "core/light_field/exchange/export_light_field.h"
#include "core/light_field/exchange/view_trajectory.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/points/point_io.h"
#include "tracking/refine/refine_input.h"

namespace ulf::commands {
namespace {

struct FileArgs {
  std::string dir;
  std::string output;
  bool json = false;
};

struct PointFileArgs : FileArgs {
  bool known_points = false;
};

// Reads the light field and checks, before any work, that its file can be written.
LightField ReadForFile(const FileArgs& args) {
  LightField light_field = ReadLightField(args.dir);
  if (light_field.views.empty())
    throw Error("{}: the light field holds no views to export; capture or import some first", args.dir);
  RequireWritable(args.output);
  RequireUnused(args.output);
  RequireOutside(light_field.root, args.output);
  return light_field;
}

int RunTum(const FileArgs& args) {
  const LightField light_field = ReadForFile(args);
  const ViewTrajectory trajectory = TrajectoryOf(light_field);
  const bool metric = light_field.units == "metres";
  WriteTum(args.output, trajectory.poses,
           fmt::format("times are {}; lengths are {}", InWords(trajectory.times),
                       metric ? "metres" : "in the light field's own unit"));
  if (args.json) {
    constexpr const char* kNames[] = {"device", "host", "numbers"};  // of TrajectoryTimes
    fmt::print("{}\n", JsonText(nlohmann::ordered_json{{"output", args.output},
                                                       {"poses", trajectory.poses.size()},
                                                       {"times", kNames[static_cast<int>(trajectory.times)]},
                                                       {"units", light_field.units}},
                                2));
    return kOk;
  }
  fmt::print("{}: {}, camera to world, in {}; times are {}\n", args.output,
             Counted(trajectory.poses.size(), "pose"), metric ? "metres" : "the light field's own unit",
             InWords(trajectory.times));
  return kOk;
}

int RunPly(const PointFileArgs& args) {
  LightField light_field = ReadForFile(args);
  MeasuredPoints measured;
  if (!args.known_points) {
    Progress progress("export", args.json);
    measured = MeasurePointsAnew(
        light_field, [&](double share, const std::string& stage) { progress.Show(share, stage); });
  }
  light_field.points = tracking::WithoutMasked(std::move(light_field.points), light_field);
  if (light_field.points.empty() && args.known_points)
    throw Error(
        "{}: holds no points (a capture that was killed has none); leave --known-points out to measure them",
        args.dir);
  if (light_field.points.empty())
    throw Error(
        "{}: the photographs share nothing that can be measured under these poses, so there are no points; "
        "'ulf info {} --check-poses' says whether the poses are right, and ulf refine improves them",
        args.dir, ShellWord(args.dir));
  WriteFileAtomically(args.output, PointPlyBytes(light_field.points));
  if (args.json) {
    nlohmann::ordered_json json{
        {"output", args.output}, {"points", light_field.points.size()}, {"units", light_field.units}};
    if (measured.done) json["pose_error_px"] = measured.pose_error_px;
    fmt::print("{}\n", JsonText(json, 2));
    return kOk;
  }
  fmt::print(
      "{}: {} with colours, {}\n{}", args.output, Counted(light_field.points.size(), "point"),
      args.known_points || measured.kept_points ? "the light field's own" : "measured in the photographs",
      PointDoubtsText(measured));
  return kOk;
}

void AddFile(CLI::App& form, FileArgs& args) {
  form.add_option("DIR", args.dir, "Light field, or a set with transforms.json")->required();
  form.add_option("-o,--output", args.output, "New file")->required();
  form.add_flag("--json", args.json, "Print one JSON object");
}

}  // namespace

void AddFileForms(CLI::App& command, ChosenCommand& chosen) {
  const auto [tum, tum_args] = NewSubcommand(
      command, chosen, "tum",
      "The poses as a text file of TUM's benchmark: time tx ty tz qx qy qz qw, camera to world", RunTum);
  AddFile(*tum, *tum_args);
  const auto [ply, ply_args] =
      NewSubcommand(command, chosen, "ply", "The points with their colours as a PLY file", RunPly);
  AddFile(*ply, *ply_args);
  ply->add_flag("--known-points", ply_args->known_points,
                "Export the light field's own points (default: measure all points that its views share)");
}

}  // namespace ulf::commands
