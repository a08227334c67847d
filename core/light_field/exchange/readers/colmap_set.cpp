#include "core/light_field/exchange/readers/set_readers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <map>
#include <set>
#include <unordered_map>

#include "core/base/atomic_file.h"
#include "core/base/binary_file.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/lowercase.h"
#include "core/base/name_order.h"
#include "core/light_field/exchange/readers/named_views.h"
#include "core/light_field/formats/colmap_files.h"
#include "core/light_field/formats/set_format.h"
#include "core/light_field/formats/text_file.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMapsOfPhotographs[] = {"mask", "depth", "normal"};
constexpr const char* kFoldersAroundModels[] = {"sparse", "colmap", "dense", "distorted", "undistorted"};

bool HoldsModel(const fs::path& folder, const char* ending) {
  return HoldsColmapPart(folder, "images", ending);
}

// Folders of a layout between the photographs and a model.
bool IsAroundModel(const std::string& name) {
  const bool is_number = name.find_first_not_of("0123456789") == std::string::npos;
  return is_number || std::ranges::find(kFoldersAroundModels, name) != std::end(kFoldersAroundModels);
}

// Maps of photographs bear their names.
bool IsFolderOfMaps(const fs::path& folder) {
  const std::string name = Lowercase(folder.filename().string());
  return std::ranges::any_of(kMapsOfPhotographs,
                             [&](const char* map) { return name.find(map) != std::string::npos; });
}

// Returns whether some of the model's photographs lie in the folder by their own names.
bool HoldsSome(const fs::path& folder, const std::vector<ColmapReconstruction::Image>& images) {
  constexpr std::size_t kEnough = 8;  // guessed; the first may be missing
  for (std::size_t i = 0; i < std::min(kEnough, images.size()); ++i) {
    const fs::path name = fs::path(images[i].name).lexically_normal();
    std::error_code unknown;
    if (name.is_relative() && !name.empty() && *name.begin() != ".." &&
        fs::is_regular_file(folder / name, unknown))
      return true;
  }
  return false;
}

// Returns folders in the order in which photographs are looked for: those of COLMAP's and trainers' layouts
// and the only other folder beside them with photographs of the model, first the ones that hold some by their
// own names.
std::vector<fs::path> ImagesFoldersOf(const fs::path& source, const fs::path& model_folder,
                                      const ColmapReconstruction& model) {
  const auto clean = [](const fs::path& path) {
    const fs::path whole = fs::absolute(path).lexically_normal();
    return whole.has_filename() ? whole : whole.parent_path();
  };
  const fs::path given = clean(source), inner = clean(model_folder);
  std::vector<fs::path> folders, others;
  bool is_distorted = false, is_above = false;
  // Searches from the model's own folder up to the one around its layout, at least up to the given one.
  fs::path around = inner;
  for (;; around = around.parent_path()) {
    // gaussian-splatting's convert.py keeps in input what distorted/sparse was measured in.
    if (is_distorted) folders.push_back(around / "input");
    for (const char* name : {"images", "images_2", "images_4", "images_8", "input", "photos"})
      folders.push_back(around / name);
    std::error_code unknown;
    for (const auto& entry : fs::directory_iterator(around, unknown))
      if (entry.is_directory(unknown)) others.push_back(entry.path());
    is_distorted |= around.filename() == "distorted";
    is_above |= around == given;
    if (!around.has_relative_path() ||
        (is_above && around != inner && !IsAroundModel(around.filename().string())))
      break;
  }
  const auto holds_some = [&](const fs::path& folder) { return HoldsSome(folder, model.images); };
  std::erase_if(others, [&](const fs::path& folder) {
    return IsFolderOfMaps(folder) || std::ranges::find(folders, folder) != folders.end() ||
           !holds_some(folder);
  });
  if (others.size() == 1) folders.push_back(others.front());
  // Around outputs/sfm of hloc, for example.
  for (const char* above : {"..", "../..", "../images", "../../images"})
    if (const fs::path folder = (around / above).lexically_normal(); holds_some(folder))
      folders.push_back(folder);
  std::stable_partition(folders.begin(), folders.end(), holds_some);
  folders.push_back(given);
  return folders;
}

// Reading order of the photographs, and the camera of each.
struct TakenImage {
  const ColmapReconstruction::Image* image;
  std::string path;  // relative to the images folder
  CameraModel camera;
  Eigen::Vector2d scale;  // of image points, for resized photographs
};

// The cameras of a model by their numbers.
class ModelCameras {
 public:
  ModelCameras(const ColmapReconstruction& model, const fs::path& folder) {
    for (const ColmapReconstruction::Camera& camera : model.cameras)
      cameras_[camera.id] =
          FromColmapCamera(camera, fmt::format("{}, camera {}", folder.string(), camera.id));
  }
  const CameraModel& Of(const ColmapReconstruction::Image& image, const std::string& where) const {
    const auto camera = cameras_.find(image.camera);
    if (camera == cameras_.end())
      throw Error("{}: its camera {} is not among the cameras; write the model anew", where, image.camera);
    return camera->second;
  }

