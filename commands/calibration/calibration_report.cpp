#include "commands/calibration/calibration_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>

#include "core/base/counted.h"
#include "core/geometry/angles.h"
#include "core/geometry/small_matrices.h"

namespace ulf::commands {
namespace {

std::vector<const char*> CoefficientNames(Distortion distortion) {
  if (distortion == Distortion::kFisheye) return {"k1", "k2", "k3", "k4"};
  if (distortion == Distortion::kRadialTangential) return {"k1", "k2", "p1", "p2", "k3"};
  return {};
}

double WorstPx(const acquisition::CalibrationResult& result) {
  double worst = 0;
  for (const acquisition::ViewReport& view : result.reports) worst = std::max(worst, view.rms_px);
  return worst;
}

}  // namespace

double LargestDifferencePx(const CameraModel& a, const CameraModel& b, double reach) {
  constexpr int kSteps = 16;
  std::vector<Eigen::Vector2d> imgs;
  std::vector<Eigen::Vector3d> in_a, in_b;
  for (int y = 0; y <= kSteps; ++y)
    for (int x = 0; x <= kSteps; ++x) {
      const Eigen::Vector2d img(a.width * static_cast<double>(x) / kSteps,
                                a.height * static_cast<double>(y) / kSteps);
      const Eigen::Vector2d middle(0.5 * a.width, 0.5 * a.height);
      if ((img - middle).norm() > reach * middle.norm()) continue;
      const auto ray_a = a.RayFromImg(img), ray_b = b.RayFromImg(img);
      if (!ray_a || !ray_b) continue;
      imgs.push_back(img);
      in_a.push_back(*ray_a);
      in_b.push_back(*ray_b);
    }
  // A rotation of the camera is not a difference between lenses (Wahba's problem, by singular values).
  Eigen::Matrix3d mixed = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < imgs.size(); ++i) mixed += in_b[i] * in_a[i].transpose();
  const SingularValues3 svd = SingularValuesOf(mixed);
  Eigen::Vector3d signs(1, 1, (svd.u * svd.v.transpose()).determinant());
  const Eigen::Matrix3d b_from_a = svd.u * signs.asDiagonal() * svd.v.transpose();
  double largest = 0;
  for (std::size_t i = 0; i < imgs.size(); ++i)
    if (const auto img = b.ImgFromCam(b_from_a * in_a[i]))
      largest = std::max(largest, (*img - imgs[i]).norm());
  return largest;
}

std::string CandidateTable(const acquisition::LensChoice& choice) {
  std::string text = fmt::format("  {:<40}{:>4}{:>10}{:>12}{:>12}{:>10}\n", "model", "", "RMS px", "left out",
                                 "BIC", "focal px");
  for (std::size_t i = 0; i < choice.table.size(); ++i) {
    const acquisition::CandidateResult& row = choice.table[i];
    fmt::format_to(std::back_inserter(text), "{} {:<40}{:>4}{:>10.4f}{:>12.4f}{:>12.1f}{:>10.2f}{}{}\n",
                   i == choice.chosen ? '*' : ' ', row.fit.candidate.name, row.fit.candidate.Parameters(),
                   row.fit.RmsPx(), row.LeftOutRmsPx(), row.bic, row.fit.camera.MeanFocalPx(),
                   row.explains ? "  explains the data" : "",
                   row.folds_inside_image ? "  not invertible everywhere" : "");
  }
  text +=
      "  A model explains the data when no other is better both by BIC (by more than 10) and on left-out "
      "views\n"
      "  (by more than two standard errors). Chosen (*): the model with the fewest parameters that explains "
      "the data.\n";
  return text;
}

