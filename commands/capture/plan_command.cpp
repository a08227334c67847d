// ulf plan predicts what a capture will need.

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "acquisition/calibration/calibration_io.h"
#include "acquisition/calibration/intrinsics.h"
#include "acquisition/opening/open_device.h"
#include "commands/options/command_line.h"
#include "commands/options/subcommands.h"
#include "core/base/json_text.h"
#include "core/geometry/angles.h"
#include "coverage/bound/capture_prediction.h"
#include "coverage/bound/capture_presets.h"
#include "coverage/bound/coverage_map.h"
#include "coverage/bound/criterion.h"
#include "coverage/session/capture_session.h"

namespace ulf::commands {
namespace {

struct PlanArgs {
  std::string uri, calibration_path;
  std::optional<double> focal_px, width_px;
  double distance = 0;
  double radius = 0;
  double threshold_px = coverage::kHighThresholdPx;
  int coverage_width_px = coverage::kCoverageWidthPx;
  std::string cap = "60x40";
  std::optional<double> angle_deg, distance_ratio;
  bool json = false;
};

// The lens for the planned views.
struct PlannedCamera {
  double focal_px = 0, width_px = 0;
  std::string source;  // empty: given by the user
  bool takes_stills = false;
};

PlannedCamera CameraFrom(const PlanArgs& args) {
  const auto of = [](const CameraModel& camera, std::string source, bool takes_stills) {
    return PlannedCamera{std::max(camera.fx, camera.fy), static_cast<double>(camera.width), std::move(source),
                         takes_stills};
  };
  const bool is_named = !args.uri.empty() || !args.calibration_path.empty();
  if (is_named && (args.focal_px || args.width_px))
    throw UsageError("--focal-px and --width say what {} says as well; leave out one of the two",
                     args.calibration_path.empty() ? args.uri : "--calibration " + args.calibration_path);
  if (!args.uri.empty()) {
    const auto device = acquisition::OpenDevice(args.uri);
    const bool stills = device->TakesStills();
    const acquisition::ResolvedCalibration known = acquisition::ResolveCalibration(
        *device, {.calibration_path = args.calibration_path}, 0, 0, stills ? "still" : "live");
    for (const std::string& warning : known.warnings) spdlog::warn("{}", warning);
    return of(known.camera, known.source, stills);
  }
  if (!args.calibration_path.empty()) {
    const acquisition::CalibrationFile file = acquisition::ReadCalibrationFile(args.calibration_path);
    for (const std::string& warning : file.warnings) spdlog::warn("{}", warning);
    // A calibration file of photographs alone is of a tethered camera.
    const std::string mode =
        file.modes.contains("live") || file.modes.empty() ? "live" : file.modes.begin()->first;
    return of(acquisition::ModeOf(file, mode, args.calibration_path).camera, args.calibration_path,
              mode != "live");
  }
  if (!args.focal_px || !args.width_px)
    throw UsageError(
        "which camera? Give its URI (ulf devices), a file of ulf calibrate (--calibration FILE), or "
        "--focal-px and --width");
  return {*args.focal_px, *args.width_px, {}, false};
}

coverage::CriterionSetup SetupFrom(const PlanArgs& args, const PlannedCamera& camera) {
  const auto require = [](bool good, const char* option, double value) {
    if (!good || !std::isfinite(value)) throw UsageError("{} {} must be a positive number", option, value);
  };
  require(camera.focal_px > 0, "--focal-px", camera.focal_px);
  require(camera.width_px > 0, "--width", camera.width_px);
  require(args.distance > 0, "--distance", args.distance);
  require(args.radius > 0, "--radius", args.radius);
  require(args.threshold_px > 0, "--threshold-px", args.threshold_px);
  require(args.coverage_width_px > 0, "--coverage-width", args.coverage_width_px);
  if (args.radius >= args.distance)
    throw UsageError(
        "--radius {} must be less than --distance {}: the camera stands outside the subject's sphere",
        args.radius, args.distance);
  if (args.angle_deg.has_value() != args.distance_ratio.has_value())
    throw UsageError(
        "--angle-deg and --distance-ratio go together: they place the new view relative to the recorded one");
  if (args.distance_ratio) require(*args.distance_ratio > 0, "--distance-ratio", *args.distance_ratio);
  if (args.angle_deg && !std::isfinite(*args.angle_deg)) throw UsageError("--angle-deg must be a number");
  return {.focal_px = camera.focal_px * args.coverage_width_px / camera.width_px,
          .distance = args.distance,
          .radius = args.radius,
          .threshold_px = args.threshold_px};
}

double SphereImagePx(const coverage::CriterionSetup& setup) {
  return 2 * setup.focal_px * setup.radius /
         std::sqrt(setup.distance * setup.distance - setup.radius * setup.radius);
}

void RequireItFits(const PlanArgs& args, const coverage::CriterionSetup& setup) {
  const double widest = coverage::kRectangleShare * args.coverage_width_px;
  if (SphereImagePx(setup) <= widest) return;
  const double fits_from = setup.radius * std::hypot(1.0, 2 * setup.focal_px / widest);
  throw UsageError(
      "--radius {} at --distance {}: the sphere's image would be {:.0f} px of a picture {} px wide, and "
      "nothing is recorded where it leaves the safety rectangle ({:.0f} px); stand at {:.3g} or farther",
      args.radius, args.distance, SphereImagePx(setup), args.coverage_width_px, widest, fits_from);
}

int RunPlan(const PlanArgs& args) {
  const PlannedCamera camera = CameraFrom(args);
  const coverage::CriterionSetup setup = SetupFrom(args, camera);
  RequireItFits(args, setup);
  const coverage::CapGoal goal = coverage::CapGoal::Parse(args.cap);
  const auto prediction =
      coverage::Predict(setup, goal.cap, goal.share.value_or(coverage::CaptureOptions{}.until_share));
  if (!prediction)
    throw UsageError(
        "--threshold-px {}: a view would not cover even itself; its bound with itself is 2 px, give more",
        args.threshold_px);
  if (const auto doubt = coverage::ThresholdWarning(*prediction, goal.cap, FrameSource::kCamera))
    fmt::print(stderr, "ulf: {}\n", *doubt);
  const double disc_radius_deg = Degrees(prediction->disc_radius);
  const auto ratio = [&](const std::optional<double>& distance) {
    return distance ? std::optional(*distance / setup.distance) : std::nullopt;
  };
  const auto near = ratio(prediction->nearest), far = ratio(prediction->farthest);
  std::optional<double> bound_px;
  if (args.angle_deg)
    bound_px = coverage::AimedBoundPx(setup, Radians(*args.angle_deg), *args.distance_ratio);

  std::optional<coverage::TimeEstimate> time;
  if (!camera.takes_stills) time = coverage::TimeEstimate::Of(*prediction->views, prediction->disc_radius);

  if (args.json) {
    const auto or_null = [](const std::optional<double>& value) {
      return value && std::isfinite(*value) ? nlohmann::json(*value) : nlohmann::json(nullptr);
    };
    nlohmann::json json{{"disc_radius_deg", disc_radius_deg},
                        {"distance_window", {or_null(near), or_null(far)}},
                        {"views_estimate", prediction->views->usual},
                        {"views_spread", {prediction->views->fewest, prediction->views->most}},
                        {"camera", nullptr},
                        {"minutes_estimate", nullptr},
                        {"minutes_spread", nullptr}};
    if (!camera.source.empty())
      json["camera"] = {
          {"focal_px", camera.focal_px}, {"width_px", camera.width_px}, {"source", camera.source}};
    if (time) json["minutes_estimate"] = time->usual_s / 60;
    if (time) json["minutes_spread"] = {time->least_s / 60, time->most_s / 60};
    if (args.angle_deg) json["bound_px"] = or_null(bound_px);
    fmt::print("{}\n", JsonText(json));
    return kOk;
  }
  if (!camera.source.empty())
    fmt::print("camera           focal length {:.0f} px, pictures {:.0f} px wide ({})\n", camera.focal_px,
               camera.width_px, camera.source);
  fmt::print("sphere's image   {:.0f} px of a coverage image {} px wide\n", SphereImagePx(setup),
             args.coverage_width_px);
  fmt::print("one view covers  {:.2f}° around it, within {:g} px\n", disc_radius_deg, args.threshold_px);
  fmt::print("distances        {}\n", coverage::DistancesInWords(near, far, FrameSource::kCamera));
  fmt::print("views            {} for {} degrees\n", InWords(*prediction->views), args.cap);
  fmt::print("time             {}\n",
             time ? InWords(*time) + " for a hand that follows the guidance, at 15 frames a second or more"
                  : "not known: as long as the camera takes for so many photographs, at the least");
  if (bound_px)
    fmt::print("bound            {:.2f} px at {:g}° and {:g} × the distance\n", *bound_px, *args.angle_deg,
               *args.distance_ratio);
  return kOk;
}

}  // namespace

void AddPlanCommand(CLI::App& app, ChosenCommand& chosen) {
  const auto [command, args] = NewSubcommand(
      app, chosen, "plan",
      "Predict a capture: how far one view covers, how many views it takes, and how long", RunPlan);
  command->add_option("URI", args->uri,
                      "Camera, see 'ulf devices': its stored calibration, or what it knows of its lens");
  command->add_option("--calibration", args->calibration_path,
                      "A file of ulf calibrate, in place of the camera's own");
  command->add_option("--focal-px", args->focal_px,
                      "Focal length in pixels of the camera's images, where neither is at hand");
  command->add_option("--width", args->width_px, "... and their width in pixels");
  command->add_option("--distance", args->distance, "Distance from the camera to the subject's centre")
      ->required();
  command->add_option("--radius", args->radius, "Radius of the sphere around the subject, in the same unit")
      ->required();
  CLI::Option* threshold =
      command->add_option("--threshold-px", args->threshold_px, "Largest error in pixels")
          ->capture_default_str();
  command
      ->add_option_function<std::string>(
          "--quality",
          [args = args](const std::string& quality) { args->threshold_px = coverage::ThresholdOf(quality); },
          fmt::format("Threshold by name: high {:g} px, fast {:g} px (default: high)",
                      coverage::kHighThresholdPx, coverage::kFastThresholdPx))
      ->check(CLI::IsMember({"high", "fast"}))
      ->excludes(threshold);
  command
      ->add_option("--coverage-width", args->coverage_width_px,
                   "Width of the image that the threshold refers to")
      ->capture_default_str();
  command
      ->add_option("--cap", args->cap,
                   "Cap to cover, AZIMUTHxELEVATION in degrees such as 60x40 or 60x40:95%")
      ->capture_default_str();
  command->add_option("--angle-deg", args->angle_deg,
                      "Print the bound of a view at this angle from the recorded one");
  command->add_option("--distance-ratio", args->distance_ratio, "... and at this multiple of its distance");
  command->add_flag("--json", args->json, "Print one JSON object");
  command->footer(
      "Example: ulf plan --focal-px 600 --width 640 --distance 1 --radius 0.15 --cap 60x40\n"
      "         ulf plan aravis:192.168.1.20 --distance 1 --radius 0.15 --quality fast");
}

}  // namespace ulf::commands
