#include "core/light_field/formats/posed_set.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <climits>
#include <functional>
#include <opencv2/core.hpp>

#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/lowercase.h"
#include "core/base/name_order.h"
#include "core/geometry/small_matrices.h"
#include "core/image/files/picture_file.h"
#include "core/image/files/picture_kind.h"
#include "core/image/files/raw_file.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> PhotographsIn(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code unknown;
  for (const auto& entry : fs::directory_iterator(folder, unknown)) {
    const std::string name = entry.path().filename().string();
    if (HasImageEnding(name) && !name.starts_with('.') && entry.is_regular_file(unknown))
      names.push_back(name);
  }
  LeaveOutRawTwins(names);
  std::ranges::sort(names, NameOrder);
  return names;
}

bool HoldsPhotographsBelow(const fs::path& folder) {
  std::error_code unknown;
  constexpr auto kSkip = fs::directory_options::skip_permission_denied;
  for (auto entry = fs::recursive_directory_iterator(folder, kSkip, unknown);
       !unknown && entry != fs::recursive_directory_iterator(); entry.increment(unknown))
    if (HasImageEnding(entry->path()) && entry->is_regular_file(unknown)) return true;
  return false;
}

// Returns the path, and its ends without its first folders: a/b/c, b/c, c.
std::vector<fs::path> EndsOf(const fs::path& path) {
  std::vector<fs::path> ends;
  const std::string whole = path.relative_path().generic_string();
  for (std::size_t first = 0; first < whole.size();) {
    std::string end = whole.substr(first);
    const std::size_t slash = end.find('/');
    first = slash == std::string::npos ? whole.size() : first + slash + 1;
    if (end.size() <= PATH_MAX && !end.starts_with("../")) ends.emplace_back(std::move(end));
  }
  return ends;
}

// Returns the name without the ending of an image: 'r_0.5' has none.
std::string StemOf(const fs::path& photograph) {
  return HasImageEnding(photograph) ? photograph.stem().string() : photograph.filename().string();
}

}  // namespace

std::string ImagesRemedy() { return fmt::format("say where they lie with {} FOLDER", Parameter("images")); }

SetImages::SetImages(const fs::path& base, const fs::path& chosen, const std::vector<fs::path>& folders) {
  if (!chosen.empty()) {
    folder_ = chosen;
    names_ = PhotographsIn(chosen);
    if (names_.empty() && !HoldsPhotographsBelow(chosen))
      throw Error("{} {}: holds no photographs; give the folder in which they lie", Parameter("images"),
                  chosen.string());
    return;
  }
  std::string tried;
  for (const fs::path& folder : folders) {
    folder_ = (base / folder).lexically_normal();
    names_ = PhotographsIn(folder_);
    if (!names_.empty()) return;
    tried += (tried.empty() ? "" : ", ") + folder_.string();
  }
  for (const fs::path& folder : folders) {
    folder_ = (base / folder).lexically_normal();
    if (HoldsPhotographsBelow(folder_)) return;
  }
  throw Error("{}: no photographs in {}; {}", base.string(), tried, ImagesRemedy());
}

const std::vector<std::string>& SetImages::NamesBelow(const fs::path& folder) const {
  if (folder.empty()) return names_;
  const auto [found, is_new] = names_below_.try_emplace(folder);
  if (is_new) found->second = PhotographsIn(folder_ / folder);
  return found->second;
}

std::string SetImages::Find(const std::string& name) const {
  std::string slashed = name;
  std::ranges::replace(slashed, '\\', '/');  // from Windows
  using IsMeant = std::function<bool(const std::string& there, const std::string& wanted)>;
  const IsMeant ways[] = {
      [](const std::string& there, const std::string& wanted) { return there == wanted; },
      [](const std::string& there, const std::string& wanted) {
        return !HasImageEnding(wanted) && StemOf(there) == wanted;
      },
      [](const std::string& there, const std::string& wanted) {
        return Lowercase(there) == Lowercase(wanted);
      },
      [](const std::string& there, const std::string& wanted) { return StemOf(there) == StemOf(wanted); }};
  for (const std::string& given : slashed == name ? std::vector{name} : std::vector{name, slashed}) {
    const std::vector<fs::path> ends = EndsOf(fs::path(given).lexically_normal());
    // Most names match as they are: no folder needs to be read for these.
    std::error_code unknown;
    for (const fs::path& end : ends)
      if (fs::is_regular_file(folder_ / end, unknown)) return end.generic_string();
    for (const IsMeant& is_meant : ways)
      for (const fs::path& end : ends) {
        const std::vector<std::string>& there = NamesBelow(end.parent_path());
        const std::string wanted = end.filename().string();
        const auto found =
            std::ranges::find_if(there, [&](const std::string& one) { return is_meant(one, wanted); });
        if (found != there.end()) return (end.parent_path() / *found).generic_string();
      }
  }
  return {};
}

