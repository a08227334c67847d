#include "commands/light_field/measured_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "core/base/counted.h"
#include "core/base/shell_word.h"
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
  const std::size_t found = points.size();
  if (!kept_points) light_field.points = std::move(points);
  return {true, found, kept_points, result.pose_error_px, result.unread.size()};
}

std::string NoPointsInWords(const LightField& exported, const MeasuredPoints& measured, bool for_colmap) {
  constexpr int kSmall_px = 320;  // the longer side, below which few corners are found; guessed
  const std::string begin =
      "no points: trainers of Gaussians begin with a set's points, and without any they stop or begin at "
      "random; ";
  if (!measured.done) return begin + "leave --known-points out to measure them";
  if (measured.points > 0)
    return begin + "all that were measured lie where masks exclude them, or beyond the exported pictures";
  const CameraModel& camera = exported.cameras.front();
  return fmt::format(
      "{}the photographs ({}x{}) share nothing that can be measured under these poses: {}'ulf info {} "
      "--check-poses' says whether the poses are right{}",
      begin, camera.width, camera.height,
      std::max(camera.width, camera.height) < kSmall_px ? "larger photographs show more, and " : "",
      ShellWord(exported.root.string()),
      for_colmap ? "; COLMAP's commands below measure points of their own" : "");
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
