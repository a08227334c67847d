#include "core/light_field/formats/colmap_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <tuple>

#include "core/base/error.h"
#include "core/light_field/formats/image_names.h"

namespace ulf {
namespace {

// What a parameter must be for a CameraModel to be equivalent, where it is none of its coefficients.
constexpr int kMustBeZero = -1, kAnything = -2;

struct ColmapLens {
  int number;
  const char* name;
  bool one_focal;
  Distortion distortion;
  std::vector<int> coefficients;  // CameraModel's index of each further parameter, or kMustBeZero, kAnything
  const char* beyond = "";        // the names of those that must be 0
  const char* since = "";         // the first version of COLMAP that knows it; empty: all
};

// The models of COLMAP of August 2026 (src/colmap/sensor/models.h) but for EQUIRECTANGULAR (17), which is no
// lens.
const std::vector<ColmapLens>& ColmapLenses() {
  constexpr Distortion kNone = Distortion::kNone, kRadial = Distortion::kRadialTangential,
                       kFish = Distortion::kFisheye;
  constexpr int kNil = kMustBeZero;
  static const std::vector<ColmapLens> lenses = {
      {0, "SIMPLE_PINHOLE", true, kNone, {}},
      {1, "PINHOLE", false, kNone, {}},
      {2, "SIMPLE_RADIAL", true, kRadial, {0}},
      {3, "RADIAL", true, kRadial, {0, 1}},
      {4, "OPENCV", false, kRadial, {0, 1, 2, 3}},
      {5, "OPENCV_FISHEYE", false, kFish, {0, 1, 2, 3}},
      {6, "FULL_OPENCV", false, kRadial, {0, 1, 2, 3, 4, kNil, kNil, kNil}, "k4 k5 k6, a rational model,"},
      {7, "FOV", false, kNone, {kNil}, "an omega"},
      {8, "SIMPLE_RADIAL_FISHEYE", true, kFish, {0}},
      {9, "RADIAL_FISHEYE", true, kFish, {0, 1}},
      {10, "THIN_PRISM_FISHEYE", false, kFish, {0, 1, kNil, kNil, 2, 3, kNil, kNil}, "p1 p2 sx1 sy1"},
      {11,
       "RAD_TAN_THIN_PRISM_FISHEYE",
       false,
       kFish,
       {0, 1, 2, 3, kNil, kNil, kNil, kNil, kNil, kNil, kNil, kNil},
       "k4 k5 p0 p1 s0 s1 s2 s3",
       "3.11"},
      {12, "SIMPLE_DIVISION", true, kNone, {kNil}, "a k", "4.0"},
      {13, "DIVISION", false, kNone, {kNil}, "a k", "4.0"},
      {14, "SIMPLE_FISHEYE", true, kFish, {}},
      {15, "FISHEYE", false, kFish, {}},
      {16, "EUCM", false, kNone, {kNil, kAnything}, "an alpha", "4.1"}};
  return lenses;
}

constexpr int kEquirectangular = 17;
constexpr const char* kEquirectangularName = "EQUIRECTANGULAR";

[[noreturn]] void RefuseEquirectangular(const std::string& where) {
  throw Error(
      "{}: '{}' is a panorama, which is not read, and which 'colmap image_undistorter' leaves as it is; "
      "COLMAP's python/examples/panorama_sfm.py (4.1 or later) renders perspective photographs of such "
      "panoramas and poses them",
      where, kEquirectangularName);
}

const ColmapLens& LensThat(const std::function<bool(const ColmapLens&)>& is_meant, const std::string& what,
                           const std::string& where) {
  for (const ColmapLens& lens : ColmapLenses())
    if (is_meant(lens)) return lens;
  throw Error(
      "{}: camera model {} is not known (0 to 17 of COLMAP are); 'colmap image_undistorter' of the version "
      "that wrote the set converts it to PINHOLE",
      where, what);
}

[[noreturn]] void RefuseParameters(const ColmapLens& lens, const std::string& where) {
  const std::string since = lens.since;
  throw Error("{}: '{}' with {} is not read; 'colmap image_undistorter'{} converts the set to PINHOLE", where,
              lens.name, lens.beyond, since.empty() ? "" : fmt::format(" (COLMAP {} or later)", since));
}

CameraModel CameraOf(const ColmapLens& lens, const ColmapReconstruction::Camera& from,
                     const std::string& where) {
  constexpr std::uint64_t kMostPx = 1 << 20;
  if (from.width < 1 || from.height < 1 || from.width > kMostPx || from.height > kMostPx)
    throw Error("{}: a camera of {}x{} pixels; an image has 1 to {} on a side", where, from.width,
                from.height, kMostPx);
  CameraModel camera;
  camera.width = static_cast<int>(from.width);
  camera.height = static_cast<int>(from.height);
  const std::vector<double>& p = from.parameters;
  const std::size_t first = lens.one_focal ? 3 : 4;
  if (p.size() != first + lens.coefficients.size())
    throw Error("{}: {} has {} parameters, not {}", where, lens.name, first + lens.coefficients.size(),
                p.size());
  camera.fx = p[0];
  camera.fy = lens.one_focal ? p[0] : p[1];
  camera.cx = p[first - 2];
  camera.cy = p[first - 1];
  camera.distortion = lens.distortion;
  for (std::size_t i = 0; i < lens.coefficients.size(); ++i) {
    const int which = lens.coefficients[i];
    if (which >= 0)
      camera.coefficients[static_cast<std::size_t>(which)] = p[first + i];
    else if (which == kMustBeZero && p[first + i] != 0)
      RefuseParameters(lens, where);
  }
  camera.Validate(where);
  return camera;
}

}  // namespace

CameraModel ReadColmapCamera(std::istream& row, const std::string& where) {
  std::string name;
  ColmapReconstruction::Camera camera;
  if (!(row >> name >> camera.width >> camera.height))
    throw Error("{}: is no row of a camera (CAMERA_ID MODEL WIDTH HEIGHT PARAMS[])", where);
  if (name == kEquirectangularName) RefuseEquirectangular(where);
  const ColmapLens& lens =
      LensThat([&](const ColmapLens& known) { return known.name == name; }, fmt::format("'{}'", name), where);
  for (double parameter; row >> parameter;) camera.parameters.push_back(parameter);
  row.clear();
  if (std::string word; row >> word && word[0] != '#')
    throw Error("{}: '{}' is no number that a lens has; correct the row, or export the cameras again", where,
                word);
  return CameraOf(lens, camera, where);
}

std::size_t ColmapParameters(int model, const std::string& where) {
  if (model == kEquirectangular) RefuseEquirectangular(where);
  const ColmapLens& lens = LensThat([&](const ColmapLens& known) { return known.number == model; },
                                    fmt::format("number {}", model), where);
  return (lens.one_focal ? 3u : 4u) + lens.coefficients.size();
}

CameraModel FromColmapCamera(const ColmapReconstruction::Camera& camera, const std::string& where) {
  ColmapParameters(camera.model, where);
  return CameraOf(*std::ranges::find(ColmapLenses(), camera.model, &ColmapLens::number), camera, where);
}

double NormalizeColmapPose(Rigid3& pose, const std::string& where) {
  constexpr double kShortest = 1e-6;  // guessed; a quaternion this short is a zero with rounding errors
  const double length = pose.rotation.norm();
  if (!pose.translation.allFinite() || !std::isfinite(length) || length < kShortest)
    throw Error(
        "{}: has no pose (a quaternion that is not zero and a translation, both finite); take it out of the "
        "model, or write the model anew",
        where);
  // A pose that ulf wrote comes back to the last digit.
  constexpr double kRounding = 1e-12;
  const double off = std::abs(length - 1);
  if (off > kRounding) pose.rotation.normalize();
  return off;
}

ColmapReconstruction::Camera ToColmapCamera(const CameraModel& camera) {
  ColmapReconstruction::Camera model;
  model.width = static_cast<std::uint64_t>(camera.width);
  model.height = static_cast<std::uint64_t>(camera.height);
  model.parameters = {camera.fx, camera.fy, camera.cx, camera.cy};
  const auto& c = camera.coefficients;
  const auto set = [&](int number, const char* name, std::initializer_list<double> more) {
    model.model = number;
    model.name = name;
    model.parameters.insert(model.parameters.end(), more);
  };
  const bool straight = camera.distortion == Distortion::kRadialTangential && c == std::array<double, 5>{};
  if (camera.distortion == Distortion::kNone || straight)
    set(1, "PINHOLE", {});
  else if (camera.distortion == Distortion::kFisheye)
    set(5, "OPENCV_FISHEYE", {c[0], c[1], c[2], c[3]});
  else if (c[4] == 0)
    set(4, "OPENCV", {c[0], c[1], c[2], c[3]});
  else
    set(6, "FULL_OPENCV", {c[0], c[1], c[2], c[3], c[4], 0, 0, 0});
  return model;
}

ColmapReconstruction ToColmap(const LightField& light_field) {
  ColmapReconstruction model;
  for (const CameraModel& camera : light_field.cameras) {
    model.cameras.push_back(ToColmapCamera(camera));
    model.cameras.back().id = static_cast<std::uint32_t>(model.cameras.size());
  }
  for (const View& view : light_field.views) {
    model.images.push_back({static_cast<std::uint32_t>(view.id),
                            static_cast<std::uint32_t>(view.camera) + 1,
                            view.cam_from_world,
                            SafeName(NameInImagesFolder(view.image_path)),
                            {}});
  }
  const bool some_are_tracked =
      std::ranges::any_of(light_field.points, [](const ScenePoint& point) { return !point.track.empty(); });
  for (const ScenePoint& from : light_field.points) {
    if (some_are_tracked && from.track.empty()) continue;
    ColmapReconstruction::Point& point = model.points.emplace_back();
    point.id = model.points.size();
    point.position = from.position_in_world;
    point.rgb = from.rgb;
    point.error_px = from.error_px;
    for (const ViewObservation& seen : from.track) {
      const View* view = light_field.FindView(seen.view_id);
      if (!view) continue;
      ColmapReconstruction::Image& image =
          model.images[static_cast<std::size_t>(view - light_field.views.data())];
      point.track.push_back({image.id, static_cast<std::uint32_t>(image.points.size())});
      image.points.push_back({seen.in_img, point.id});
    }
  }
  for (std::size_t i = 0; i < model.images.size(); ++i) {
    const CameraModel& camera = light_field.CameraOf(light_field.views[i]);
    if (model.images[i].points.empty()) model.images[i].points.push_back({{camera.cx, camera.cy}});
  }
  return model;
}

ColmapReconstruction NumberedAsInDatabase(const ColmapReconstruction& model) {
  ColmapReconstruction numbered = model;
  std::map<std::uint32_t, std::string> first_of;
  for (const ColmapReconstruction::Image& image : model.images) {
    const auto [first, is_new] = first_of.try_emplace(image.camera, image.name);
    if (!is_new) first->second = std::min(first->second, image.name);
  }
  std::erase_if(numbered.cameras,
                [&](const ColmapReconstruction::Camera& camera) { return !first_of.contains(camera.id); });
  std::ranges::sort(numbered.cameras, {}, [&](const ColmapReconstruction::Camera& camera) {
    return std::pair(first_of.at(camera.id), camera.id);
  });
  std::map<std::uint32_t, std::uint32_t> camera_ids, image_ids;
  for (ColmapReconstruction::Camera& camera : numbered.cameras) {
    const auto id = static_cast<std::uint32_t>(camera_ids.size() + 1);
    camera_ids[camera.id] = id;
    camera.id = id;
  }
  for (ColmapReconstruction::Image& image : numbered.images) image.camera = camera_ids.at(image.camera);
  std::ranges::sort(numbered.images, {}, [](const ColmapReconstruction::Image& image) {
    return std::tie(image.camera, image.name);
  });
  for (ColmapReconstruction::Image& image : numbered.images) {
    const auto id = static_cast<std::uint32_t>(image_ids.size() + 1);
    image_ids[image.id] = id;
    image.id = id;
  }
  for (ColmapReconstruction::Point& point : numbered.points)
    for (ColmapReconstruction::Seen& seen : point.track) seen.image = image_ids.at(seen.image);
  return numbered;
}

}  // namespace ulf