std::string SetImages::MaskOf(const std::string& name) const {
  const fs::path image(name);
  const fs::path stem = image.parent_path() / image.stem();
  std::error_code unknown;
  // Beside images_4 nerfstudio has masks_4.
  const std::string of_images = folder_.filename().string();
  const std::string reduced =
      of_images.starts_with("images_") ? "../masks" + of_images.substr(6) + "/" : "../masks/";
  for (const std::string& folder : {reduced, std::string("../masks/"), std::string("masks/")})
    for (const std::string& mask :
         {name + ".png", stem.generic_string() + ".png", stem.generic_string() + "_mask.png"})
      if (fs::is_regular_file(folder_ / (folder + mask), unknown)) return folder + mask;
  for (const std::string& mask : {name + ".mask.png", stem.generic_string() + ".mask.png"})
    if (fs::is_regular_file(folder_ / mask, unknown)) return mask;
  return {};
}

CameraModel AtSizeOf(const fs::path& image, const CameraModel& camera, const std::string& where,
                     std::vector<std::string>& doubts) {
  // A raw file has some pixels more than the JPEG that was posed, and is cropped.
  if (IsRawFile(image) && CanCropRaw(ReadRawFacts(image.string()), {camera.width, camera.height}))
    return camera;
  const cv::Size size = ReadImageSize(image.string());
  if (size == SizeOf(camera)) return camera;
  if (!HasAspectOf(camera, size))
    throw Error(
        "{}: {} is {}x{}, its camera says {}x{}: it was cropped or turned, and its intrinsics no longer "
        "hold; take the photographs that were measured",
        where, image.string(), size.width, size.height, camera.width, camera.height);
  const std::string words = fmt::format(
      "photographs of {}x{} for a camera of {}x{}: they are taken to be resized, not cropped, and the "
      "intrinsics are scaled",
      size.width, size.height, camera.width, camera.height);
  if (std::ranges::find(doubts, words) == doubts.end()) doubts.push_back(words);
  return camera.ScaledTo(size.width, size.height);
}

int IndexOfCamera(const CameraModel& camera, std::vector<CameraModel>& cameras) {
  const auto found = std::ranges::find(cameras, camera);
  if (found != cameras.end()) return static_cast<int>(found - cameras.begin());
  cameras.push_back(camera);
  return static_cast<int>(cameras.size()) - 1;
}

View& AddView(const std::string& image_path, const CameraModel& camera, const Rigid3& cam_from_world,
              const SetImages& images, LightField& light_field) {
  View& view = light_field.views.emplace_back();
  view.id = static_cast<int>(light_field.views.size());
  view.image_path = image_path;
  view.mask_path = images.MaskOf(image_path);
  view.camera = IndexOfCamera(camera, light_field.cameras);
  view.cam_from_world = cam_from_world;
  return view;
}

void NoteUnposed(std::size_t count, const char* noun, const std::string& why, PosedSet& set) {
  if (count == 0) return;
  set.light_field.doubts.push_back(fmt::format("{} left out: {}", Counted(count, noun), why));
  set.counts_unposed = true;
}

Eigen::Quaterniond NearestRotation(const Eigen::Matrix3d& matrix, const std::string& where,
                                   const std::string& what) {
  constexpr double kTolerance = 1e-3;
  const double error = (matrix.transpose() * matrix - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!matrix.allFinite() || error > kTolerance || matrix.determinant() < 0)
    throw Error(
        "{}: {} is not a rotation (orthonormal, determinant 1); export the set again without scale or "
        "mirroring",
        where, what);
  const SingularValues3 svd = SingularValuesOf(matrix);
  return Eigen::Quaterniond(Eigen::Matrix3d(svd.u * svd.v.transpose())).normalized();
}

}  // namespace ulf
