#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <tuple>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/json_fields.h"
#include "core/base/lowercase.h"
#include "core/light_field/exchange/readers/json_entries.h"
#include "core/light_field/exchange/readers/named_views.h"
#include "core/light_field/exchange/readers/set_readers.h"
#include "core/light_field/formats/fitted_lens.h"
#include "core/light_field/points/ply_reader.h"
#include "core/light_field/points/point_tracks.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr double kSfmCentre = 0.5;  // of the first pixel in ours; AliceVision's is at 0
constexpr const char* kOtherSfmLens =
    "let Meshroom estimate another model (CameraInit > Default Camera Type: radial3, brown or fisheye4)";

// ---- Numbers, which AliceVision writes as text ----

double SfmNumberOf(const json& value, const JsonPlace& place, const char* key) {
  double number = 0;
  const bool is_text = value.is_string() && ParseNumber(value.get_ref<const std::string&>(), number);
  if (!is_text) number = value.is_number() ? value.get<double>() : std::numeric_limits<double>::quiet_NaN();
  if (!std::isfinite(number))
    throw Error("{}: '{}' holds {}, which is not a finite number", place.where, key,
                JsonText(value).substr(0, 40));
  return number;
}

double SfmNumber(const JsonPlace& place, const char* key) { return SfmNumberOf(place.Raw(key), place, key); }
double SfmNumber(const JsonPlace& place, const char* key, double otherwise) {
  return place.Has(key) ? SfmNumber(place, key) : otherwise;
}

// An empty list is written as empty text.
std::vector<double> SfmNumbers(const JsonPlace& place, const char* key) {
  std::vector<double> numbers;
  const json& list = place.Raw(key);
  if (list == "") return numbers;
  if (!list.is_array()) throw Error("{}: '{}' must be a list", place.where, key);
  for (const json& value : list) numbers.push_back(SfmNumberOf(value, place, key));
  return numbers;
}

std::vector<double> SfmNumbers(const JsonPlace& place, const char* key, std::size_t count) {
  std::vector<double> numbers = SfmNumbers(place, key);
  if (numbers.size() != count)
    throw Error("{}: '{}' must have {} numbers, not {}", place.where, key, count, numbers.size());
  return numbers;
}

// Returns an identifier; "" if it is missing.
std::string SfmId(const JsonPlace& place, const char* key) {
  if (!place.Has(key)) return {};
  const json& value = place.Raw(key);
  return value.is_string() ? value.get<std::string>() : JsonText(value).substr(0, 40);
}

std::vector<JsonPlace> SfmList(const JsonPlace& place, const char* key) {
  return place.Has(key) && place.Raw(key) == "" ? std::vector<JsonPlace>() : EntriesOf(place, key);
}

// ---- Lenses ----

using SfmVersion = std::array<int, 3>;

SfmVersion VersionOf(const JsonPlace& top) {
  const std::vector<double> numbers = SfmNumbers(top, "version", 3);
  SfmVersion version{};
  for (std::size_t i = 0; i < 3; ++i) version[i] = static_cast<int>(std::clamp(numbers[i], 0.0, 1e6));
  return version;
}

// Returns the focal lengths in x and y.
std::pair<double, double> SfmFocalPx(const JsonPlace& place, const SfmVersion& version,
                                     const CameraModel& size, std::vector<std::string>& doubts) {
  if (version < SfmVersion{1, 2, 0}) {
    const double focal = SfmNumber(place, "pxFocalLength");
    return {focal, focal};
  }
  if (version < SfmVersion{1, 2, 2}) {
    const std::vector<double> focal = SfmNumbers(place, "pxFocalLength", 2);
    return {focal[0], focal[1]};
  }
  const double sensor_mm = SfmNumber(place, "sensorWidth", 36), ratio = SfmNumber(place, "pixelRatio", 1);
  double side_px = size.width;
  if (version >= SfmVersion{1, 2, 11} && size.height > size.width) {
    side_px = size.height;
    const std::string words = fmt::format(
        "{}: in files of this version AliceVision writes focal lengths of upright photographs by their "
        "height "
        "and reads them by their width: taken as written",
        place.where);
    if (doubts.empty() || doubts.back() != words) doubts.push_back(words);
  }
  const double focal_px = SfmNumber(place, "focalLength") / sensor_mm * side_px;
  if (version < SfmVersion{1, 2, 5}) return {focal_px, focal_px / ratio};
  if (version < SfmVersion{1, 2, 11}) return {focal_px, focal_px * ratio};
  return {focal_px / ratio, focal_px};
}

