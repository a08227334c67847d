// ulf plan: what a capture will ask for, before there is one.

#include <CLI/CLI.hpp>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands/commands.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/geometry/angles.h"
#include "coverage/bound/capture_prediction.h"
#include "coverage/bound/coverage_map.h"
#include "coverage/bound/criterion.h"
#include "coverage/session/capture_session.h"

namespace ulf::commands {
namespace {

struct PlanArgs {
  double focal_px = 0;
  double width_px = 0;
  double distance = 0;
  double radius = 0;
  double threshold_px = 7;
  int coverage_width_px = 640;
  std::string cap = "60x40";
  std::optional<double> angle_deg, distance_ratio;
  bool json = false;
};

coverage::CriterionSetup SetupFrom(const PlanArgs& args) {
  const auto require = [](bool good, const char* option, double value) {
    if (!good || !std::isfinite(value)) throw UsageError("{} {} must be a positive number", option, value);
  };
  require(args.focal_px > 0, "--focal-px", args.focal_px);
  require(args.width_px > 0, "--width", args.width_px);
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
  return {.focal_px = args.focal_px * args.coverage_width_px / args.width_px,
          .distance = args.distance,
          .radius = args.radius,
          .threshold_px = args.threshold_px};
}

double SphereImagePx(const coverage::CriterionSetup& setup) {
  return 2 * setup.focal_px * setup.radius /
         std::sqrt(setup.distance * setup.distance - setup.radius * setup.radius);
}

void RequireItFits(const PlanArgs& args, const coverage::CriterionSetup& setup) {
  const double widest = coverage::DecisionLimits{}.rectangle_share * args.coverage_width_px;
  if (SphereImagePx(setup) <= widest) return;
  const double fits_from = setup.radius * std::hypot(1.0, 2 * setup.focal_px / widest);
  throw UsageError(
      "--radius {} at --distance {}: the sphere's image would be {:.0f} px of a picture {} px wide, and "
      "nothing is recorded where it leaves the safety rectangle ({:.0f} px); stand at {:.3g} or farther",
      args.radius, args.distance, SphereImagePx(setup), args.coverage_width_px, widest, fits_from);
}

int RunPlan(const PlanArgs& args) {
  const coverage::CriterionSetup setup = SetupFrom(args);
  RequireItFits(args, setup);
  const coverage::CapGoal goal = coverage::CapGoal::Parse(args.cap);
  const auto prediction =
      coverage::Predict(setup, goal.cap, goal.share.value_or(coverage::CaptureOptions{}.until_share));
  if (!prediction)
    throw UsageError(
        "--threshold-px {}: a view would not cover even itself; its bound with itself is 2 px, give more",
        args.threshold_px);
  if (const auto doubt = coverage::ThresholdWarning(*prediction, goal.cap))
    fmt::print(stderr, "ulf: {}\n", *doubt);
  const double disc_radius_deg = Degrees(prediction->disc_radius);
  const auto ratio = [&](const std::optional<double>& distance) {
    return distance ? std::optional(*distance / setup.distance) : std::nullopt;
  };
  const auto near = ratio(prediction->nearest), far = ratio(prediction->farthest);
  std::optional<double> bound_px;
  if (args.angle_deg)
    bound_px = coverage::AimedBoundPx(setup, Radians(*args.angle_deg), *args.distance_ratio);

  if (args.json) {
    const auto or_null = [](const std::optional<double>& value) {
      return value && std::isfinite(*value) ? nlohmann::json(*value) : nlohmann::json(nullptr);
    };
    nlohmann::json json{{"disc_radius_deg", disc_radius_deg},
                        {"distance_window", {or_null(near), or_null(far)}},
                        {"views_estimate", prediction->views->usual},
                        {"views_spread", {prediction->views->fewest, prediction->views->most}}};
    if (args.angle_deg) json["bound_px"] = or_null(bound_px);
    fmt::print("{}\n", JsonText(json));
    return kOk;
  }
  fmt::print("sphere's image   {:.0f} px of a coverage image {} px wide\n", SphereImagePx(setup),
             args.coverage_width_px);
  fmt::print("one view covers  {:.2f}° around it, within {:g} px\n", disc_radius_deg, args.threshold_px);
  fmt::print("distances        from {} to {} times the recorded one\n",
             near ? fmt::format("{:.3f}", *near) : "0", far ? fmt::format("{:.3f}", *far) : "any number of");
  fmt::print("views            {} for {} degrees\n", InWords(*prediction->views), args.cap);
  if (bound_px)
    fmt::print("bound            {:.2f} px at {:g}° and {:g} × the distance\n", *bound_px, *args.angle_deg,
               *args.distance_ratio);
  return kOk;
}

}  // namespace

void AddPlanCommand(CLI::App& app, ChosenCommand& chosen) {
  auto args = std::make_shared<PlanArgs>();
  CLI::App* command =
      app.add_subcommand("plan", "Predict a capture: how far one view covers, and how many views it takes");
  command->add_option("--focal-px", args->focal_px, "Focal length in pixels of the camera's images")
      ->required();
  command->add_option("--width", args->width_px, "Width of the camera's images in pixels")->required();
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
          [args](const std::string& quality) { args->threshold_px = quality == "fast" ? 12 : 7; },
          "Threshold by name: high 7 px, fast 12 px (default: high)")
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
  command->footer("Example: ulf plan --focal-px 600 --width 640 --distance 1 --radius 0.15 --cap 60x40");
  command->callback([args, &chosen] { chosen = [args] { return RunPlan(*args); }; });
}

}  // namespace ulf::commands
