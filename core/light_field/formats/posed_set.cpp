#include "core/light_field/formats/posed_set.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <Eigen/LU>
#include <algorithm>
#include <climits>
#include <cmath>
#include <exception>
#include <limits>
#include <numbers>
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

// Returns the paths of all photographs below a folder, relative to it, by their names without ending in lower
// case.
std::multimap<std::string, std::string> PhotographsBelow(const fs::path& folder) {
  constexpr std::size_t kMost = 200000;  // entries looked at: a set may lie in somebody's whole disk
  std::vector<std::string> paths;
  std::error_code unknown;
  std::size_t entries = 0;
  constexpr auto kSkip = fs::directory_options::skip_permission_denied;
  for (auto entry = fs::recursive_directory_iterator(folder, kSkip, unknown);
       !unknown && entry != fs::recursive_directory_iterator() && ++entries < kMost;
       entry.increment(unknown)) {
    if (entry->path().filename().string().starts_with('.')) {
      entry.disable_recursion_pending();
      continue;
    }
    if (HasImageEnding(entry->path()) && entry->is_regular_file(unknown))
      paths.push_back(entry->path().lexically_relative(folder).generic_string());
  }
  LeaveOutRawTwins(paths);
  std::ranges::sort(paths, NameOrder);
  std::multimap<std::string, std::string> by_name;
  for (std::string& path : paths) by_name.emplace(Lowercase(StemOf(fs::path(path).filename())), path);
  return by_name;
}

// Returns how many folders the two paths have in common, from their end, in upper or lower case.
int CommonEnd(const std::string& one, const std::string& other) {
  const fs::path a = fs::path(Lowercase(one)).parent_path(), b = fs::path(Lowercase(other)).parent_path();
  auto i = a.end(), k = b.end();
  int common = 0;
  while (i != a.begin() && k != b.begin() && *--i == *--k) ++common;
  return common;
}

// Matches what lies beside a set's photographs under their names: smaller copies, masks and maps.
bool IsReducedCopy(const fs::path& photograph) {
  return std::ranges::any_of(photograph.parent_path(), [](const fs::path& folder) {
    const std::string name = Lowercase(folder.string());
    return name.starts_with("images_") || name.starts_with("mask") || name.starts_with("depth") ||
           name.starts_with("normal") || name.starts_with("thumb");
  });
}

std::string Slashed(std::string name) {
  std::ranges::replace(name, '\\', '/');  // from Windows
  return name;
}

using IsMeant = bool (*)(const std::string& there, const std::string& wanted);
constexpr IsMeant kWaysToMean[] = {
    [](const std::string& there, const std::string& wanted) { return there == wanted; },
    [](const std::string& there, const std::string& wanted) {
      return !HasImageEnding(wanted) && StemOf(there) == wanted;
    },
    [](const std::string& there, const std::string& wanted) { return Lowercase(there) == Lowercase(wanted); },
    [](const std::string& there, const std::string& wanted) {
      return Lowercase(StemOf(there)) == Lowercase(StemOf(wanted));
    }};

}  // namespace

std::string ImagesRemedy() { return fmt::format("say where they lie with {} FOLDER", Parameter("images")); }

