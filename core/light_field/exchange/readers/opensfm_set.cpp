#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "core/base/atomic_file.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/base/json_fields.h"
#include "core/image/files/picture_file.h"
#include "core/light_field/exchange/readers/json_entries.h"
#include "core/light_field/exchange/readers/named_views.h"
#include "core/light_field/exchange/readers/set_readers.h"
#include "core/light_field/formats/fitted_lens.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector2d;
using Eigen::Vector3d;
using nlohmann::json;

constexpr const char* kUndistortInOpenSfm =
    "undistort the photographs with OpenSfM ('opensfm undistort'), and import its "
    "undistorted/reconstruction.json";

const json kNoEntries = json::object();

// Returns the object of this key; an empty one if it is missing.
JsonPlace SfmEntries(const JsonPlace& place, const char* key) {
  if (!place.Has(key)) return {kNoEntries, place.where + ", " + key};
  JsonPlace entries = place.Inside(key);
  if (!entries.object.is_object()) throw Error("{}: must be an object", entries.where);
  return entries;
}

// The coefficients of the fisheyes with six radial, two tangential and four prismatic ones.
struct LongFisheye {
  std::array<double, 6> k{};
  double p1 = 0, p2 = 0;
  std::array<double, 4> s{};

  // From the axis' plane to the distorted one (OpenSfM's Disto62 and Disto624).
  Vector2d Distort(const Vector3d& point_in_cam) const {
    const double r = point_in_cam.head<2>().norm(), theta = std::atan2(r, point_in_cam.z());
    const Vector2d p = r < 1e-12 ? Vector2d::Zero() : Vector2d(theta / r * point_in_cam.head<2>());
    const double t2 = theta * theta;
    double radial = 0;
    for (std::size_t i = k.size(); i-- > 0;) radial = t2 * (k[i] + radial);
    return {p.x() * (1 + radial) + 2 * p1 * p.x() * p.y() + p2 * (t2 + 2 * p.x() * p.x()) +
                t2 * (s[0] + t2 * s[1]),
            p.y() * (1 + radial) + 2 * p2 * p.x() * p.y() + p1 * (t2 + 2 * p.y() * p.y()) +
                t2 * (s[2] + t2 * s[3])};
  }
};

// `image` is one of its photographs, for the size if the file does not say it.
CameraModel ModelOfOpenSfmCamera(const JsonPlace& place, const fs::path& image, FittedLenses& fitted) {
  const std::string type = place.Text("projection_type", "perspective");
  constexpr std::array kKnown{"perspective", "simple_radial",  "radial",    "brown",
                              "fisheye",     "fisheye_opencv", "fisheye62", "fisheye624"};
  if (std::ranges::find(kKnown, type) == kKnown.end())
    throw Error("{}: a camera of the type '{}' is not supported; {}", place.where, type, kUndistortInOpenSfm);
  CameraModel camera;
  camera.width = place.Integer("width", 0);
  camera.height = place.Integer("height", 0);
  if (camera.width <= 0 || camera.height <= 0) {
    const cv::Size size = ReadImageSize(image.string());
    camera.width = size.width;
    camera.height = size.height;
  }
  const double size_px = std::max(camera.width, camera.height);
  const bool has_one_focal = place.Has("focal");
  camera.fx = size_px * place.Number(has_one_focal ? "focal" : "focal_x");
  camera.fy = has_one_focal ? camera.fx : size_px * place.Number("focal_y");
  camera.cx = 0.5 * camera.width + size_px * place.Number("c_x", 0);
  camera.cy = 0.5 * camera.height + size_px * place.Number("c_y", 0);
  const auto value = [&](const char* key) { return place.Number(key, 0); };
  if (!type.starts_with("fisheye")) {
    camera.coefficients = {value("k1"), value("k2"), value("p1"), value("p2"), value("k3")};
    if (camera.coefficients != std::array<double, 5>{}) camera.distortion = Distortion::kRadialTangential;
  } else if (type == "fisheye" || type == "fisheye_opencv") {
    camera.distortion = Distortion::kFisheye;
    camera.coefficients = {value("k1"), value("k2"), value("k3"), value("k4"), 0};
  } else {
    LongFisheye lens{{value("k1"), value("k2"), value("k3"), value("k4"), value("k5"), value("k6")},
                     value("p1"),
                     value("p2"),
                     {value("s0"), value("s1"), value("s2"), value("s3")}};
    camera.distortion = Distortion::kFisheye;
    camera.coefficients = {lens.k[0], lens.k[1], lens.k[2], lens.k[3], 0};
    camera.Validate(place.where);
    const CameraModel start = camera;
    const Projection project = [&](const Vector3d& point_in_cam) -> std::optional<Vector2d> {
      const Vector2d p = lens.Distort(point_in_cam);
      return Vector2d(start.fx * p.x() + start.cx, start.fy * p.y() + start.cy);
    };
    camera = fitted.Take(project, start, fmt::format("the lens {} of OpenSfM", type), place.where,
                         kUndistortInOpenSfm);
  }
  camera.Validate(place.where);
  return camera;
}

