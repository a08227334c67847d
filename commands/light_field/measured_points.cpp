#include "commands/light_field/measured_points.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <utility>
#include <vector>

#include "core/base/counted.h"
#include "tracking/refine/refine_input.h"
#include "tracking/refine/triangulate.h"

namespace ulf::commands {

MeasuredPoints MeasurePointsAnew(
    LightField& light_field, const std::function<void(double share, const std::string& stage)>& progress) {
  tracking::TriangulationOptions options;
  options.progress = progress;
  tracking::TriangulationResult result =
      tracking::TriangulateViews(tracking::RefineInputOf(light_field), options);
  std::vector<ScenePoint> points = tracking::WithViewIds(std::move(result.points), light_field);
  const bool kept_points = points.empty() && !light_field.points.empty();
  if (!kept_points) light_field.points = std::move(points);
  return {true, kept_points, result.pose_error_px, result.unread.size()};
}

void WarnOfNoKnownPoints(const LightField& light_field) {
  if (!light_field.points.empty()) return;
  spdlog::warn(
      "{}: holds no points (a capture that was killed has none); leave --known-points out to measure them",
      light_field.root.string());
}

std::string PointDoubtsText(const MeasuredPoints& measured) {
  std::string text;
  if (measured.kept_points)
    text += "the photographs share nothing that can be measured: the points stay as they were\n";
  constexpr double kPoorPx = 2;  // guessed
  if (measured.pose_error_px > kPoorPx)
    text += fmt::format(
        "the poses fit the pictures only to {:.1f} px, which leaves few points: ulf refine improves them\n",
        measured.pose_error_px);
  if (measured.unread > 0)
    text += fmt::format("{} could not be read to measure points\n", Counted(measured.unread, "view"));
  return text;
}

}  // namespace ulf::commands
