#include "core/light_field/view_exposures.h"

#include <fmt/format.h>

#include "core/geometry/camera_json.h"
#include "core/light_field/formats/view_json.h"

namespace ulf {

std::string ExposureName(int view_id, std::size_t number) {
  return fmt::format("{}/{:06}-{}", kExposuresFolder, view_id, number);
}

std::string MergedPath(int view_id) { return fmt::format("{}/{:06}.exr", kMergedFolder, view_id); }

std::set<std::string> FilesOf(const View& view) {
  std::set<std::string> files{view.image_path, view.master_path};
  for (const ViewExposure& exposure : view.exposures)
    files.insert({exposure.image_path, exposure.master_path});
  if (view.merged) files.insert(view.merged->path);
  files.erase("");
  return files;
}

View PhotographOf(const View& view, const ViewExposure& exposure) {
  View photograph = view;
  photograph.image_path = exposure.image_path;
  photograph.master_path = exposure.master_path;
  photograph.master_transfer = exposure.master_transfer;
  photograph.master_mosaic = exposure.master_mosaic;
  photograph.raw_white_balance = exposure.raw_white_balance;
  photograph.device_time_s = exposure.device_time_s;
  photograph.host_time_s = exposure.host_time_s;
  photograph.exposure_s = exposure.exposure_s;
  photograph.gain = exposure.gain;
  photograph.black_level = exposure.black_level;
  photograph.f_number = exposure.f_number;
  photograph.cam_from_world = exposure.exposure_from_view * view.cam_from_world;
  photograph.exposures.clear();
  photograph.merged.reset();
  return photograph;
}

nlohmann::json ExposureToJson(const ViewExposure& exposure) {
  nlohmann::json keys = PhotographToJson(PhotographOf({}, exposure));
  if (!exposure.image_path.empty()) keys["image"] = exposure.image_path;
  keys["exposure_from_view"] = PoseToJson(exposure.exposure_from_view);
  keys["pose"] = exposure.pose_is_between ? "between" : "found";
  return keys;
}

ViewExposure ExposureFromJson(const JsonPlace& place) {
  View photograph;
  ReadPhotographJson(place, photograph);
  ViewExposure exposure{.image_path = place.Text("image", ""),
                        .master_path = photograph.master_path,
                        .master_transfer = photograph.master_transfer,
                        .master_mosaic = photograph.master_mosaic,
                        .raw_white_balance = photograph.raw_white_balance,
                        .exposure_from_view = PoseFromJson(place, "exposure_from_view"),
                        .pose_is_between = place.Text("pose", "found") == "between",
                        .device_time_s = photograph.device_time_s,
                        .host_time_s = photograph.host_time_s,
                        .exposure_s = photograph.exposure_s,
                        .gain = photograph.gain,
                        .black_level = photograph.black_level,
                        .f_number = photograph.f_number};
  if (exposure.image_path.empty() && exposure.master_path.empty())
    throw Error("{}: an exposure needs 'image' or 'master'", place.where);
  if (!(exposure.exposure_s > 0))
    throw Error("{}: an exposure needs 'exposure_s' above 0, not {}", place.where, exposure.exposure_s);
  return exposure;
}

nlohmann::json MergedToJson(const MergedExposures& merged) {
  return {{"image", merged.path}, {"exposures", merged.exposures}, {"ghosts", merged.ghost_share}};
}

MergedExposures MergedFromJson(const JsonPlace& place) {
  MergedExposures merged{place.Text("image"), place.Integer("exposures"), place.Number("ghosts")};
  if (merged.exposures < 2 || !(merged.ghost_share >= 0 && merged.ghost_share <= 1))
    throw Error("{}: {} merged exposures with a share of {} of ghosts are not possible", place.where,
                merged.exposures, merged.ghost_share);
  return merged;
}

}  // namespace ulf
