#include "core/light_field/folder/unposed_photographs.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <set>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/lowercase.h"
#include "core/image/files/image_header.h"
#include "core/image/files/picture_file.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

bool IsPicture(const fs::path& file) {
  constexpr std::array kEndings{".jpg", ".jpeg", ".png", ".tif", ".tiff", ".exr"};
  return std::ranges::find(kEndings, Lowercase(file.extension().string())) != kEndings.end();
}

bool IsMaster(const fs::path& file) { return file.stem().extension() == ".master"; }

// Returns the removed view to which this file belongs: 000012.png and 000012-2.png are names of RemoveView()
// for view 12.
std::optional<int> TakenBackView(const LightField& light_field, const fs::path& file) {
  const std::string name = file.filename().string();
  const std::size_t digits = std::min(name.find_first_not_of("0123456789"), name.size() - 1);
  if (digits < 6 || digits > 9 || (name[digits] != '.' && name[digits] != '-')) return std::nullopt;
  const int id = std::stoi(name.substr(0, digits));
  return light_field.taken_back.contains(id) ? std::optional(id) : std::nullopt;
}

bool Is8BitSrgb(const fs::path& file) {
  const auto header = ReadImageHeader(file.string());
  return header && header->bits <= 8;
}

// Photographs of views by their length in bytes: only those of equal length are compared.
class ViewBytes {
 public:
  explicit ViewBytes(const LightField& light_field) {
    std::error_code missing;
    for (const View& view : light_field.views) {
      const fs::path file = light_field.root / view.image_path;
      const auto bytes = fs::file_size(file, missing);
      if (!missing) by_length_[bytes].push_back(file);
    }
  }
  bool Contain(const fs::path& file) const {
    std::error_code missing;
    const auto alike = by_length_.find(fs::file_size(file, missing));
    if (missing || alike == by_length_.end()) return false;
    const std::string bytes = ReadWholeFile(file);
    return std::ranges::any_of(alike->second,
                               [&](const fs::path& other) { return ReadWholeFile(other) == bytes; });
  }

 private:
  std::map<std::uintmax_t, std::vector<fs::path>> by_length_;
};

std::string CameraProblem(const LightField& light_field, View& photograph) {
  const std::string path = (light_field.root / photograph.image_path).string();
  cv::Size size;
  try {
    size = ReadImageSize(path);
  } catch (const Error& error) {
    const std::string words = error.what();
    return words.starts_with(path + ": ") ? words.substr(path.size() + 2) : words;
  }
  const auto fits = [&](const CameraModel& camera) {
    return camera.width == size.width && camera.height == size.height;
  };
  if (fits(light_field.CameraOf(photograph))) return "";
  const auto other = std::ranges::find_if(light_field.cameras, fits);
  if (other == light_field.cameras.end())
    return fmt::format("it is {}x{}, and no camera of the light field has pictures of that size", size.width,
                       size.height);
  photograph.camera = static_cast<int>(other - light_field.cameras.begin());
  return "";
}

}  // namespace

std::vector<UnposedPhotograph> UnposedPhotographs(const LightField& light_field) {
  std::vector<fs::path> files;
  std::error_code refused;
  for (const auto& entry : fs::directory_iterator(light_field.root / "unposed", refused))
    if (entry.is_regular_file(refused) && IsPicture(entry.path()) && !IsMaster(entry.path()) &&
        !TakenBackView(light_field, entry.path()))
      files.push_back(entry.path());
  std::ranges::sort(files);
  const ViewBytes views(light_field);
  std::vector<UnposedPhotograph> photographs;
  for (const fs::path& file : files) {
    if (views.Contain(file)) continue;
    UnposedPhotograph& photograph = photographs.emplace_back();
    const std::string path = "unposed/" + file.filename().string();
    const auto noted = std::ranges::find_if(
        light_field.unposed, [&](const UnposedPhotograph& each) { return each.view.image_path == path; });
    if (noted != light_field.unposed.end()) photograph = *noted;
    View& view = photograph.view;
    view.image_path = path;
    if (!view.master_path.empty() && !fs::is_regular_file(light_field.root / view.master_path)) {
      view.master_path.clear();
      view.master_transfer.reset();
      view.master_mosaic = Mosaic::kNone;
    }
    if (photograph.problem.empty()) photograph.problem = CameraProblem(light_field, view);
    if (photograph.problem.empty() && !Is8BitSrgb(file))
      photograph.problem = "views' photographs are 8-bit JPEG or PNG; convert it";
  }
  return photographs;
}

std::size_t CountTakenBack(const LightField& light_field) {
  std::set<int> there;
  std::error_code refused;
  for (const auto& entry : fs::directory_iterator(light_field.root / "unposed", refused))
    if (const auto id = TakenBackView(light_field, entry.path())) there.insert(*id);
  return there.size();
}

}  // namespace ulf
