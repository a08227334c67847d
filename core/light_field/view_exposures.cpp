#include "core/light_field/view_exposures.h"

#include <fmt/format.h>

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

}  // namespace ulf
