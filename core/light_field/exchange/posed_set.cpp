#include "core/light_field/exchange/posed_set.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <climits>
#include <cmath>
#include <functional>
#include <opencv2/core.hpp>

#include "core/base/error.h"
#include "core/base/lowercase.h"
#include "core/base/name_order.h"
#include "core/geometry/small_matrices.h"
#include "core/image/image.h"
#include "core/image/image_header.h"
#include "core/image/raw_file.h"

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
  for (const auto& entry : fs::directory_iterator(folder, unknown))
    if (entry.is_directory(unknown) && !PhotographsIn(entry.path()).empty()) return true;
  return false;
}

// The path, else what is left of it without its first folders, as long as there is such a file; also with an ending,
// where it has none. Empty: there is none.
std::string FileInFolder(const fs::path& folder, const fs::path& path) {
  std::error_code unknown;
  const std::string whole = path.relative_path().generic_string();
  for (std::size_t first = 0; first < whole.size();) {
    const std::string part = whole.substr(first);
    const std::size_t slash = part.find('/');
    first = slash == std::string::npos ? whole.size() : first + slash + 1;
    if (part.size() > PATH_MAX || part.starts_with("../")) continue;
    for (const char* ending : {"", ".png", ".jpg", ".jpeg", ".exr"}) {
      if (*ending != '\0' && HasImageEnding(part)) break;
      if (fs::is_regular_file(folder / (part + ending), unknown)) return part + ending;
    }
  }
  return {};
}

}  // namespace

SetImages::SetImages(const fs::path& base, const fs::path& chosen, const std::vector<fs::path>& folders) {
  if (!chosen.empty()) {
    folder_ = chosen;
    names_ = PhotographsIn(chosen);
    if (names_.empty() && !HoldsPhotographsBelow(chosen))
      throw Error("--images {}: holds no photographs; give the folder in which they lie", chosen.string());
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
  throw Error("{}: no photographs in {}; say where they lie with --images FOLDER", base.string(), tried);
}

std::string SetImages::Find(const std::string& name) const {
  std::string slashed = name;
  std::ranges::replace(slashed, '\\', '/');  // on Windows
  for (const std::string& given : {name, slashed}) {
    const fs::path path = fs::path(given).lexically_normal();
    if (std::string found = FileInFolder(folder_, path); !found.empty()) return found;
    const std::string file = path.filename().string();
    const auto first_with = [&](const std::function<bool(const fs::path&)>& is_meant) {
      const auto found = std::ranges::find_if(names_, is_meant);
      return found == names_.end() ? std::string() : *found;
    };
    std::string found =
        first_with([&](const fs::path& other) { return Lowercase(other.string()) == Lowercase(file); });
    if (found.empty())
      found = first_with(
          [&](const fs::path& other) { return other.stem() == file || other.stem() == path.stem(); });
    if (!found.empty()) return found;
  }
  return {};
}

std::string SetImages::MaskOf(const std::string& name) const {
  const fs::path image(name);
  const fs::path stem = image.parent_path() / image.stem();
  std::error_code unknown;
  for (const char* const folder : {"../masks/", "masks/"})
    for (const std::string& mask :
         {name + ".png", stem.generic_string() + ".png", stem.generic_string() + "_mask.png"})
      if (fs::is_regular_file(folder_ / (folder + mask), unknown)) return folder + mask;
  for (const std::string& mask : {name + ".mask.png", stem.generic_string() + ".mask.png"})
    if (fs::is_regular_file(folder_ / mask, unknown)) return mask;
  return {};
}

CameraModel AtSizeOf(const fs::path& image, const CameraModel& camera, const std::string& where,
                     std::vector<std::string>& doubts) {
  // A raw file shows some pixels more than the JPEG that was posed, and is cropped.
  if (IsRawFile(image) && CanCropRaw(ReadRawFacts(image.string()), {camera.width, camera.height}))
    return camera;
  const cv::Size size = ReadImageSize(image.string());
  if (size.width == camera.width && size.height == camera.height) return camera;
  const double ratio = static_cast<double>(size.width) / camera.width;
  constexpr double kRounding_px = 1;
  if (std::abs(ratio * camera.height - size.height) > kRounding_px)
    throw Error(
        "{}: {} is {}x{}, its camera says {}x{}: it was cropped or turned, and its intrinsics no longer "
        "hold; "
        "take the photographs that were measured",
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