std::string ReportText(const acquisition::CalibrationResult& result,
                       const std::optional<CameraModel>& truth) {
  const CameraModel& camera = result.camera;
  const acquisition::CandidateResult& chosen = result.choice.table[result.choice.chosen];
  std::string text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "model            {} ({} of {} candidates explain the data)\n",
                 chosen.fit.candidate.name,
                 std::ranges::count_if(result.choice.table, &acquisition::CandidateResult::explains),
                 result.choice.table.size());
  fmt::format_to(out, "image            {} x {} px, {:.1f} degrees across the diagonal\n", camera.width,
                 camera.height, Degrees(2 * camera.MaxRayAngle()));
  fmt::format_to(out, "focal length     fx {:.2f} +- {:.2f}, fy {:.2f} +- {:.2f} px\n", camera.fx,
                 result.sigma[0], camera.fy, result.sigma[1]);
  fmt::format_to(out,
                 "principal point  cx {:.2f} +- {:.2f}, cy {:.2f} +- {:.2f} px (pixel centres at one half)\n",
                 camera.cx, result.sigma[2], camera.cy, result.sigma[3]);
  const auto names = CoefficientNames(camera.distortion);
  for (std::size_t i = 0; i < names.size(); ++i)
    if (chosen.fit.candidate.estimated[i])
      fmt::format_to(out, "{:<17}{:.6f} +- {:.6f}\n", names[i], camera.coefficients[i], result.sigma[4 + i]);
  fmt::format_to(out, "error            {:.3f} px RMS, {:.3f} px on views left out, worst view {:.3f} px\n",
                 result.rms_px, chosen.LeftOutRmsPx(), WorstPx(result));
  fmt::format_to(out, "used             {} of {}; left out {} and {}\n", Counted(result.corners, "corner"),
                 Counted(result.views.size(), "view"), Counted(result.outliers, "corner"),
                 Counted(result.reports.size() - result.views.size(), "view"));
  const acquisition::BoardCoverage& coverage = result.coverage;
  fmt::format_to(out,
                 "coverage         {:.0f} % of the image; tilts: left {:.0f}, right {:.0f}, upper {:.0f}, "
                 "lower {:.0f} degrees away\n",
                 100 * coverage.CellShare(), Degrees(coverage.left), Degrees(coverage.right),
                 Degrees(coverage.upper), Degrees(coverage.lower));
  if (truth)
    fmt::format_to(out,
                   "truth            fx {:.2f}, fy {:.2f}, cx {:.2f}, cy {:.2f} px; images differ by at most "
                   "{:.2f} px where corners were seen, {:.2f} px anywhere\n",
                   truth->fx, truth->fy, truth->cx, truth->cy,
                   LargestDifferencePx(*truth, camera, result.coverage.reach),
                   LargestDifferencePx(*truth, camera));
  for (const acquisition::ViewReport& view : result.reports)
    if (!view.left_out.empty()) fmt::format_to(out, "left out         {}: {}\n", view.name, view.left_out);
  for (const std::string& warning : result.warnings) fmt::format_to(out, "warning          {}\n", warning);
  return text;
}

nlohmann::ordered_json ReportJson(const acquisition::CalibrationResult& result) {
  using Json = nlohmann::ordered_json;
  Json json;
  json["board"] = result.board.Text();
  json["refusal"] = result.refusal;
  Json views = Json::array();
  for (const acquisition::ViewReport& view : result.reports)
    views.push_back({{"name", view.name},
                     {"corners", view.corners},
                     {"outliers", view.outliers},
                     {"rms_px", view.rms_px},
                     {"left_out", view.left_out}});
  if (!result.ok()) {
    json["views"] = views;
    return json;
  }
  const CameraModel& camera = result.camera;
  const acquisition::CandidateResult& chosen = result.choice.table[result.choice.chosen];
  json["model"] = chosen.fit.candidate.name;
  json["camera"] = {{"width", camera.width},
                    {"height", camera.height},
                    {"fx", camera.fx},
                    {"fy", camera.fy},
                    {"cx", camera.cx},
                    {"cy", camera.cy},
                    {"coefficients", camera.coefficients}};
  json["sigma"] = result.sigma;
  json["rms_px"] = result.rms_px;
  json["left_out_rms_px"] = chosen.LeftOutRmsPx();
  json["corners"] = result.corners;
  json["outliers"] = result.outliers;
  json["coverage_share"] = result.coverage.CellShare();
  json["warnings"] = result.warnings;
  Json table = Json::array();
  for (const acquisition::CandidateResult& row : result.choice.table)
    table.push_back({{"model", row.fit.candidate.name},
                     {"parameters", row.fit.candidate.Parameters()},
                     {"rms_px", row.fit.RmsPx()},
                     {"left_out_rms_px", row.LeftOutRmsPx()},
                     {"bic", row.bic},
                     {"explains", row.explains}});
  json["candidates"] = table;
  json["views"] = views;
  return json;
}

namespace {

using acquisition::ColorFit;
using acquisition::PatchDifference;
using Json = nlohmann::ordered_json;

// Numbers patches as their maker counts them.
std::string Numbers(const std::vector<int>& patches) {
  std::string list;
  for (const int patch : patches) list += fmt::format("{}{}", list.empty() ? "" : ", ", patch + 1);
  return list;
}

Json MeanAndMost(const ColorFit& fit, double PatchDifference::*which) {
  return {{"mean", fit.Mean(which)}, {"most", fit.Most(which)}};
}

}  // namespace