SetImages::SetImages(const fs::path& base, const fs::path& chosen, const std::vector<fs::path>& folders) {
  if (!chosen.empty()) {
    folder_ = chosen;
    if (chosen == kNoPhotographs) return;
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

SetImages::SetImages(const fs::path& folder) : folder_(folder), names_(PhotographsIn(folder)) {}

const std::vector<std::string>& SetImages::NamesBelow(const fs::path& folder) const {
  if (folder.empty()) return names_;
  const auto [found, is_new] = names_below_.try_emplace(folder);
  if (is_new) found->second = PhotographsIn(folder_ / folder);
  return found->second;
}

void SetImages::Reserve(const std::vector<std::string>& names) {
  struct Fit {
    int folders = -1;  // that path and name have in common
    std::set<std::string> names;
  };
  std::map<std::string, Fit> fits;
  reserved_.clear();
  for (const std::string& name : names) {
    const std::string path = FindByEnd(name);
    if (path.empty()) continue;
    const int folders = CommonEnd(path, Slashed(name));
    Fit& fit = fits[path];
    if (folders > fit.folders) fit = {folders, {}};
    if (folders == fit.folders) fit.names.insert(name);
  }
  for (const auto& [path, fit] : fits) reserved_[path] = fit.names;
}

bool SetImages::IsReservedForAnother(const std::string& path, const std::string& name) const {
  const auto found = reserved_.find(path);
  return found != reserved_.end() && !found->second.contains(name);
}

std::string SetImages::Find(const std::string& name) const {
  if (folder_ == kNoPhotographs) return fs::path(Slashed(name)).relative_path().generic_string();
  std::string found = FindByEnd(name);
  return found.empty() ? FindBelow(name) : found;
}

bool IsInAnotherFolder(const std::string& path, const std::string& name) {
  const std::string slashed = Slashed(name);
  return fs::path(path).has_parent_path() && fs::path(slashed).has_parent_path() &&
         CommonEnd(path, slashed) == 0;
}

std::string SetImages::FindBelow(const std::string& name) const {
  if (!all_below_) all_below_ = PhotographsBelow(folder_);
  const std::string path = Slashed(name), wanted = fs::path(path).filename().string();
  const auto [begin, end] = all_below_->equal_range(Lowercase(StemOf(wanted)));
  for (const IsMeant& is_meant : kWaysToMean) {
    std::string best, other;
    int most = std::numeric_limits<int>::min();
    for (auto each = begin; each != end; ++each) {
      const std::string& there = each->second;
      if (!is_meant(fs::path(there).filename().string(), wanted) || IsReservedForAnother(there, name))
        continue;
      const int alike = 2 * CommonEnd(there, path) - (IsReducedCopy(there) ? 1 : 0);
      if (alike == most) other = there;
      if (alike > most) most = alike, best = there, other.clear();
    }
    if (!other.empty())
      throw Error("{}: both {} and {} may be the photograph '{}'; {}", folder_.string(), best, other, name,
                  ImagesRemedy());
    if (!best.empty()) return best;
  }
  return {};
}

std::string SetImages::FindByEnd(const std::string& name) const {
  const std::string slashed = Slashed(name);
  for (const std::string& given : slashed == name ? std::vector{name} : std::vector{name, slashed}) {
    const std::vector<fs::path> ends = EndsOf(fs::path(given).lexically_normal());
    // Most names match as they are: no folder needs to be read for these.
    std::error_code unknown;
    for (const fs::path& end : ends)
      if (fs::is_regular_file(folder_ / end, unknown) && !IsReservedForAnother(end.generic_string(), name))
        return end.generic_string();
    for (const IsMeant& is_meant : kWaysToMean)
      for (const fs::path& end : ends) {
        const std::vector<std::string>& there = NamesBelow(end.parent_path());
        const std::string wanted = end.filename().string();
        const auto found = std::ranges::find_if(there, [&](const std::string& one) {
          return is_meant(one, wanted) &&
                 !IsReservedForAnother((end.parent_path() / one).generic_string(), name);
        });
        if (found != there.end()) return (end.parent_path() / *found).generic_string();
      }
  }
  return {};
}

std::string SetImages::FileOfAnyCase(const fs::path& file) const {
  std::error_code unknown;
  if (fs::is_regular_file(folder_ / file, unknown)) return file.generic_string();
  const auto [there, is_new] = files_there_.try_emplace(file.parent_path());
  if (is_new)
    for (const auto& entry : fs::directory_iterator(folder_ / file.parent_path(), unknown))
      if (entry.is_regular_file(unknown))
        there->second.emplace(Lowercase(entry.path().filename().string()), entry.path().filename());
  const auto found = there->second.find(Lowercase(file.filename().string()));
  return found == there->second.end() ? "" : (file.parent_path() / found->second).generic_string();
}

std::string SetImages::MaskOf(const std::string& name) const {
  const fs::path image(name);
  const fs::path stem = image.parent_path() / image.stem();
  // Beside images_4 nerfstudio has masks_4.
  const std::string of_images = folder_.filename().string();
  const std::string reduced =
      of_images.starts_with("images_") ? "../masks" + of_images.substr(6) + "/" : "../masks/";
  for (const std::string& folder : {reduced, std::string("../masks/"), std::string("masks/")})
    for (const std::string& mask :
         {name + ".png", stem.generic_string() + ".png", stem.generic_string() + "_mask.png"})
      if (std::string found = FileOfAnyCase(folder + mask); !found.empty()) return found;
  for (const std::string& mask : {name + ".mask.png", stem.generic_string() + ".mask.png"})
    if (std::string found = FileOfAnyCase(mask); !found.empty()) return found;
  return {};
}

std::string DynamicMaskOf(const fs::path& root, const std::string& image_path) {
  const fs::path image(image_path);
  std::error_code unknown;
  for (const char* ending : {".png", ".PNG"})
    if (const fs::path mask = image.parent_path() / ("dynamic_mask_" + image.stem().string() + ending);
        fs::is_regular_file(root / mask, unknown))
      return mask.generic_string();
  return {};
}

CameraModel AtSizeOf(const fs::path& image, const CameraModel& camera, const std::string& where,
                     std::vector<std::string>& doubts) {
  if (image.string().starts_with(kNoPhotographs.string())) return camera;
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
  if (view.mask_path.empty()) {
    view.mask_path = DynamicMaskOf(images.folder(), image_path);
    view.mask_marks_unused = !view.mask_path.empty();
  }
  view.camera = IndexOfCamera(camera, light_field.cameras);
  view.cam_from_world = cam_from_world;
  return view;
}

void NoteUnposed(std::size_t count, const char* noun, const std::string& why, PosedSet& set) {
  if (count == 0) return;
  set.light_field.doubts.push_back(fmt::format("{} left out: {}", Counted(count, noun), why));
  set.counts_unposed = true;
}

Eigen::Quaterniond PoseRotations::Read(const Eigen::Matrix3d& matrix, const std::string& where,
                                       const std::string& what) {
  // Two decimals are off by 0.005, and nine such numbers by at most 0.015 together.
  constexpr double kMostChange = 0.02;
  constexpr double kVisible = 1e-4;  // between what three and four decimals change
  const auto refuse = [&](const char* fault) {
    throw Error("{}: {} is not a rotation (orthonormal, determinant 1): {}; export the set again", where,
                what, fault);
  };
  if (!matrix.allFinite()) refuse("a number is not finite");
  const SingularValues3 svd = SingularValuesOf(matrix);
  scale_ = svd.values.mean();
  if (!(scale_ > 0)) refuse("it is zero");
  if (matrix.determinant() < 0) refuse("it is mirrored, as if an axis were negated or two were exchanged");
  const Eigen::Matrix3d rotation = svd.u * svd.v.transpose();
  const Eigen::Matrix3d change = matrix / scale_ - rotation;
  if ((svd.values.array() / scale_ - 1).abs().maxCoeff() > kMostChange)
    refuse("its axes differ in length or are not at right angles");
  const double turn = change.colwise().norm().maxCoeff();
  if (turn > kVisible || std::abs(scale_ - 1) > kVisible) {
    least_scale_ = changed_ == 0 ? scale_ : std::min(least_scale_, scale_);
    most_scale_ = changed_ == 0 ? scale_ : std::max(most_scale_, scale_);
    most_turn_ = std::max(most_turn_, turn);
    ++changed_;
  }
  return Eigen::Quaterniond(rotation).normalized();
}

void PoseRotations::Tell(const std::string& file, std::vector<std::string>& doubts) const {
  if (changed_ == 0) return;
  constexpr double kSame = 1e-4;
  std::vector<std::string> changes;
  if (most_scale_ - least_scale_ > kSame * most_scale_)
    changes.push_back(fmt::format("scales from {:.4g} to {:.4g} were taken out", least_scale_, most_scale_));
  else if (std::abs(most_scale_ - 1) > kSame)
    changes.push_back(fmt::format("a scale of {:.4g} was taken out", most_scale_));
  if (most_turn_ > kSame)
    changes.push_back(
        fmt::format("axes turned by up to {:.2g} degrees", most_turn_ * 180 / std::numbers::pi));
  doubts.push_back(fmt::format("{}: the matrices of {} were not rotations and were made such: {}", file,
                               Counted(changed_, "pose"), fmt::join(changes, ", ")));
}

Eigen::Quaterniond NearestRotation(const Eigen::Matrix3d& matrix, const std::string& where,
                                   const std::string& what) {
  constexpr double kMostScale = 1e-3;
  PoseRotations rotations;
  Eigen::Quaterniond rotation = rotations.Read(matrix, where, what);
  if (std::abs(rotations.scale() - 1) > kMostScale)
    throw Error("{}: {} is not a rotation but scaled by {:.4g}; export the set again", where, what,
                rotations.scale());
  return rotation;
}

ToldOnFailure::ToldOnFailure(const std::vector<std::string>& doubts)
    : doubts_(doubts), exceptions_(std::uncaught_exceptions()) {}

ToldOnFailure::~ToldOnFailure() {
  if (std::uncaught_exceptions() == exceptions_) return;
  for (const std::string& doubt : doubts_) spdlog::warn("{}", doubt);
}

void RequireLastRow(const Eigen::RowVector4d& row, const std::string& where, const std::string& what) {
  constexpr double kSinglePrecision = 1e-5;  // of an inverse with a translation of a hundred units. Guessed
  if (!((row - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff() < kSinglePrecision))
    throw Error("{}: the last row of {} must be 0 0 0 1", where, what);
}

}  // namespace ulf
