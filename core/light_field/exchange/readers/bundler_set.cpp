#include "core/light_field/exchange/readers/set_readers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <optional>
#include <string_view>

#include "core/base/at.h"
#include "core/base/atomic_file.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/lowercase.h"
#include "core/image/files/picture_file.h"
#include "core/light_field/formats/text_file.h"
#include "core/light_field/formats/view_json.h"
#include "core/light_field/points/ply_reader.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

constexpr const char* kBundleTitle = "# Bundle file v0.3";

// Reads the words of a bundle file, with the line for messages, one word in memory at a time.
class BundleWords {
 public:
  explicit BundleWords(const fs::path& file) : name_(file.string()) {
    std::error_code unknown;
    if (fs::is_directory(file, unknown)) throw Error("{}: is a folder; give the bundle file in it", name_);
    stream_ = OpenTextFile(file);
    for (int c = Take(); c != '\n' && c != kEnd; c = Take())
      if (word_.size() < kMostInWord) word_ += static_cast<char>(c);
    if (!word_.starts_with(kBundleTitle))
      throw Error(
          "{}: does not begin with '{}'; other versions are not read: let the program export that one", name_,
          kBundleTitle);
    line_ = 2;
  }

  std::string Where() const { return fmt::format("{}, line {}", name_, line_of_word_); }

  double Number(const std::string& owner) {
    if (!NextWord())
      throw Error("{}: ends in {}; it is cut short, or its counts are wrong: copy or export it again", name_,
                  owner);
    double value = 0;
    if (!ParseNumber(word_, value)) throw Error("{}: '{}' in {} is no number", Where(), word_, owner);
    if (!std::isfinite(value)) throw Error("{}: '{}' in {} is not finite", Where(), word_, owner);
    return value;
  }

  int WholeNumber(const std::string& owner, int most) {
    const double value = Number(owner);
    if (value != std::floor(value) || value < 0 || value > most)
      throw Error("{}: '{}' in {} is not a whole number from 0 to {}", Where(), word_, owner, most);
    return static_cast<int>(value);
  }

  Eigen::Vector3d Vector(const std::string& owner) {
    Eigen::Vector3d vector;
    for (double& value : vector) value = Number(owner);
    return vector;
  }

  void RequireEnd() {
    if (NextWord())
      throw Error(
          "{}: the file goes on after the last point that it counts; its counts are wrong: export it again",
          Where());
  }

 private:
  static constexpr int kEnd = std::char_traits<char>::eof();
  static constexpr std::size_t kMostInWord = 64;

  int Take() { return stream_.rdbuf()->sbumpc(); }

  bool NextWord() {
    word_.clear();
    for (int c = Take(); c != kEnd; c = Take()) {
      const bool is_space = c == ' ' || c == '\t' || c == '\r' || c == '\n';
      if (!is_space) {
        if (word_.empty()) line_of_word_ = line_;
        word_ += static_cast<char>(c);
        if (word_.size() > kMostInWord) throw Error("{}: '{}...' is no number", Where(), word_);
      }
      if (c == '\n') ++line_;
      if (is_space && !word_.empty()) return true;
    }
    return !word_.empty();
  }

  std::string name_, word_;
  std::ifstream stream_;
  std::size_t line_ = 1, line_of_word_ = 1;
};

struct BundleCamera {
  double focal_px = 0, k1 = 0, k2 = 0;
  Rigid3 cam_from_world;
};

BundleCamera ReadBundleCamera(BundleWords& words, const std::string& owner, PoseRotations& rotations) {
  BundleCamera camera;
  camera.focal_px = words.Number(owner);
  const std::string where = words.Where();
  camera.k1 = words.Number(owner);
  camera.k2 = words.Number(owner);
  Eigen::Matrix3d rotation;
  for (int row = 0; row < 3; ++row) rotation.row(row) = words.Vector(owner);
  const Eigen::Vector3d translation = words.Vector(owner);
  if (camera.focal_px == 0) return camera;
  if (camera.focal_px < 0)
    throw Error(
        "{}: the focal length of {} is {}; it must be positive, or 0 for a camera that was not registered",
        where, owner, camera.focal_px);
  const Eigen::DiagonalMatrix<double, 3> ours_from_bundler(1, -1, -1);
  camera.cam_from_world.rotation =
      rotations.Read(ours_from_bundler * rotation, where, "the rotation of " + owner);
  // A scale is one of the camera's frame, which leads to the same pixels.
  camera.cam_from_world.translation = ours_from_bundler * translation / rotations.scale();
  return camera;
}

// Returns the name without "0 FOCAL" at its end.
std::string NameOfBundleRow(std::string row) {
  const auto trim = [&] { row.erase(row.find_last_not_of(" \t\r") + 1); };
  const auto last = [&] { return std::string_view(row).substr(row.find_last_of(" \t") + 1); };
  trim();
  row.erase(0, row.find_first_not_of(" \t"));
  std::ranges::replace(row, '\\', '/');  // lists from Windows
  const std::string whole = row;
  double focal = 0;
  if (row.find_first_of(" \t") == std::string::npos || !ParseNumber(last(), focal)) return whole;
  row.erase(row.find_last_of(" \t"));
  trim();
  if (row.find_first_of(" \t") == std::string::npos || last() != "0") return whole;
  row.erase(row.find_last_of(" \t"));
  trim();
  return row;
}