// Returns the name of the distortion as files of version 1.2.8 and later have it.
std::string SfmDistortion(const JsonPlace& place, const SfmVersion& version, const std::string& type) {
  if (version >= SfmVersion{1, 2, 8}) {
    const std::string undistortion = Lowercase(place.Text("undistortionType", "none"));
    return undistortion == "none" ? Lowercase(place.Text("distortionType", "none"))
                                  : "undistortion by " + undistortion;
  }
  static const std::map<std::string, std::string> kOlder{
      {"pinhole", "none"},     {"radial1", "radialk1"}, {"radial3", "radialk3"},
      {"fisheye4", "fisheye"}, {"equidistant", "none"}, {"equidistant_r3", "radialk3pt"}};
  const auto found = kOlder.find(type);
  return found == kOlder.end() ? type : found->second;
}

// Sets the lens of a camera that projects by the angle (AliceVision's Equidistant.cpp), which is a fisheye.
void TakeEquidistant(const JsonPlace& place, const std::string& distortion, const std::vector<double>& k,
                     CameraModel& camera) {
  const double circle_px = SfmNumber(place, "fisheyeCircleRadius", 0);
  const double sensor_mm = SfmNumber(place, "sensorWidth", 36);
  const double smaller_mm = std::min(sensor_mm, SfmNumber(place, "sensorHeight", 24));
  if (!(circle_px > 1) || !(smaller_mm > 0))
    throw Error("{}: 'fisheyeCircleRadius' is {} px: the circle of the fisheye is not known; {}", place.where,
                circle_px, kOtherSfmLens);
  // The radius by which the distortion counts is 1 at the rim of the circle.
  const double radius_by_angle =
      2 * camera.fx * sensor_mm / std::max(camera.width, camera.height) / smaller_mm;
  const double square = radius_by_angle * radius_by_angle;
  double scale = 1;
  camera.distortion = Distortion::kFisheye;
  if (distortion == "radialk3pt") {
    scale = 1 + k[0] + k[1] + k[2];
    camera.coefficients = {k[0] * square, k[1] * square * square, k[2] * square * square * square, 0, 0};
  }
  camera.fx = camera.fy = circle_px * radius_by_angle / scale;
}