std::string BalanceText(const std::array<double, 3>& white_balance) {
  return fmt::format("R {:.4g}, G {:.4g}, B {:.4g}", white_balance[0], white_balance[1], white_balance[2]);
}

std::string ColorFitText(const ColorFit& fit, std::size_t found, std::size_t looked_at) {
  std::string text =
      fmt::format("chart            found in {} of {}\n", found, Counted(looked_at, "picture"));
  if (!fit.ok()) return text + "refused: " + fit.refusal + "\n";
  const auto row = [&](const char* name, double PatchDifference::*which) {
    text += fmt::format("  {:<36}{:6.2f} {:6.2f}\n", name, fit.Mean(which), fit.Most(which));
  };
  text += fmt::format("white balance    {}\n", BalanceText(fit.profile.white_balance));
  const auto& m = fit.profile.matrix;
  for (int i = 0; i < 9; i += 3)
    text +=
        fmt::format("{:<17}{:8.4f} {:8.4f} {:8.4f}\n", i == 0 ? "matrix" : "", m[static_cast<std::size_t>(i)],
                    m[static_cast<std::size_t>(i + 1)], m[static_cast<std::size_t>(i + 2)]);
  text += fmt::format("difference (CIEDE2000) of {}, mean and largest:\n",
                      fmt::format("{} patches", fit.patches.size()));
  row("as recorded", &PatchDifference::as_recorded);
  row("white balance alone", &PatchDifference::balanced);
  row("with the profile", &PatchDifference::profiled);
  row("on patches left out of the profile", &PatchDifference::held_out);
  if (!fit.clipped.empty())
    text +=
        fmt::format("warning          patches {} are clipped and took no part: the next time expose less\n",
                    Numbers(fit.clipped));
  if (!fit.uneven.empty())
    text += fmt::format(
        "warning          patches {} are uneven (a reflection, a shadow) or dark and took no part\n",
        Numbers(fit.uneven));
  constexpr double kPoor = 5;  // ten times the visible difference. Guessed.
  if (fit.Mean(&PatchDifference::held_out) > kPoor)
    text +=
        "warning          the profile hardly fits: is the light even, of one lamp, the chart clean, and are "
        "the camera's own corrections (gamma, saturation, automatic balance) off?\n";
  return text;
}

Json ColorFitJson(const ColorFit& fit, std::size_t found, std::size_t looked_at) {
  Json json{{"refusal", fit.refusal}, {"pictures", looked_at}, {"charts_found", found}};
  if (!fit.ok()) return json;
  json["white_balance"] = fit.profile.white_balance;
  json["matrix"] = fit.profile.matrix;
  json["delta_e"] = {{"as_recorded", MeanAndMost(fit, &PatchDifference::as_recorded)},
                     {"balanced", MeanAndMost(fit, &PatchDifference::balanced)},
                     {"profiled", MeanAndMost(fit, &PatchDifference::profiled)},
                     {"held_out", MeanAndMost(fit, &PatchDifference::held_out)}};
  json["patches"] = Json::array();
  for (const PatchDifference& patch : fit.patches)
    json["patches"].push_back({{"patch", patch.patch + 1},
                               {"as_recorded", patch.as_recorded},
                               {"balanced", patch.balanced},
                               {"profiled", patch.profiled},
                               {"held_out", patch.held_out}});
  const auto numbers = [](const std::vector<int>& patches) {
    Json list = Json::array();
    for (const int patch : patches) list.push_back(patch + 1);
    return list;
  };
  json["clipped_patches"] = numbers(fit.clipped);
  json["uneven_patches"] = numbers(fit.uneven);
  return json;
}

std::string GreyCardText(const acquisition::GreyCard& card) {
  if (!card.ok()) return "refused: " + card.refusal + "\n";
  return fmt::format(
      "white balance    {}\ncard             {:.0f} % of full scale, colours even within {:.1f} %\n",
      BalanceText(card.white_balance), 100 * card.light, 100 * card.unevenness);
}

Json GreyCardJson(const acquisition::GreyCard& card) {
  return {{"refusal", card.refusal},
          {"white_balance", card.white_balance},
          {"light", card.light},
          {"unevenness", card.unevenness}};
}

}  // namespace ulf::commands
