#include "commands/light_field/export_shutter.h"

#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "commands/options/command_line.h"
#include "core/base/counted.h"
#include "render/proxy/mesh_file.h"
#include "render/proxy/photograph_depth.h"

namespace ulf::commands {
namespace {

// Returns where the middle of the exported picture's upper or lower edge is in the photograph, px from its
// top.
double RowOfEdge(const CameraModel& from, const CameraModel& exported, double row) {
  const auto ray = exported.RayFromImg({0.5 * exported.width, row});
  const auto img = ray ? from.ImgFromCam(*ray) : std::nullopt;
  return img ? img->y() : row;
}

EdgePosesOf EdgePosesFrom(const LightField& light_field, const ExportedShutter& shutter) {
  return [&light_field, &shutter](const View& view, const CameraModel& exported) -> std::optional<EdgePoses> {
    const auto found = shutter.rows.find(view.id);
    if (found == shutter.rows.end()) return std::nullopt;
    const CameraModel& from = light_field.CameraOf(view);
    return EdgePoses{found->second.PoseAt(from, RowOfEdge(from, exported, 0)),
                     found->second.PoseAt(from, RowOfEdge(from, exported, exported.height))};
  };
}

// The depths are the mesh's, where there is one.
Resampling ToOneInstant(const LightField& light_field, const ExportedShutter& shutter) {
  std::shared_ptr<const render::PhotographDepths> geometry;
  if (std::filesystem::exists(light_field.root / render::kMeshProxyFile))
    geometry = std::make_shared<render::PhotographDepths>(light_field);
  Resampling resampling;
  for (const auto& [id, rows] : shutter.rows) resampling.views.insert(id);
  resampling.map_of = [&light_field, &shutter, geometry](const View& view, const CameraModel& exported) {
    const cv::Mat depth = geometry ? geometry->Of(view, exported).depth
                                   : cv::Mat(cv::Mat::zeros(exported.height, exported.width, CV_32F));
    return tracking::InstantMap(shutter.rows.at(view.id), light_field.CameraOf(view), exported, depth);
  };
  return resampling;
}

std::string ShutterInWords(const LightField& light_field, std::size_t moving, double readout_ms,
                           bool is_global, ExportForm form) {
  const std::size_t views = light_field.views.size();
  std::string words =
      fmt::format("rolling shutter of {:.1f} ms: {} of {} ", readout_ms, moving, Counted(views, "view"));
  if (is_global)
    return words + "drawn as of one instant" +
           (moving < views ? ", the others as they are, whose velocity or points are missing" : "");
  const bool has_poses = form == ExportForm::kNerfstudio || form == ExportForm::kInstantNgp;
  return words + (has_poses ? "have the poses of their upper and lower edges (transform_matrix_start, _end)"
                            : "are bent; --global-shutter draws them as of one instant");
}

}  // namespace

ExportedShutter ShutterOf(const LightField& light_field, bool is_global, ExportForm form) {
  const double readout_ms = light_field.readout ? 1e3 * light_field.readout->readout_s : 0;
  if (is_global && !light_field.readout)
    throw UsageError(
        "--global-shutter: {} does not say how long its camera reads a picture; a capture measures it, and "
        "ulf capture --readout-ms gives it",
        light_field.root.string());
  ExportedShutter shutter{tracking::RowsOfViews(light_field), {}, {}};
  if (readout_ms == 0) {
    if (is_global) shutter.words = "the light field's shutter is global: nothing is to be undone";
    return shutter;
  }
  if (is_global && shutter.rows.empty())
    throw UsageError(
        "--global-shutter: no view of {} has both its camera's velocity and points; a capture that "
        "compensates "
        "its rolling shutter records them",
        light_field.root.string());
  if (!shutter.rows.empty())
    shutter.words = ShutterInWords(light_field, shutter.rows.size(), readout_ms, is_global, form);
  return shutter;
}

void SetShutter(const LightField& light_field, bool is_global, ExportedShutter& shutter,
                ExportOptions& options) {
  if (shutter.rows.empty()) return;
  if (!is_global) {
    options.edge_poses = EdgePosesFrom(light_field, shutter);
    return;
  }
  options.resampling = ToOneInstant(light_field, shutter);
  shutter.at_one_instant = tracking::AtOneInstant(light_field, shutter.rows);
}

}  // namespace ulf::commands