struct BundleList {
  fs::path file;
  std::vector<std::string> names;
};

fs::path FindBundleList(const fs::path& bundle_out) {
  const fs::path folder = fs::absolute(bundle_out).lexically_normal().parent_path();
  std::error_code unknown;
  const std::string stem = bundle_out.stem().string(), name = bundle_out.filename().string();
  const std::string short_stem = fs::path(stem).stem().string();  // COLMAP: a.bundle.out and a.list.txt
  for (const fs::path& place : {folder, folder.parent_path()}) {
    for (const std::string& list :
         {name + ".list.txt", stem + ".list.txt", short_stem + ".list.txt", std::string("list.txt"),
          std::string("list.focal.txt"), std::string("list.rd.txt")})
      if (fs::is_regular_file(place / list, unknown)) return place / list;
    std::vector<fs::path> others;
    for (const auto& entry : fs::directory_iterator(place, unknown)) {
      const std::string file = Lowercase(entry.path().filename().string());
      if ((file.ends_with(".list.txt") || file.ends_with(".lst")) && entry.is_regular_file(unknown))
        others.push_back(entry.path());
    }
    if (others.size() == 1) return others.front();
    if (others.size() > 1)
      throw Error("{}: {} holds several lists of photographs; name the one that belongs to it {}.list.txt",
                  bundle_out.string(), place.string(), stem);
  }
  throw Error(
      "{}: no list of its photographs in {} or above it; put list.txt there, with the name of a "
      "photograph in each line, in the order of the cameras",
      bundle_out.string(), folder.string());
}

BundleList ReadBundleList(const fs::path& bundle_out) {
  BundleList list{FindBundleList(bundle_out), {}};
  std::ifstream stream = OpenTextFile(list.file);
  for (std::string row; std::getline(stream, row);)
    if (row.find_first_not_of(" \t\r") != std::string::npos) list.names.push_back(NameOfBundleRow(row));
  return list;
}

// Returns the folder that all names have in common; empty if there is none.
fs::path CommonFolder(const std::vector<std::string>& names) {
  std::optional<fs::path> common;
  for (const std::string& name : names) {
    const fs::path folder = fs::path(name).lexically_normal().parent_path();
    if (!common) {
      common = folder;
      continue;
    }
    fs::path shared;
    auto a = common->begin(), b = folder.begin();
    for (; a != common->end() && b != folder.end() && *a == *b; ++a, ++b) shared /= *a;
    common = shared;
  }
  return common.value_or(fs::path());
}

// Finds photographs by their names in a list, which may be relative to any folder.
class BundlePhotographs {
 public:
  BundlePhotographs(const BundleList& list, const fs::path& chosen)
      : common_(CommonFolder(list.names)), images_(list.file.parent_path(), chosen, Folders(common_)) {
    std::vector<std::string> inside;
    for (const std::string& name : list.names) inside.push_back(Inside(name));
    images_.Reserve(inside);
  }

  const SetImages& images() const { return images_; }
  std::string Find(const std::string& name) const {
    std::string found = images_.Find(Inside(name));
    return found.empty() && !common_.empty() ? images_.Find(name) : found;
  }

 private:
  // Returns the name without the folder that all share.
  std::string Inside(const std::string& name) const {
    return common_.empty() ? name
                           : fs::path(name).lexically_normal().lexically_relative(common_).generic_string();
  }
  static std::vector<fs::path> Folders(const fs::path& common) {
    std::vector<fs::path> folders;
    if (!common.empty()) folders = {common, ".." / common};
    folders.insert(folders.end(), {"images", "photos", ".", "../images", "../photos", ".."});
    return folders;
  }

  fs::path common_;
  SetImages images_;
};

CameraModel ModelOfBundled(const BundleCamera& camera, const fs::path& image, const std::string& where) {
  const cv::Size size = ReadImageSize(image.string());
  CameraModel model = CameraModel::Pinhole(size.width, size.height, camera.focal_px);
  if (camera.k1 != 0 || camera.k2 != 0) {
    model.distortion = Distortion::kRadialTangential;
    model.coefficients = {camera.k1, camera.k2, 0, 0, 0};
  }
  model.Validate(where);
  return model;
}

// Returns the mean distance of a point's observations from its projections.
double MeanErrorPx(const ScenePoint& point, const LightField& light_field) {
  double sum = 0;
  int count = 0;
  for (const ViewObservation& seen : point.track) {
    const View& view = light_field.views[At(seen.view_id - 1)];
    const auto in_img = light_field.CameraOf(view).ImgFromCam(view.cam_from_world * point.position_in_world);
    if (!in_img) continue;
    sum += (*in_img - seen.in_img).norm();
    ++count;
  }
  return count == 0 ? 0 : sum / count;
}

