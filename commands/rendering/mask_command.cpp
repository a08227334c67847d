// ulf mask excludes the still background of a light field whose subject turned, or what moved before the
// lens.

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "acquisition/simulator/simulated_camera.h"
#include "commands/options/command_line.h"
#include "commands/options/subcommands.h"
#include "commands/reports/check_reports.h"
#include "commands/reports/work_reports.h"
#include "core/base/device_uri.h"
#include "core/base/json_text.h"
#include "core/base/quantile.h"
#include "core/geometry/angles.h"
#include "core/light_field/folder/light_field_io.h"
#include "render/masks/moved_masks.h"
#include "render/masks/turntable_masks.h"

namespace ulf::commands {
namespace {

struct MaskArgs {
  std::string dir;
  std::string truth;
  int size_px = 0;  // 0: the default of what is masked
  bool moved = false;
  bool json = false;
};

// Returns the intersection of two masks over their union.
double OverlapOf(const cv::Mat& a, const cv::Mat& b) {
  const int both = cv::countNonZero(a & b), either = cv::countNonZero(a | b);
  return either > 0 ? static_cast<double>(both) / either : 1;
}

// Compares with each view's true mask by the simulator that took it. Poses are in the board's world.
struct MaskErrors {
  std::vector<double> overlaps, centers_m, directions_deg;

  double CentersRmsMm() const {
    double sum = 0;
    for (const double error_m : centers_m) sum += error_m * error_m;
    return 1e3 * std::sqrt(sum / static_cast<double>(centers_m.size()));
  }
};

MaskErrors CompareWithSimulator(const std::string& truth, const LightField& light_field,
                                const std::map<int, cv::Mat>& masks) {
  const DeviceUri uri = DeviceUri::Parse(truth);
  if (uri.scheme != "sim") throw UsageError("--truth {}: give the simulator's URI that was captured", truth);
  const acquisition::SimulatedCamera camera(acquisition::SimulationOptions::FromUri(uri));
  if (!camera.scene().IsTurntable())
    throw UsageError("--truth {}: nothing turns in that scene; give sim:turntable with the captured options",
                     truth);
  const auto& board = camera.scene().board();
  const bool in_boards_frame = board && light_field.turntable && !light_field.turntable->board.empty();
  MaskErrors compared;
  for (const View& view : light_field.views) {
    const cv::Mat& mask = masks.at(view.id);
    const cv::Mat moving = camera.MovingPixels(view.device_time_s);
    if (moving.size() != mask.size())
      throw UsageError(
          "--truth {}: its pictures are {}x{}, those of {} {}x{}; give the options that were captured", truth,
          moving.cols, moving.rows, light_field.root.string(), mask.cols, mask.rows);
    compared.overlaps.push_back(OverlapOf(mask, moving));
    if (!in_boards_frame) continue;
    const Rigid3 cam_from_world = camera.CamFromRest(view.device_time_s) * board->board_from_world.Inverse();
    compared.centers_m.push_back((view.CenterInWorld() - cam_from_world.OriginInSource()).norm());
    compared.directions_deg.push_back(
        Degrees(AngleBetween(view.cam_from_world.DirectionInSource(Eigen::Vector3d::UnitZ()),
                             cam_from_world.DirectionInSource(Eigen::Vector3d::UnitZ()))));
  }
  return compared;
}

int RunMoved(const MaskArgs& args) {
  if (!args.truth.empty())
    throw UsageError("--truth {}: compares a turntable's masks; leave --moved out", args.truth);
  render::MovedMaskOptions options;
  if (args.size_px > 0) options.size_px = args.size_px;
  const render::MovedMasks masks = render::WriteMovedMasks(args.dir, options);
  // What an earlier check found may be masked now.
  LightField light_field = ReadLightField(args.dir);
  std::optional<PoseReport> poses;
  if (!masks.masks.empty() && std::ranges::any_of(light_field.findings, [](const Finding& each) {
        return each.check == Name(Check::kPoses);
      }))
    poses = CheckedPoses(light_field, args.json);
  if (args.json) {
    nlohmann::ordered_json json{{"views", light_field.views.size()},
                                {"judged_share", masks.judged_share},
                                {"masked", nlohmann::json::array()}};
    for (const auto& [id, share] : masks.shares) json["masked"].push_back({{"view", id}, {"share", share}});
    if (poses) json["poses"] = ToJson(*poses, light_field);
    fmt::print("{}\n", JsonText(json, 1));
    return kOk;
  }
  fmt::print("{}: {}{}", args.dir, ToText(masks, light_field), poses ? ToText(*poses, light_field) : "");
  return kOk;
}

int RunMask(const MaskArgs& args) {
  if (args.moved) return RunMoved(args);
  render::TurntableMaskOptions options;
  if (args.size_px > 0) options.size_px = args.size_px;
  const render::TurntableMasks masks = render::WriteTurntableMasks(args.dir, options);
  std::optional<MaskErrors> compared;
  if (!args.truth.empty()) compared = CompareWithSimulator(args.truth, ReadLightField(args.dir), masks.masks);
  if (args.json) {
    nlohmann::ordered_json json{{"views", masks.masks.size()},
                                {"stands", nlohmann::json::array()},
                                {"views_between", masks.views_between},
                                {"turning_share", masks.turning_share}};
    for (const render::Stand& stand : masks.stands)
      json["stands"].push_back({{"views", stand.views.size()},
                                {"turned_deg", Degrees(stand.turned)},
                                {"shift_px", stand.shift_px}});
    if (compared)
      json["truth"] = {{"iou_median", Quantile(compared->overlaps, 0.5)},
                       {"iou_least", Quantile(compared->overlaps, 0)}};
    if (compared && !compared->centers_m.empty()) {
      json["truth"]["centers_mm"] = compared->CentersRmsMm();
      json["truth"]["directions_deg"] = Median(compared->directions_deg);
    }
    fmt::print("{}\n", JsonText(json, 1));
    return kOk;
  }
  fmt::print("{}: {}", args.dir, ToText(masks));
  if (compared)
    fmt::print("against the truth: intersection over union {:.4f} (median), {:.4f} (least)\n",
               Quantile(compared->overlaps, 0.5), Quantile(compared->overlaps, 0));
  if (compared && !compared->centers_m.empty())
    fmt::print("  camera centres {:.2f} mm off (RMS), directions {:.3f}° (median)\n",
               compared->CentersRmsMm(), Median(compared->directions_deg));
  return kOk;
}

}  // namespace

void AddMaskCommand(CLI::App& app, ChosenCommand& chosen) {
  const auto [command, args] = NewSubcommand(
      app, chosen, "mask",
      "Mask the background of a light field whose subject turned before a camera that stood, or what moved "
      "before the lens of single views",
      RunMask);
  command->add_option("DIR", args->dir, "Light field")->required();
  command->add_flag(
      "--moved", args->moved,
      "Mask what single views show and their neighbours do not: a hand before the lens, somebody "
      "who walked through. Needs a mesh (ulf proxy)");
  command
      ->add_option("--size", args->size_px,
                   "Longer side of the pictures that are compared, in pixels (640; with --moved 480); masks "
                   "have the photographs' size")
      ->check(CLI::Range(64, 4096));
  command->add_option("--truth", args->truth,
                      "Simulator that was captured (sim:turntable?...): print how well masks and poses fit");
  command->add_flag("--json", args->json, "Print one JSON object");
  command->footer("Example: ulf mask jug\n         ulf mask vase --moved");
}

}  // namespace ulf::commands