 private:
  std::map<std::uint32_t, CameraModel> cameras_;
};

std::string WhereOf(const fs::path& model_folder, const ColmapReconstruction::Image& image) {
  return fmt::format("{}, image {} ({})", model_folder.string(), image.id, image.name);
}

std::vector<TakenImage> TakeImages(const ColmapReconstruction& model, const fs::path& model_folder,
                                   const SetImages& images, std::vector<std::string>& doubts) {
  const ModelCameras cameras(model, model_folder);
  std::vector<TakenImage> taken;
  std::vector<std::string> missing, elsewhere;
  for (const ColmapReconstruction::Image& image : model.images) {
    const std::string where = WhereOf(model_folder, image);
    const CameraModel& camera = cameras.Of(image, where);
    const std::string path = images.Find(image.name);
    if (path.empty()) {
      missing.push_back(image.name);
      continue;
    }
    if (IsInAnotherFolder(path, image.name)) elsewhere.push_back(fmt::format("{} for {}", path, image.name));
    const CameraModel own = AtSizeOf(images.folder() / path, camera, where, doubts);
    taken.push_back(
        {&image,
         path,
         own,
         {static_cast<double>(own.width) / camera.width, static_cast<double>(own.height) / camera.height}});
  }
  if (taken.empty())
    throw Error("{}: none of its {} is in {} ({} is the first); {}", model_folder.string(),
                Counted(model.images.size(), "photograph"), images.folder().string(),
                missing.empty() ? "there is none" : missing.front(), ImagesRemedy());
  if (!elsewhere.empty())
    doubts.push_back(fmt::format("{} taken from other folders than the model names: {}{}",
                                 Counted(elsewhere.size(), "photograph"), elsewhere.front(),
                                 elsewhere.size() > 1 ? ", ..." : ""));
  if (!missing.empty())
    doubts.push_back(fmt::format("{} of the model {} not in {} and left out, {} the first",
                                 Counted(missing.size(), "photograph"), missing.size() == 1 ? "is" : "are",
                                 images.folder().string(), missing.front()));
  std::ranges::sort(taken,
                    [](const TakenImage& a, const TakenImage& b) { return NameOrder(a.path, b.path); });
  return taken;
}

// Returns the model with the most images, the first of equals. COLMAP numbers the models of photographs that
// it could not join 0, 1, ...; the first need not be the largest.
fs::path LargestModel(const std::vector<fs::path>& models, std::vector<std::string>& doubts) {
  if (models.size() == 1) return models.front();
  std::vector<std::uint64_t> images;
  for (const fs::path& model : models) images.push_back(ImagesOfColmapModel(model));
  const auto largest = static_cast<std::size_t>(std::ranges::max_element(images) - images.begin());
  std::vector<std::string> others;
  const auto described = [&](std::size_t i) {
    return fmt::format("{} with {}", models[i].string(), Counted(images[i], "image"));
  };
  for (std::size_t i = 0; i < models.size(); ++i)
    if (i != largest) others.push_back(described(i));
  doubts.push_back(
      fmt::format("COLMAP could not join all photographs and made several models: the largest is read, {}; "
                  "give the folder of another to read it: {}",
                  described(largest), fmt::join(others, ", ")));
  return models[largest];
}

void SayUnposed(const SetImages& images, const std::vector<TakenImage>& taken, PosedSet& set) {
  std::set<std::string> posed;
  for (const TakenImage& each : taken) posed.insert(each.path);
  for (const View& view : set.light_field.views) posed.insert(view.mask_path);
  std::vector<std::string> left_out;
  for (const std::string& name : images.names())
    if (!posed.contains(name)) left_out.push_back(name);
  set.counts_unposed = !left_out.empty();
  if (!set.counts_unposed) return;
  constexpr std::size_t kMost = 20;
  const std::size_t unnamed = left_out.size() - std::min(kMost, left_out.size());
  set.light_field.doubts.push_back(
      fmt::format("{} without a pose in the model: left out ({}{})", Counted(left_out.size(), "photograph"),
                  fmt::join(left_out.begin(), left_out.end() - static_cast<std::ptrdiff_t>(unnamed), ", "),
                  unnamed > 0 ? fmt::format(" and {} more", unnamed) : ""));
}

