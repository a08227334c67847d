#include "core/light_field/exchange/nerf_synthetic_set.h"

#include <map>
#include <string>

#include "core/base/error.h"
#include "core/light_field/exchange/transforms_json.h"

namespace ulf {
namespace {

constexpr const char* kParts[] = {"train", "val", "test"};

std::filesystem::path FileOfPart(const std::filesystem::path& folder, const char* part) {
  return folder / (std::string("transforms_") + part + ".json");
}

bool IsSamePose(const Rigid3& a, const Rigid3& b) {
  constexpr double kRounding = 1e-6;
  return (a.Matrix() - b.Matrix()).cwiseAbs().maxCoeff() <= kRounding * (1 + a.translation.norm());
}

}  // namespace

bool IsNerfSynthetic(const std::filesystem::path& folder) {
  std::error_code unknown;
  return std::filesystem::exists(FileOfPart(folder, "train"), unknown);
}

PosedSet ReadNerfSyntheticSet(const std::filesystem::path& folder, const std::filesystem::path& images) {
  PosedSet set;
  set.format = "NeRF, synthetic";
  set.background = cv::Vec3d::all(1);
  LightField& all = set.light_field;
  all.root = images.empty() ? folder : images;
  std::map<std::string, Rigid3> taken;  // the pose of each photograph
  for (const char* part : kParts) {
    const std::filesystem::path file = FileOfPart(folder, part);
    if (!std::filesystem::exists(file)) continue;
    LightField light_field = ReadTransformsJson(file, images);
    for (View& view : light_field.views) {
      const auto [first, is_new] = taken.try_emplace(view.image_path, view.cam_from_world);
      if (!is_new && !IsSamePose(first->second, view.cam_from_world))
        throw Error(
            "{}: gives the photograph '{}' another pose than the part before; give the folder that holds "
            "train, val and test with --images",
            file.string(), view.image_path);
      if (!is_new) continue;  // in a set whose validation is its test
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
