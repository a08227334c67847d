#include "commands/reports/light_field_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "commands/options/command_line.h"
#include "core/base/counted.h"
#include "core/base/quantile.h"
#include "core/geometry/angles.h"
#include "core/light_field/findings.h"
#include "core/light_field/folder/unposed_photographs.h"
#include "coverage/bound/view_decision.h"
#include "coverage/measured/error_meter.h"
#include "coverage/measured/threshold_by_errors.h"
#include "render/viewpoints/viewpoint_mesh.h"

namespace ulf::commands {
namespace {

using Eigen::Vector3d;

// Returns the smallest arc that holds all angles.
double AngularSpan(std::vector<double> angles) {
  std::ranges::sort(angles);
  double widest_gap = angles.front() + 2 * M_PI - angles.back();
  for (std::size_t i = 1; i < angles.size(); ++i)
    widest_gap = std::max(widest_gap, angles[i] - angles[i - 1]);
  return 2 * M_PI - widest_gap;
}

Eigen::Vector2d AngularRange(const std::vector<Vector3d>& directions, const Vector3d& up) {
  const Vector3d& first = directions.front();
  const bool within_hemisphere =
      std::ranges::all_of(directions, [&](const Vector3d& direction) { return direction.dot(first) > 0; });
  const Vector3d level = first - first.dot(up) * up;
  const coverage::CapFrame frame(within_hemisphere || level.norm() < 1e-6 ? first : level, up);
  std::vector<double> azimuths, elevations;
  for (const Vector3d& direction : directions) {
    azimuths.push_back(frame.Of(direction).azimuth);
    elevations.push_back(frame.Of(direction).elevation);
  }
  const auto [lowest, highest] = std::ranges::minmax_element(elevations);
  return {AngularSpan(std::move(azimuths)), *highest - *lowest};
}

LightFieldReport::Distances DistancesOf(const LightField& light_field, const Subject& subject) {
  const std::vector<double> distances = DistancesTo(subject, light_field.views, &View::CenterInWorld);
  const auto [nearest, farthest] = std::ranges::minmax(distances);
  return {nearest, Median(distances), farthest};
}

std::size_t CountDuplicates(const std::vector<coverage::CriterionView>& views, const Subject& subject,
                            double threshold_px) {
  coverage::SubjectViews earlier(subject);
  std::size_t duplicates = 0;
  for (const coverage::CriterionView& view : views) {
    duplicates += earlier.Covers(view, threshold_px);
    earlier.Add(view);
  }
  return duplicates;
}

// Returns the exposure ratio in stops by time, gain and aperture.
double StopsBetween(const View& view, const ViewExposure& exposure) {
  const double opening =
      view.f_number && exposure.f_number ? std::pow(*view.f_number / *exposure.f_number, 2) : 1;
  return std::log2(exposure.exposure_s * exposure.gain * opening / (view.exposure_s * view.gain));
}

std::optional<LightFieldReport::Brackets> BracketsOf(const LightField& light_field) {
  LightFieldReport::Brackets brackets;
  for (const View& view : light_field.views) {
    if (view.exposures.empty()) continue;
    const std::size_t exposures = view.exposures.size() + 1;
    brackets.fewest = brackets.views == 0 ? exposures : std::min(brackets.fewest, exposures);
    brackets.most = std::max(brackets.most, exposures);
    ++brackets.views;
    brackets.stops.insert(0);
    for (const ViewExposure& each : view.exposures)
      if (view.exposure_s > 0) brackets.stops.insert(std::round(10 * StopsBetween(view, each)) / 10 + 0.0);
    if (!view.merged) continue;
    ++brackets.merged;
    if (brackets.ghosts_most && view.merged->ghost_share <= *brackets.ghosts_most) continue;
    brackets.ghosts_most = view.merged->ghost_share;
    brackets.ghosts_most_view = view.id;
  }
  return brackets.views > 0 ? std::optional(brackets) : std::nullopt;
}

std::string BracketsText(const LightFieldReport::Brackets& brackets) {
  std::string stops;
  for (const double each : brackets.stops)
    stops += (stops.empty() ? "" : ", ") + (each == 0 ? "0" : fmt::format("{:+g}", each));
  std::string text = fmt::format("brackets       {} of {} ({} stops), ", Counted(brackets.views, "view"),
                                 brackets.fewest == brackets.most
                                     ? fmt::format("{} exposures", brackets.most)
                                     : fmt::format("{} to {} exposures", brackets.fewest, brackets.most),
                                 stops);
  if (!brackets.ghosts_most) return text + "none merged (ulf merge)\n";
  return text + fmt::format("{} merged; ghosts in at most {:.1f} % of a view's pixels (view {})\n",
                            brackets.merged == brackets.views ? "all" : fmt::format("{}", brackets.merged),
                            100 * *brackets.ghosts_most, brackets.ghosts_most_view);
}

std::string LensesText(const LightFieldReport& report) {
  if (report.lenses.empty()) return {};
  const LightFieldReport::Lens& last = report.lenses.back();
  std::string text = fmt::format("camera         {} x {} px, focal length {:.1f} px", last.camera.width,
                                 last.camera.height, last.camera.MeanFocalPx());
  if (!last.source.empty()) text += fmt::format(" (from: {})", last.source);
  if (report.lenses.size() > 1)
    text += fmt::format(", and {}", Counted(report.lenses.size() - 1, "earlier camera"));
  return text + "\n";
}

// Counts views of sessions that were not closed: closing writes the counts of frames.
std::size_t UncountedViews(const LightField& light_field) {
  if (light_field.device_uri.empty() || light_field.device_uri.starts_with("import:")) return 0;
  const auto counted = light_field.reasons.find(Name(coverage::Reason::kRecorded));
  const std::uint64_t recorded = counted == light_field.reasons.end() ? 0 : counted->second;
  const std::uint64_t views = light_field.views.size() + light_field.taken_back.size();
  return recorded < views ? views - recorded : 0;
}

std::string ReasonsText(const LightFieldReport& report) {
  std::string reasons;
  for (const auto& [reason, count] : report.reasons)
    if (count > 0)
      reasons += fmt::format("{}{} {}", reasons.empty() ? "" : ", ", count, coverage::InWords(reason));
  std::string text = reasons.empty() ? reasons : "frames         " + reasons + "\n";
  if (report.uncounted_views > 0)
    text += fmt::format(
        "not counted    the frames and the time of a session that was not closed (killed, or still running): "
        "{} of it\n",
        Counted(report.uncounted_views, "view"));
  return text;
}

}  // namespace

LightFieldReport Describe(const LightField& light_field, const ReportOptions& options) {
  LightFieldReport report;
  report.views = light_field.views.size();
  for (std::size_t i = 0; i < light_field.cameras.size(); ++i)
    report.lenses.push_back({light_field.cameras[i], 0, light_field.CalibrationSource(static_cast<int>(i))});
  for (const View& view : light_field.views) ++report.lenses[At(view.camera)].views;
  report.taken_back = CountTakenBack(light_field);
  report.capture_s = light_field.capture_s;
  report.units = light_field.units;
  report.reasons = light_field.reasons;
  report.uncounted_views = UncountedViews(light_field);
  report.brackets = BracketsOf(light_field);
  report.cap = options.cap;
  if (!report.cap && light_field.goal) report.cap = coverage::Cap::FromDegrees(light_field.goal->cap_deg);
  report.threshold_px = options.threshold_px ? *options.threshold_px
                                             : light_field.threshold_px.value_or(coverage::kHighThresholdPx);
  report.subject = options.subject ? options.subject : light_field.subject;
  if (!report.subject && !light_field.views.empty()) report.subject = SubjectFromAxes(light_field);
  // Directions relative to another subject are not comparable.
  if (report.subject == light_field.subject) report.measured = coverage::ValidErrors(light_field);
  if (light_field.views.empty()) {
    if (report.cap) report.covered = 0;
    return report;
  }
  if (!report.subject) {
    if (options.cap)
      throw UsageError(
          "{}: is a walk without a subject, so there is no cap to measure; for views of a subject give "
          "--subject x,y,z,radius, else leave out --cap",
          light_field.root.string());
    return report;
  }
  std::vector<Vector3d> directions, centers;
  for (const View& view : light_field.views) centers.push_back(view.CenterInWorld());
  const render::ViewpointMesh mesh = render::MakeViewpointMesh(centers, *report.subject);
  if (mesh.span == render::Span::kSurface) report.mean_edge_deg = Degrees(mesh.mean_edge_rad);
  for (const View& view : light_field.views)
    if (const Vector3d offset = view.CenterInWorld() - report.subject->center_in_world; offset.norm() > 0)
      directions.push_back(offset.normalized());
  if (!directions.empty())
    report.angular_range_deg = AngularRange(directions, light_field.UpInWorld()).unaryExpr(&Degrees);
  report.distances = DistancesOf(light_field, *report.subject);
  report.duplicates =
      CountDuplicates(coverage::CriterionViews(light_field), *report.subject, report.threshold_px);
  if (report.cap) {
    coverage::CoverageMap map =
        coverage::CoverageOf(light_field, *report.subject, report.cap, report.threshold_px);
    if (report.measured && coverage::CoverByNamed(report.measured->cover) != coverage::CoverBy::kBound) {
      report.covered_by_bound = map.CoveredShare();
      map = coverage::CoverageByErrors(*report.measured, map);
    }
    report.covered = map.CoveredShare();
    report.holes = coverage::GapsOf(map);
  }
  return report;
}

std::string ToText(const MeasuredErrors& measured) {
  const coverage::ErrorSummary errors = Summarize(coverage::ErrorMapOf(measured), measured.goal_db);
  std::string text = fmt::format("measured       {}", Counted(measured.frames, "frame"));
  if (errors.directions == 0) return text + ": in no direction was there texture and geometry enough\n";
  text += fmt::format(
      ": picture quality {} (median {:.1f} dB), in the worst tenth of {} {} ({:.1f} dB); {:.2f} px off in "
      "pictures {} px wide; around the subject {} ({:.1f} dB)\n",
      coverage::QualityInWords(errors.median_db), errors.median_db, Counted(errors.directions, "direction"),
      coverage::QualityInWords(errors.worst_tenth_db), errors.worst_tenth_db, errors.median_px,
      coverage::ErrorMeter::Options{}.size_px, coverage::QualityInWords(errors.median_outside_db),
      errors.median_outside_db);
  if (errors.failing == 0) return text;
  std::string causes;
  for (const auto& [cause, count] : errors.causes)
    causes += fmt::format("{}{} {}", causes.empty() ? "" : ", ", count, InWords(cause));
  return text +
         fmt::format("               below {:g} dB in {}: {}\n", measured.goal_db, errors.failing, causes);
}

nlohmann::json ToJson(const MeasuredErrors& measured) {
  const coverage::ErrorSummary errors = Summarize(coverage::ErrorMapOf(measured), measured.goal_db);
  nlohmann::json causes = nlohmann::json::object();
  for (const auto& [cause, count] : errors.causes) causes[Name(cause)] = count;
  return {{"cover", measured.cover},
          {"goal_db", measured.goal_db},
          {"frames", measured.frames},
          {"directions", errors.directions},
          {"failing", errors.failing},
          {"median_db", errors.median_db},
          {"worst_tenth_db", errors.worst_tenth_db},
          {"median_px", errors.median_px},
          {"median_outside_db", errors.median_outside_db},
          {"causes", causes}};
}

nlohmann::json ToJson(const LightFieldReport& report) {
  nlohmann::json json{
      {"views", report.views},
      {"lenses", nlohmann::json::array()},
      {"taken_back", report.taken_back},
      {"capture_s", report.capture_s > 0 ? nlohmann::json(report.capture_s) : nullptr},  // null: unknown
      {"angular_range_deg", nullptr},
      {"mean_edge_deg", report.mean_edge_deg ? nlohmann::json(*report.mean_edge_deg) : nullptr},
      {"subject", nullptr},
      {"cap_deg", nullptr},
      {"covered", report.covered ? nlohmann::json(*report.covered) : nullptr},
      {"covered_by_bound", report.covered_by_bound ? nlohmann::json(*report.covered_by_bound) : nullptr},
      {"measured", report.measured ? ToJson(*report.measured) : nullptr},
      {"holes", nullptr},
      {"distance", nullptr},
      {"threshold_px", report.threshold_px},
      {"units", report.units},
      {"duplicates", report.duplicates},
      {"reasons", report.reasons},
      {"uncounted_views", report.uncounted_views},
      {"brackets", nullptr}};
  for (const LightFieldReport::Lens& lens : report.lenses)
    json["lenses"].push_back({{"width", lens.camera.width},
                              {"height", lens.camera.height},
                              {"focal_px", lens.camera.MeanFocalPx()},
                              {"views", lens.views},
                              {"calibration_source", lens.source}});
  if (report.angular_range_deg)
    json["angular_range_deg"] = {report.angular_range_deg->x(), report.angular_range_deg->y()};
  if (report.subject) {
    const Vector3d& center = report.subject->center_in_world;
    json["subject"] = {{"center", {center.x(), center.y(), center.z()}}, {"radius", report.subject->radius}};
  }
  if (report.cap) json["cap_deg"] = {report.cap->Degrees().x(), report.cap->Degrees().y()};
  if (report.covered) {
    json["holes"] = nlohmann::json::array();
    for (const coverage::CapGap& hole : report.holes)
      json["holes"].push_back({{"area_deg2", hole.area_deg2},
                               {"azimuth_deg", hole.azimuth_deg},
                               {"elevation_deg", hole.elevation_deg}});
  }
  if (report.distances)
    json["distance"] = {{"nearest", report.distances->nearest},
                        {"median", report.distances->median},
                        {"farthest", report.distances->farthest}};
  if (const auto& brackets = report.brackets) {
    json["brackets"] = {{"views", brackets->views},
                        {"exposures", {{"fewest", brackets->fewest}, {"most", brackets->most}}},
                        {"stops", brackets->stops},
                        {"merged", brackets->merged},
                        {"ghosts_most", nullptr}};
    if (brackets->ghosts_most) {
      json["brackets"]["ghosts_most"] = *brackets->ghosts_most;
      json["brackets"]["ghosts_most_view"] = brackets->ghosts_most_view;
    }
  }
  return json;
}

std::string ToText(const LightFieldReport& report) {
  std::string text = fmt::format("views          {}\n", report.views);
  if (report.taken_back > 0) text += fmt::format("taken back     {}, kept in unposed/\n", report.taken_back);
  text += report.capture_s > 0
              ? fmt::format("capture time   {:.0f} s by the camera's clock\n", report.capture_s)
              : "capture time   unknown\n";
  text += LensesText(report);
  if (report.brackets) text += BracketsText(*report.brackets);
  if (report.views > 0 && !report.subject)
    return text +
           "subject        none: a walk without a subject; for videos of a subject give --subject "
           "x,y,z,radius\n" +
           ReasonsText(report);
  if (report.angular_range_deg)
    text += fmt::format("angular range  {:.0f} x {:.0f} degrees around the subject\n",
                        report.angular_range_deg->x(), report.angular_range_deg->y());
  text += report.mean_edge_deg
              ? fmt::format("neighbours     {:.2f} degrees apart on average\n", *report.mean_edge_deg)
              : "neighbours     the views span no surface: a row, a ring, or too few of them\n";
  if (report.subject)
    text += fmt::format("subject        centre {:.3f} {:.3f} {:.3f}, radius {:.3f} ({})\n",
                        report.subject->center_in_world.x(), report.subject->center_in_world.y(),
                        report.subject->center_in_world.z(), report.subject->radius,
                        report.units == "arbitrary" ? "arbitrary units" : report.units);
  if (report.covered)
    text +=
        fmt::format("covered        {:.1f} % of {:g} x {:g} degrees {}\n", 100 * *report.covered,
                    report.cap->Degrees().x(), report.cap->Degrees().y(),
                    report.covered_by_bound ? fmt::format("to {:g} dB as measured ({:.1f} % within {:g} px)",
                                                          report.measured->goal_db,
                                                          100 * *report.covered_by_bound, report.threshold_px)
                                            : fmt::format("within {:g} px", report.threshold_px));
  if (!report.holes.empty()) text += fmt::format("gaps           {}\n", InWords(report.holes, *report.cap));
  if (report.measured) text += ToText(*report.measured);
  if (report.distances)
    text += fmt::format("distances      {:.3g} to {:.3g}, median {:.3g} (from {:.0f} to {:.0f} % of it)\n",
                        report.distances->nearest, report.distances->farthest, report.distances->median,
                        100 * report.distances->nearest / report.distances->median,
                        100 * report.distances->farthest / report.distances->median);
  if (report.duplicates > 0)
    text += fmt::format("duplicates     {} covered by earlier ones within {:g} px\n",
                        Counted(report.duplicates, "view"), report.threshold_px);
  return text + ReasonsText(report);
}

std::string TableText(const std::vector<NamedReport>& reports) {
  std::vector<std::vector<std::string>> rows{
      {"light field", "views", "capture time, min", "angular range, degrees", "average angle, degrees"}};
  const bool has_caps =
      std::ranges::any_of(reports, [](const NamedReport& one) { return one.report.covered.has_value(); });
  if (has_caps) rows[0].push_back("covered, % of the cap");
  const auto or_dash = [](const auto& value, auto text) { return value ? text(*value) : std::string("-"); };
  for (const NamedReport& one : reports) {
    const LightFieldReport& report = one.report;
    rows.push_back(
        {one.name, fmt::format("{}", report.views),
         report.capture_s > 0 ? fmt::format("{:.1f}", report.capture_s / 60) : "-",
         or_dash(report.angular_range_deg,
                 [](const Eigen::Vector2d& deg) { return fmt::format("{:.0f}x{:.0f}", deg.x(), deg.y()); }),
         or_dash(report.mean_edge_deg, [](double deg) { return fmt::format("{:.2f}", deg); })});
    if (has_caps)
      rows.back().push_back(or_dash(report.covered, [&report](double share) {
        return fmt::format("{:.1f} of {:g}x{:g}", 100 * share, report.cap->Degrees().x(),
                           report.cap->Degrees().y());
      }));
  }
  std::vector<std::size_t> widths(rows[0].size(), 0);
  for (const auto& row : rows)
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  std::string text;
  for (const auto& row : rows) {
    text += fmt::format("{:<{}}", row[0], widths[0]);
    for (std::size_t i = 1; i < row.size(); ++i) text += fmt::format("  {:>{}}", row[i], widths[i]);
    text += "\n";
  }
  return text;
}

nlohmann::json TableJson(const std::vector<NamedReport>& reports) {
  nlohmann::json rows = nlohmann::json::array();
  for (const NamedReport& one : reports) {
    nlohmann::json row = ToJson(one.report);
    row["name"] = one.name;
    rows.push_back(std::move(row));
  }
  return {{"light_fields", std::move(rows)}};
}

}  // namespace ulf::commands