CameraModel ModelOfSfmIntrinsic(const JsonPlace& place, const SfmVersion& version,
                                std::vector<std::string>& doubts, FittedLenses& fitted) {
  CameraModel camera;
  const auto side = [&](const char* key) {
    constexpr double kMostPx = 1 << 20;
    const double value = SfmNumber(place, key);
    if (!(value >= 1 && value <= kMostPx)) throw Error("{}: '{}' is {}", place.where, key, value);
    return static_cast<int>(value);
  };
  camera.width = side("width");
  camera.height = side("height");
  std::tie(camera.fx, camera.fy) = SfmFocalPx(place, version, camera, doubts);
  const std::vector<double> point = SfmNumbers(place, "principalPoint", 2);
  const bool from_corner = version < SfmVersion{1, 2, 1};
  camera.cx = kSfmCentre + point[0] + (from_corner ? 0 : 0.5 * camera.width);
  camera.cy = kSfmCentre + point[1] + (from_corner ? 0 : 0.5 * camera.height);

  const std::string type = Lowercase(place.Text("type", "pinhole"));
  const std::string distortion = SfmDistortion(place, version, type);
  static const std::map<std::string, std::size_t> kCoefficients{
      {"none", 0},  {"radialk1", 1}, {"radialk3", 3}, {"radialk3pt", 3},
      {"brown", 5}, {"fisheye", 4},  {"fisheye1", 1}};
  const auto known = kCoefficients.find(distortion);
  const bool is_equidistant = type.starts_with("equidistant");
  if (known == kCoefficients.end() ||
      (is_equidistant != (distortion == "radialk3pt") && distortion != "none") ||
      (!is_equidistant && version >= SfmVersion{1, 2, 8} && type != "pinhole"))
    throw Error("{}: a camera of the type '{}' with the distortion '{}' is not supported; {}", place.where,
                type, distortion, kOtherSfmLens);
  std::vector<double> k =
      place.Has("distortionParams") ? SfmNumbers(place, "distortionParams") : std::vector<double>();
  if (k.empty()) k.assign(known->second, 0);  // not estimated yet
  if (k.size() != known->second)
    throw Error("{}: 'distortionParams' has {} numbers; the distortion '{}' has {}", place.where, k.size(),
                distortion, known->second);

  if (is_equidistant) {
    TakeEquidistant(place, distortion, k, camera);
  } else if (distortion == "fisheye") {
    camera.distortion = Distortion::kFisheye;
    camera.coefficients = {k[0], k[1], k[2], k[3], 0};
  } else if (distortion == "fisheye1" && k[0] != 0) {
    // Devernay and Faugeras 2001.
    const double tangent = 2 * std::tan(0.5 * k[0]);
    const CameraModel pinhole = camera;
    const Projection project = [=](const Eigen::Vector3d& point_in_cam) -> std::optional<Eigen::Vector2d> {
      if (!(point_in_cam.z() > 0)) return std::nullopt;
      const Eigen::Vector2d p = point_in_cam.head<2>() / point_in_cam.z();
      const double r = p.norm(), scale = r > 1e-9 ? std::atan(r * tangent) / (k[0] * r) : tangent / k[0];
      return Eigen::Vector2d(pinhole.fx * scale * p.x() + pinhole.cx,
                             pinhole.fy * scale * p.y() + pinhole.cy);
    };
    camera.distortion = Distortion::kFisheye;
    camera.fx *= tangent / k[0];
    camera.fy *= tangent / k[0];
    camera = fitted.Take(project, camera, "the lens fisheye1 of Meshroom", place.where, kOtherSfmLens);
  } else if (!k.empty()) {
    k.resize(5, 0.0);  // k1 k2 k3 t1 t2; these are OpenCV's p1 p2
    camera.coefficients = {k[0], k[1], k[3], k[4], k[2]};
    if (camera.coefficients != std::array<double, 5>{}) camera.distortion = Distortion::kRadialTangential;
  }
  camera.Validate(place.where);
  return camera;
}

// ---- Poses ----

Rigid3 SfmPose(const JsonPlace& place) {
  const std::vector<double> columns = SfmNumbers(place, "rotation", 9);
  const std::vector<double> center = SfmNumbers(place, "center", 3);
  Rigid3 cam_from_world;
  cam_from_world.rotation =
      NearestRotation(Eigen::Map<const Eigen::Matrix3d>(columns.data()), place.where, "'rotation'");
  cam_from_world.translation = -(cam_from_world.rotation * Eigen::Vector3d(center[0], center[1], center[2]));
  return cam_from_world;
}

// Poses and rigs by their identifiers.
struct SfmPoses {
  std::map<std::string, Rigid3> poses;
  std::map<std::string, std::vector<Rigid3>> rigs;  // the cameras' poses in the rig

  explicit SfmPoses(const JsonPlace& top) {
    for (const JsonPlace& entry : SfmList(top, "poses"))
      poses.emplace(SfmId(entry, "poseId"), SfmPose(entry.Inside("pose").Inside("transform")));
    for (const JsonPlace& rig : SfmList(top, "rigs")) {
      std::vector<Rigid3>& cameras = rigs[SfmId(rig, "rigId")];
      for (const JsonPlace& camera : SfmList(rig, "subPoses"))
        cameras.push_back(camera.Text("status", "") == "uninitialized" ? Rigid3()
                                                                       : SfmPose(camera.Inside("pose")));
    }
  }

  // Returns none for a view without a pose.
  std::optional<Rigid3> Of(const JsonPlace& view) const {
    const auto pose = poses.find(SfmId(view, "poseId"));
    if (pose == poses.end()) return std::nullopt;
    if (!view.Has("rigId") || SfmId(view, "isPoseIndependant") != "false") return pose->second;
    const auto rig = rigs.find(SfmId(view, "rigId"));
    const double camera = SfmNumber(view, "subPoseId");
    if (rig == rigs.end() || !(camera >= 0 && camera < static_cast<double>(rig->second.size())))
      throw Error("{}: its rig '{}' has no camera {}; export the set again", view.where, SfmId(view, "rigId"),
                  camera);
    return rig->second[static_cast<std::size_t>(camera)] * pose->second;
  }
};

