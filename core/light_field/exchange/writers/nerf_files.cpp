#include "core/light_field/exchange/writers/set_writers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/base/json_text.h"
#include "core/base/quantile.h"
#include "core/geometry/camera_json.h"
#include "core/geometry/small_matrices.h"
#include "core/light_field/formats/transforms_json.h"

namespace ulf {
namespace {

// These are the distances of the published sets and their readers.
constexpr double kCameraDistance = 4, kNearest = 2, kFarthest = 6;

}  // namespace

nlohmann::json InstantNgpDocument(const LightField& exported) {
  LightField unmasked = exported;
  for (View& view : unmasked.views) view.mask_path.clear();
  nlohmann::json document = TransformsDocument(unmasked);
  const UnitCube cube = UnitCubeOf(exported);
  document["aabb_scale"] = cube.aabb_scale;
  document["scale"] = cube.scale;
  document["offset"] = Vector3ToJson(cube.offset);
  document["up"] = Vector3ToJson(exported.UpInWorld());
  document.erase("ply_file_path");  // training starts without points
  return document;
}

Similarity3 NerfFromWorld(const LightField& light_field, const Subject& subject) {
  Similarity3 nerf_from_world;
  const double distance = Median(DistancesTo(subject, light_field.views, &View::CenterInWorld));
  nerf_from_world.scale = distance > 0 ? kCameraDistance / distance : 1;
  nerf_from_world.rotation =
      TurnBetween(light_field.UpInWorld(), Eigen::Vector3d::UnitZ()).toRotationMatrix();
  nerf_from_world.translation = -nerf_from_world.scale * (nerf_from_world.rotation * subject.center_in_world);
  return nerf_from_world;
}

bool IsForTesting(std::size_t index) {
  constexpr std::size_t kEvery = 8;
  return index % kEvery == 0;
}

std::string NerfSyntheticText(const LightField& exported, const Similarity3& nerf_from_world, bool testing) {
  nlohmann::ordered_json document;
  const CameraModel& camera = exported.cameras.front();  // of all
  document["camera_angle_x"] = 2 * std::atan(0.5 * camera.width / camera.fx);
  nlohmann::ordered_json frames = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < exported.views.size(); ++i) {
    if (IsForTesting(i) != testing) continue;
    const View& view = exported.views[i];
    const Rigid3 world_from_cam = view.cam_from_world.Inverse();
    Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
    matrix.topLeftCorner<3, 3>() = nerf_from_world.rotation * world_from_cam.RotationMatrix();
    matrix.topRightCorner<3, 1>() = nerf_from_world * world_from_cam.translation;
    frames.push_back(
        {{"file_path", "./" + std::filesystem::path(view.image_path).replace_extension().generic_string()},
         {"transform_matrix", OpenGlRows(matrix)}});
  }
  document["frames"] = std::move(frames);
  return JsonText(document, 1) + "\n";
}

std::vector<std::string> NerfSyntheticDoubts(const LightField& light_field, const Subject& subject,
                                             bool has_masks) {
  std::vector<std::string> doubts;
  if (!has_masks)
    doubts.emplace_back(
        "no view has a mask: readers of this form take what is around the subject for a part of it, and look "
        "no deeper than 6 (the cameras stand about 4 from the subject); export nerfstudio or instant-ngp "
        "for a scene with its background");
  const std::vector<double> distances = DistancesTo(subject, light_field.views, &View::CenterInWorld);
  const double scale = NerfFromWorld(light_field, subject).scale;
  const auto cut_off = std::ranges::count_if(distances, [&](double distance) {
    return scale * (distance - subject.radius) < kNearest || scale * (distance + subject.radius) > kFarthest;
  });
  if (cut_off > 0)
    doubts.push_back(
        fmt::format("{} of {} views stand so near to the subject, or so far from it, that readers with the "
                    "usual near 2 and far 6 cut it off: raise their limits, or give a smaller {}",
                    cut_off, distances.size(), Parameter("subject")));
  return doubts;
}

}  // namespace ulf