void TakePoints(const ColmapReconstruction& model, const std::vector<TakenImage>& taken,
                LightField& light_field) {
  struct Shown {
    int view_id;
    const TakenImage* taken;
  };
  std::unordered_map<std::uint32_t, Shown> views;
  for (std::size_t i = 0; i < taken.size(); ++i)
    views[taken[i].image->id] = {static_cast<int>(i) + 1, &taken[i]};
  std::size_t astray = 0, nowhere = 0, unmeasured = 0;
  for (const ColmapReconstruction::Point& from : model.points) {
    if (!from.position.allFinite()) {
      ++nowhere;
      continue;
    }
    ScenePoint point{.position_in_world = from.position, .rgb = from.rgb, .error_px = from.error_px};
    std::set<int> seen_in;
    for (const ColmapReconstruction::Seen& seen : from.track) {
      const auto view = views.find(seen.image);
      if (view == views.end()) continue;
      const auto& points = view->second.taken->image->points;
      if (seen.index >= points.size()) {
        ++astray;
        continue;
      }
      const Eigen::Vector2d in_img = points[seen.index].in_img.cwiseProduct(view->second.taken->scale);
      // COLMAP's image_undistorter writes NaN where a point leaves its pinhole image.
      if (!in_img.allFinite())
        ++unmeasured;
      else if (seen_in.insert(view->second.view_id).second)
        point.track.push_back({view->second.view_id, in_img});
    }
    light_field.points.push_back(std::move(point));
  }
  const auto note = [&](std::size_t count, const char* noun, const char* what) {
    if (count > 0) light_field.doubts.push_back(fmt::format("{} {}: left out", Counted(count, noun), what));
  };
  note(astray, "observation", "of points in images where they are not listed");
  NotePointsNowhere(nowhere, light_field);
  note(unmeasured, "observation", "whose place in the image is not finite");
}

struct ReadModel {
  fs::path folder;
  bool is_binary = false;
  ColmapReconstruction model;
};

// Reads the largest model.
ReadModel ReadModelIn(const fs::path& source, std::vector<std::string>& doubts) {
  const std::vector<fs::path> models = ColmapModelsIn(source);
  if (models.empty())
    throw Error("{}: no COLMAP model (cameras and images as .bin or .txt) in it or in sparse/0",
                source.string());
  const fs::path folder = LargestModel(models, doubts);
  const bool is_binary =
      HoldsModel(folder, "bin") || (!HoldsModel(folder, "txt") && HoldsColmapPart(folder, "cameras", "bin"));
  ReadModel read{folder, is_binary, is_binary ? ReadColmapBinary(folder) : ReadColmapText(folder)};
  if (read.model.images.empty())
    throw Error("{}: the model has no images; was the reconstruction successful?", folder.string());
  if (is_binary && HoldsModel(folder, "txt"))
    doubts.push_back(fmt::format(
        "{}: there is a binary and a text model; the binary one is read, as COLMAP does", folder.string()));
  doubts.insert(doubts.end(), read.model.doubts.begin(), read.model.doubts.end());
  return read;
}

}  // namespace

std::uint64_t ImagesOfColmapModel(const fs::path& folder) {
  if (HoldsModel(folder, "bin")) {
    RequireRegularFile(folder / "images.bin");
    std::ifstream stream(folder / "images.bin", std::ios::binary);
    const std::string bytes = BytesAt(stream, 0, sizeof(std::uint64_t));
    return bytes.size() == sizeof(std::uint64_t) ? LittleEndian(bytes) : 0;
  }
  if (!HoldsModel(folder, "txt")) return 0;
  std::ifstream stream = OpenTextFile(folder / "images.txt");
  std::uint64_t lines = 0;
  for (std::string line; std::getline(stream, line);) lines += lines % 2 == 1 || !IsEmptyOrComment(line);
  return (lines + 1) / 2;  // the last image may lack its line of points
}

PosedSet ReadColmapSet(const fs::path& source, const fs::path& chosen) {
  PosedSet set;
  LightField& light_field = set.light_field;
  const ToldOnFailure told(light_field.doubts);
  const auto [folder, is_binary, model] = ReadModelIn(source, light_field.doubts);
  set.format = is_binary ? "COLMAP, binary" : "COLMAP, text";
  SetImages images(source, chosen, ImagesFoldersOf(source, folder, model));
  std::vector<std::string> names;
  for (const ColmapReconstruction::Image& image : model.images) names.push_back(image.name);
  images.Reserve(names);
  light_field.root = images.folder();
  const std::vector<TakenImage> taken = TakeImages(model, folder, images, light_field.doubts);
  for (const TakenImage& each : taken)
    AddView(each.path, each.camera, each.image->cam_from_world, images, light_field);
  SayUnposed(images, taken, set);
  TakePoints(model, taken, light_field);
  return set;
}

LightField ReadColmapSetPoses(const fs::path& source) {
  LightField poses;
  auto [folder, is_binary, model] = ReadModelIn(source, poses.doubts);
  const ModelCameras cameras(model, folder);
  std::ranges::sort(model.images, NameOrder, &ColmapReconstruction::Image::name);
  for (const ColmapReconstruction::Image& image : model.images) {
    View& view = poses.views.emplace_back();
    view.id = static_cast<int>(poses.views.size());
    view.image_path = image.name;
    view.camera = IndexOfCamera(cameras.Of(image, WhereOf(folder, image)), poses.cameras);
    view.cam_from_world = image.cam_from_world;
  }
  return poses;
}

}  // namespace ulf