// `view_ids` are by the number of the camera; 0: it has no view.
void ReadBundlePoints(BundleWords& words, int points, const std::vector<int>& view_ids,
                      LightField& light_field) {
  std::size_t twice = 0;
  for (int i = 0; i < points; ++i) {
    const std::string owner = fmt::format("point {} of {}", i + 1, points);
    ScenePoint point;
    point.position_in_world = words.Vector(owner);
    for (std::uint8_t& channel : point.rgb)
      channel = static_cast<std::uint8_t>(std::lround(std::clamp(words.Number(owner), 0.0, 255.0)));
    const int seen = words.WholeNumber(owner, kMostViewId);
    for (int k = 0; k < seen; ++k) {
      const int camera = words.WholeNumber(owner, kMostViewId);
      if (At(camera) >= view_ids.size())
        throw Error("{}: {} is seen by camera {}, and there are {}, counted from 0; export the set again",
                    words.Where(), owner, camera, view_ids.size());
      words.Number(owner);  // index of the image's feature
      const double x = words.Number(owner), y = words.Number(owner);
      const int view_id = view_ids[At(camera)];
      if (view_id == 0) continue;
      if (std::ranges::any_of(point.track,
                              [&](const ViewObservation& other) { return other.view_id == view_id; })) {
        ++twice;
        continue;
      }
      const CameraModel& model = light_field.CameraOf(light_field.views[At(view_id - 1)]);
      point.track.push_back({view_id, {0.5 * model.width + x, 0.5 * model.height - y}});
    }
    point.error_px = MeanErrorPx(point, light_field);
    light_field.points.push_back(std::move(point));
  }
  if (twice > 0)
    light_field.doubts.push_back(fmt::format("{} of points that a photograph shows twice: the first is kept",
                                             Counted(twice, "observation")));
}

}  // namespace

PosedSet ReadBundlerSet(const fs::path& bundle_out, const fs::path& images) {
  BundleWords words(bundle_out);
  const int camera_count = words.WholeNumber("the count of cameras", kMostViewId);
  const int point_count = words.WholeNumber("the count of points", kMostViewId);
  const BundleList list = ReadBundleList(bundle_out);
  if (list.names.size() != At(camera_count))
    throw Error("{}: names {}, and {} has {}; take the list that belongs to it", list.file.string(),
                Counted(list.names.size(), "photograph"), bundle_out.string(),
                Counted(camera_count, "camera"));
  if (camera_count == 0)
    throw Error("{}: holds no camera; export the set with its cameras", bundle_out.string());

  const BundlePhotographs photographs(list, images);
  const fs::path& root = photographs.images().folder();
  PosedSet set;
  set.format = "Bundler";
  LightField& light_field = set.light_field;
  light_field.root = root;
  std::vector<int> view_ids(list.names.size(), 0);
  std::map<std::string, std::string> taken;  // name in the list, by photograph
  std::size_t unregistered = 0;
  std::vector<std::string> missing;
  PoseRotations rotations;
  const ToldOnFailure told(light_field.doubts);
  for (int i = 0; i < camera_count; ++i) {
    const std::string& name = list.names[At(i)];
    const std::string owner = fmt::format("camera {} of {} ({})", i + 1, camera_count, name);
    const BundleCamera camera = ReadBundleCamera(words, owner, rotations);
    if (camera.focal_px == 0) {
      ++unregistered;
      continue;
    }
    const std::string path = photographs.Find(name);
    if (path.empty()) {
      missing.push_back(name);
      continue;
    }
    const auto [other, is_new] = taken.try_emplace(path, name);
    if (!is_new)
      throw Error("{}: '{}' and '{}' both lead to {}; give the folder from which the names count with {}",
                  list.file.string(), other->second, name, (root / path).string(), Parameter("images"));
    const CameraModel model = ModelOfBundled(camera, root / path, bundle_out.string() + ", " + owner);
    view_ids[At(i)] = AddView(path, model, camera.cam_from_world, photographs.images(), light_field).id;
  }
  if (unregistered == At(camera_count))
    throw Error(
        "{}: none of its {} cameras was registered (the focal length is 0); take the last bundle file",
        bundle_out.string(), camera_count);
  if (light_field.views.empty())
    throw Error("{}: '{}' and the other photographs of {} are not in {}; {}", bundle_out.string(),
                missing.front(), list.file.string(), root.string(), ImagesRemedy());
  rotations.Tell(bundle_out.string(), light_field.doubts);
  NoteUnposed(unregistered, "camera", "not registered (focal length 0)", set);
  if (!missing.empty())
    light_field.doubts.push_back(fmt::format("{} left out: no photograph in {}: {}{}",
                                             Counted(missing.size(), "camera"), root.string(),
                                             missing.front(), missing.size() > 1 ? ", ..." : ""));
  ReadBundlePoints(words, point_count, view_ids, light_field);
  words.RequireEnd();
  return set;
}

}  // namespace ulf