Rigid3 OpenSfmPose(const JsonPlace& shot) {
  const std::vector<double> rotation = shot.Numbers("rotation", 3);
  const std::vector<double> translation = shot.Numbers("translation", 3);
  const Vector3d turn(rotation[0], rotation[1], rotation[2]);
  const double angle = turn.norm();
  Rigid3 cam_from_world;
  if (angle > 0) cam_from_world.rotation = Eigen::AngleAxisd(angle, turn / angle);
  cam_from_world.translation = {translation[0], translation[1], translation[2]};
  return cam_from_world;
}

// Returns the number of the reconstruction with the most shots, and notes the others.
std::size_t LargestReconstruction(const std::vector<JsonPlace>& all, std::vector<std::string>& doubts) {
  std::vector<std::size_t> shots;
  for (const JsonPlace& one : all) shots.push_back(SfmEntries(one, "shots").object.size());
  const std::size_t largest = static_cast<std::size_t>(std::ranges::max_element(shots) - shots.begin());
  if (all.size() > 1) {
    std::vector<std::size_t> others = shots;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(largest));
    doubts.push_back(fmt::format("of {} the largest is read, with {}; left out: those with {}",
                                 Counted(all.size(), "reconstruction"), Counted(shots[largest], "shot"),
                                 fmt::join(others, ", ")));
  }
  return largest;
}

}  // namespace

PosedSet ReadOpenSfmSet(const fs::path& file, const fs::path& chosen) {
  json document = json::object();
  document["reconstructions"] = ParseJson(ReadWholeFile(file), file.string(), "export it again");
  PosedSet set;
  set.format = "OpenSfM";
  LightField& light_field = set.light_field;
  const std::vector<JsonPlace> all = EntriesOf(JsonPlace{document, file.string()}, "reconstructions");
  if (all.empty()) throw Error("{}: holds no reconstruction; run 'opensfm reconstruct'", file.string());
  const JsonPlace& top = all[LargestReconstruction(all, light_field.doubts)];
  const JsonPlace shots = SfmEntries(top, "shots"), cameras = SfmEntries(top, "cameras");
  std::vector<std::string> names;
  for (const auto& [name, shot] : shots.object.items()) names.push_back(name);
  if (names.empty()) throw Error("{}: has no 'shots'; run 'opensfm reconstruct'", top.where);
  const fs::path base = fs::absolute(file).lexically_normal().parent_path();
  SetImages images(base, chosen, FoldersOfNames(base, names));
  images.Reserve(names);

  NamedViews named(file, images, set);
  FittedLenses fitted;
  std::map<std::string, CameraModel> models;
  for (const std::string& name : names) {
    const JsonPlace shot{shots.object.at(name), shots.where + " " + name};
    const std::string path = named.Find(name, shot.where);
    if (path.empty()) continue;
    const std::string camera = shot.Text("camera");
    if (!cameras.Has(camera.c_str()))
      throw Error("{}: there is no camera '{}'; reconstruct again", shot.where, camera);
    if (!models.contains(camera)) {
      const JsonPlace place{cameras.object.at(camera), cameras.where + " '" + camera + "'"};
      models.emplace(camera, ModelOfOpenSfmCamera(place, images.folder() / path, fitted));
    }
    named.Add(path, models.at(camera), OpenSfmPose(shot), shot.where);
  }
  named.RequireFound();
  fitted.Note(light_field.doubts);
  NoteUnposed(SfmEntries(top, "pano_shots").object.size(), "panorama", "not perspective", set);
  const JsonPlace points = SfmEntries(top, "points");
  std::size_t nowhere = 0;
  for (const auto& [name, object] : points.object.items()) {
    const JsonPlace place{object, points.where + " " + name};
    if (place.HoldsNotFinite("coordinates")) {
      ++nowhere;
      continue;
    }
    const std::vector<double> position = place.Numbers("coordinates", 3);
    const std::vector<double> color = place.Has("color") ? place.Numbers("color", 3) : std::vector<double>(3);
    ScenePoint& point = light_field.points.emplace_back();
    point.position_in_world = {position[0], position[1], position[2]};
    for (std::size_t i = 0; i < 3; ++i)
      point.rgb[i] = static_cast<std::uint8_t>(std::lround(std::clamp(color[i], 0.0, 255.0)));
  }
  NotePointsNowhere(nowhere, light_field);
  return set;
}

}  // namespace ulf
