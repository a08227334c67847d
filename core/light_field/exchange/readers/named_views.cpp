#include "core/light_field/exchange/readers/named_views.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/counted.h"
#include "core/base/error.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

fs::path SharedFolder(const fs::path& a, const fs::path& b) {
  fs::path shared;
  for (auto i = a.begin(), j = b.begin(); i != a.end() && j != b.end() && *i == *j; ++i, ++j) shared /= *i;
  return shared;
}

}  // namespace

std::vector<fs::path> FoldersOfNames(const fs::path& base, const std::vector<std::string>& names) {
  std::optional<fs::path> shared;
  std::error_code unknown;
  for (std::string name : names) {
    std::ranges::replace(name, '\\', '/');
    const fs::path file = (base / name).lexically_normal();
    if (!fs::is_regular_file(file, unknown)) continue;
    shared = shared ? SharedFolder(*shared, file.parent_path()) : file.parent_path();
  }
  std::vector<fs::path> folders;
  if (shared) folders.push_back(*shared);
  folders.insert(folders.end(),
                 {"images", "photos", "input", ".", "../images", "../../images", "../../../images"});
  return folders;
}

void NotePointsNowhere(std::size_t count, LightField& light_field) {
  if (count > 0)
    light_field.doubts.push_back(
        fmt::format("{} whose position is not finite: left out", Counted(count, "point")));
}

NamedViews::NamedViews(const fs::path& file, const SetImages& images, PosedSet& set)
    : file_(file.string()), images_(images), set_(set) {
  set_.light_field.root = images.folder();
}

std::string NamedViews::Find(const std::string& name, const std::string& where) {
  const std::string path = name.empty() ? name : images_.Find(name);
  if (path.empty()) {
    if (missing_++ == 0) first_missing_ = name;
    return path;
  }
  const auto [other, is_new] = names_.try_emplace(path, name);
  if (!is_new && other->second != name)
    throw Error("{}: '{}' and '{}' both lead to {}; give the folder from which the names count with {}",
                where, other->second, name, (images_.folder() / path).string(), Parameter("images"));
  return path;
}

int NamedViews::Add(const std::string& path, const CameraModel& camera, const Rigid3& cam_from_world,
                    const std::string& where) {
  if (!cam_from_world.translation.allFinite() || !cam_from_world.rotation.coeffs().allFinite())
    throw Error("{}: its pose is not finite; export the set again", where);
  camera.Validate(where);
  LightField& light_field = set_.light_field;
  const CameraModel own = AtSizeOf(images_.folder() / path, camera, where, light_field.doubts);
  return AddView(path, own, cam_from_world, images_, light_field).id;
}

void NamedViews::RequireFound() {
  const std::size_t found = set_.light_field.views.size();
  if (missing_ == 0) return;
  if (missing_ > found)
    throw Error("{}: {} of its {} are not in {} ('{}' is the first); {}", file_, missing_,
                Counted(missing_ + found, "photograph"), images_.folder().string(), first_missing_,
                ImagesRemedy());
  set_.light_field.doubts.push_back(fmt::format("{} left out: no photograph in {}: {}{}",
                                                Counted(missing_, "view"), images_.folder().string(),
                                                first_missing_, missing_ > 1 ? ", ..." : ""));
}

void RequireMeasuredSize(const CameraModel& camera, const std::string& where) {
  constexpr double kMostOff = 0.25;  // of the side; no lens has its axis there. Guessed
  if (std::abs(camera.cx - 0.5 * camera.width) > kMostOff * camera.width ||
      std::abs(camera.cy - 0.5 * camera.height) > kMostOff * camera.height)
    throw Error(
        "{}: the principal point ({:.6g}, {:.6g}) is far from the middle of a photograph of {}x{}: it was "
        "resized "
        "or cropped; take the photographs that were measured",
        where, camera.cx, camera.cy, camera.width, camera.height);
}

void AddObservation(int view_id, const Eigen::Vector2d& in_img, ScenePoint& point) {
  const auto is_of_view = [&](const ViewObservation& seen) { return seen.view_id == view_id; };
  if (std::ranges::none_of(point.track, is_of_view)) point.track.push_back({view_id, in_img});
}

}  // namespace ulf