// ---- Points ----

void ReadSfmPoints(const JsonPlace& top, const std::map<std::string, int>& view_ids,
                   LightField& light_field) {
  std::size_t nowhere = 0;
  for (const JsonPlace& entry : SfmList(top, "structure")) {
    if (entry.HoldsNotFinite("X")) {
      ++nowhere;
      continue;
    }
    ScenePoint point;
    const std::vector<double> position = SfmNumbers(entry, "X", 3);
    point.position_in_world = {position[0], position[1], position[2]};
    if (entry.Has("color")) {
      const std::vector<double> color = SfmNumbers(entry, "color", 3);
      for (std::size_t i = 0; i < 3; ++i)
        point.rgb[i] = static_cast<std::uint8_t>(std::lround(std::clamp(color[i], 0.0, 255.0)));
    }
    for (const JsonPlace& seen : SfmList(entry, "observations")) {
      const auto view = view_ids.find(SfmId(seen, "observationId"));
      if (view == view_ids.end() || !seen.Has("x")) continue;
      const std::vector<double> x = SfmNumbers(seen, "x", 2);
      AddObservation(view->second, {x[0] + kSfmCentre, x[1] + kSfmCentre}, point);
    }
    light_field.points.push_back(std::move(point));
  }
  NotePointsNowhere(nowhere, light_field);
  light_field.misplaced_observations = MeasurePoints(light_field);
}

}  // namespace

PosedSet ReadMeshroomSet(const fs::path& file, const fs::path& chosen) {
  const json document = ParseJson(ReadWholeFile(file), file.string(), "export it again");
  const JsonPlace top{document, file.string()};
  const SfmVersion version = VersionOf(top);
  PosedSet set;
  set.format = "Meshroom";
  LightField& light_field = set.light_field;
  const std::vector<JsonPlace> views = SfmList(top, "views");
  const SfmPoses poses(top);
  std::vector<std::string> names;
  for (const JsonPlace& view : views) names.push_back(view.Text("path", ""));
  const fs::path base = fs::absolute(file).lexically_normal().parent_path();
  SetImages images(base, chosen, FoldersOfNames(base, names));
  images.Reserve(names);
  std::map<std::string, JsonPlace> intrinsics;
  for (const JsonPlace& intrinsic : SfmList(top, "intrinsics"))
    intrinsics.emplace(SfmId(intrinsic, "intrinsicId"), intrinsic);

  NamedViews named(file, images, set);
  FittedLenses fitted;
  std::map<std::string, CameraModel> models;  // by the intrinsic's identifier
  std::map<std::string, int> view_ids;
  std::size_t unposed = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const JsonPlace& view = views[i];
    const std::string where = fmt::format("{} ({})", view.where, names[i]);
    const std::string intrinsic = SfmId(view, "intrinsicId");
    const auto cam_from_world = poses.Of(view);
    if (!cam_from_world || intrinsic.empty()) {
      ++unposed;
      continue;
    }
    const std::string path = named.Find(names[i], where);
    if (path.empty()) continue;
    const auto found = intrinsics.find(intrinsic);
    if (found == intrinsics.end())
      throw Error("{}: there are no intrinsics '{}'; export the set again", where, intrinsic);
    if (!models.contains(intrinsic))
      models.emplace(intrinsic, ModelOfSfmIntrinsic(found->second, version, light_field.doubts, fitted));
    view_ids[SfmId(view, "viewId")] = named.Add(path, models.at(intrinsic), *cam_from_world, where);
  }
  if (unposed == views.size())
    throw Error(
        "{}: none of its {} views has a pose; take cameras.sfm of Meshroom's node StructureFromMotion",
        file.string(), views.size());
  named.RequireFound();
  fitted.Note(light_field.doubts);
  NoteUnposed(unposed, "view", "without a pose", set);
  ReadSfmPoints(top, view_ids, light_field);
  return set;
}

}  // namespace ulf
