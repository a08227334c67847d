#include "core/light_field/exchange/readers/set_readers.h"

#include <string>
#include <vector>

#include "core/light_field/formats/transforms_json.h"

namespace ulf {
namespace {

constexpr const char* kParts[] = {"train", "val", "test"};

std::filesystem::path FileOfPart(const std::filesystem::path& folder, const char* part) {
  return folder / (std::string("transforms_") + part + ".json");
}

}  // namespace

PosedSet ReadNerfSyntheticSet(const std::filesystem::path& folder, const std::filesystem::path& images) {
  PosedSet set;
  set.format = "NeRF, synthetic";
  set.background = cv::Vec3d::all(1);
  LightField& all = set.light_field;
  all.root = images.empty() ? folder : images;
  std::vector<std::filesystem::path> files;
  for (const char* part : kParts)
    if (const auto file = FileOfPart(folder, part); std::filesystem::exists(file)) files.push_back(file);
  for (const std::filesystem::path& file : files) {
    // Programs that write no pictures for testing still write the poses (BlenderNeRF).
    const bool may_be_poses_alone = file != FileOfPart(folder, kParts[0]);
    LightField light_field = ReadTransformsSet(file, images, may_be_poses_alone, files);
    for (View& view : light_field.views) {
      view.id = static_cast<int>(all.views.size()) + 1;
      view.camera = IndexOfCamera(light_field.CameraOf(view), all.cameras);
      all.views.push_back(std::move(view));
    }
    if (all.points.empty()) all.points = std::move(light_field.points);
    all.doubts.insert(all.doubts.end(), light_field.doubts.begin(), light_field.doubts.end());
  }
  return set;
}

}  // namespace ulf
