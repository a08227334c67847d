#include "core/light_field/formats/transforms_camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <optional>
#include <string_view>

#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/image/files/image_header.h"
#include "core/image/files/picture_file.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::string_view kFocalKeysX[] = {"fl_x", "camera_angle_x", "x_fov"};
constexpr std::string_view kFocalKeysY[] = {"fl_y", "camera_angle_y", "y_fov"};
constexpr std::string_view kDistortionKeys[] = {"k1", "k2", "k3", "k4", "p1", "p2"};
constexpr std::string_view kOtherKeys[] = {
    "cx", "cy", "w", "h", "camera_model", "is_fisheye", "distortion_params"};
// How others spell these keys, whose values are the same.
constexpr std::pair<std::string_view, const char*> kOtherSpellings[] = {
    {"width", "w"}, {"height", "h"}, {"fx", "fl_x"}, {"fy", "fl_y"}};
// Fields of view, in radians (3DGS) or degrees; the keys of those units.
constexpr struct {
  const char *key, *in_radians, *in_degrees;
} kFieldsOfView[] = {{"fovx", "camera_angle_x", "x_fov"}, {"fovy", "camera_angle_y", "y_fov"}};
// Matrices of a camera: fx 0 cx, 0 fy cy.
constexpr std::string_view kMatrixKeys[] = {"intrinsic_matrix", "camera_matrix", "K"};

// Keys of lenses that ulf does not have; the place is refused unless IsOff() is true for their value.
struct OtherLensKey {
  std::string_view begins;  // the key, or what it begins with
  bool is_whole;
  const char* lens;
};
constexpr OtherLensKey kOtherLensKeys[] = {
    {"ftheta_", false, "the f-theta lens of instant-ngp"},
    {"latlong", true, "a panorama"},
    {"equirectangular", true, "a panorama"},
    {"orthographic", true, "an orthographic camera"},
    {"k5", true, "a lens with more than four radial coefficients"},
    {"k6", true, "a lens with more than four radial coefficients"},
    {"s1", true, "a lens with a thin prism"},
    {"s2", true, "a lens with a thin prism"},
    {"s3", true, "a lens with a thin prism"},
    {"s4", true, "a lens with a thin prism"},
};

const OtherLensKey* OtherLensOf(std::string_view key) {
  for (const OtherLensKey& other : kOtherLensKeys)
    if (other.is_whole ? key == other.begins : key.starts_with(other.begins)) return &other;
  return nullptr;
}

template <std::size_t N>
bool IsOneOf(const std::string_view (&keys)[N], std::string_view key) {
  return std::ranges::find(keys, key) != std::end(keys);
}

// Returns whether the object has one of the keys.
template <std::size_t N>
bool IsAnyOf(const std::string_view (&keys)[N], const json& object) {
  return std::ranges::any_of(keys, [&](std::string_view key) { return object.contains(key); });
}

// Returns fl_x, fl_y, cx and cy of a camera's matrix; none if it is none.
std::optional<json> KeysOfMatrix(const json& rows) {
  const auto number = [&](std::size_t row, std::size_t column) -> std::optional<double> {
    if (!rows.is_array() || row >= rows.size() || !rows[row].is_array() || column >= rows[row].size() ||
        !rows[row][column].is_number())
      return std::nullopt;
    return rows[row][column].get<double>();
  };
  const auto fx = number(0, 0), fy = number(1, 1), cx = number(0, 2), cy = number(1, 2);
  if (!fx || !fy || !cx || !cy) return std::nullopt;
  return json{{"fl_x", *fx}, {"fl_y", *fy}, {"cx", *cx}, {"cy", *cy}};
}

constexpr int kMostPx = 1 << 20;

int SidePx(const JsonPlace& place, const char* key) {
  const double side = std::round(place.Number(key));
  if (!(side >= 1 && side <= kMostPx))
    throw Error("{}: '{}' is {} px; an image has 1 to {} on a side", place.where, key,
                JsonText(place.Raw(key)).substr(0, 40), kMostPx);
  return static_cast<int>(side);
}

// Returns the focal length along one axis: from its field of view in degrees (instant-ngp), in pixels, or
// from its field of view in radians (NeRF); none if there is none.
std::optional<double> FocalPx(const JsonPlace& place, const char* axis, int side_px) {
  const std::string fov = fmt::format("{}_fov", axis), angle = fmt::format("camera_angle_{}", axis),
                    pixels = fmt::format("fl_{}", axis);
  const auto of_angle = [&](const std::string& key, double radians) {
    if (!(radians > 0 && radians < std::numbers::pi))
      throw Error("{}: '{}' is {}, a field of view of {:.4g} degrees; it must lie between 0 and 180",
                  place.where, key, JsonText(place.Raw(key.c_str())).substr(0, 40),
                  radians * 180 / std::numbers::pi);
    return 0.5 * side_px / std::tan(0.5 * radians);
  };
  std::optional<double> by_pixels, by_angle;
  std::string angle_key;
  if (place.Has(pixels.c_str())) by_pixels = place.Number(pixels.c_str());
  if (place.Has(angle.c_str())) {
    by_angle = of_angle(angle, place.Number(angle.c_str()));
    angle_key = angle;
  }
  if (place.Has(fov.c_str())) {
    by_angle = of_angle(fov, place.Number(fov.c_str()) * std::numbers::pi / 180);
    angle_key = fov;
  }
  constexpr double kMostApart = 0.02;  // relative; fields of view are often rounded. Guessed
  if (HasSize(place) && by_pixels && by_angle && std::abs(*by_angle / *by_pixels - 1) > kMostApart)
    throw Error(
        "{}: '{}' says a focal length of {:.6g} px and '{}' one of {:.6g} px for pictures of {} px; take the "
        "wrong one out",
        place.where, pixels, *by_pixels, angle_key, *by_angle, side_px);
  return by_pixels ? by_pixels : by_angle;
}

// Throws an Error for a matrix that is none, or says another focal length than the keys beside it.
void RequireMatrixAgrees(const JsonPlace& place, double focal_px) {
  constexpr double kMostApart = 0.02;  // as of fields of view
  for (const std::string_view view : kMatrixKeys) {
    const std::string key(view);
    if (!place.Has(key.c_str())) continue;
    const auto matrix = KeysOfMatrix(place.Raw(key.c_str()));
    if (!matrix)
      throw Error("{}: '{}' must be a camera's matrix, rows of numbers fx 0 cx and 0 fy cy", place.where,
                  key);
    if (const double fx = (*matrix)["fl_x"]; !(std::abs(fx / focal_px - 1) <= kMostApart))
      throw Error(
          "{}: '{}' says a focal length of {:.6g} px and other keys one of {:.6g} px; take the wrong one out",
          place.where, key, fx, focal_px);
  }
}

// k1 k2 k3 k4 p1 p2, in the order of nerfstudio's distortion_params.
std::array<double, 6> DistortionOf(const JsonPlace& place) {
  std::array<double, 6> single{};
  bool any = false;
  for (std::size_t i = 0; i < single.size(); ++i) {
    const std::string key(kDistortionKeys[i]);
    any = any || place.Has(key.c_str());
    single[i] = place.Number(key.c_str(), 0);
  }
  if (!place.Has("distortion_params")) return single;
  const json& given = place.Raw("distortion_params");
  std::array<double, 6> list{};
  const bool is_list = given.is_array() && given.size() == list.size() &&
                       std::ranges::all_of(given, [](const json& value) { return value.is_number(); });
  if (!is_list)
    throw Error("{}: 'distortion_params' is {}; nerfstudio has six numbers there: k1 k2 k3 k4 p1 p2",
                place.where, JsonText(given).substr(0, 80));
  for (std::size_t i = 0; i < list.size(); ++i) list[i] = given[i].get<double>();
  if (any && list != single)
    throw Error("{}: 'distortion_params' and 'k1' to 'p2' contradict each other; take the wrong ones out",
                place.where);
  return list;
}

constexpr const char* kLensWithK4 = "a lens with k4";
constexpr const char* kUndistort = "undistort the photographs to PINHOLE with the program that made the set";

// Returns the lens of nerfstudio whose radial polynomial has one term more than ours.
Projection LongPolynomial(const CameraModel& camera, double k4) {
  return [=](const Eigen::Vector3d& in_cam) -> std::optional<Eigen::Vector2d> {
    if (!(in_cam.z() > 0)) return std::nullopt;
    const auto& [k1, k2, p1, p2, k3] = camera.coefficients;
    const double x = in_cam.x() / in_cam.z(), y = in_cam.y() / in_cam.z(), r2 = x * x + y * y;
    const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * (k3 + r2 * k4)));
    return Eigen::Vector2d(camera.cx + camera.fx * (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)),
                           camera.cy + camera.fy * (y * radial + 2 * p2 * x * y + p1 * (r2 + 2 * y * y)));
  };
}

void RefuseOtherLenses(const JsonPlace& place) {
  for (const auto& [key, value] : place.object.items()) {
    const OtherLensKey* other = OtherLensOf(key);
    if (other && !IsOff(value))
      throw Error("{}: '{}' belongs to {}, which ulf does not have; {}", place.where, key, other->lens,
                  kUndistort);
  }
}

// Returns the model in capital letters, because programs differ in them.
std::string ModelOf(const JsonPlace& place) {
  std::string model = place.Text("camera_model", "OPENCV");
  for (char& c : model)
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  return model;
}

bool IsFisheye(const JsonPlace& place) {
  if (!place.Has("is_fisheye")) return false;
  const json& given = place.Raw("is_fisheye");
  if (!IsOff(given) && given != true && given != 1)
    throw Error("{}: 'is_fisheye' is {}; it must be true or false", place.where,
                JsonText(given).substr(0, 40));
  return !IsOff(given);
}

}  // namespace

bool IsOff(const json& value) { return value.is_null() || value == false || value == 0; }

bool IsCameraKey(const std::string& key) {
  const bool is_spelt_otherwise =
      std::ranges::any_of(kOtherSpellings, [&](const auto& pair) { return pair.first == key; });
  const bool is_field_of_view =
      std::ranges::any_of(kFieldsOfView, [&](const auto& field) { return field.key == key; });
  return is_spelt_otherwise || is_field_of_view || IsOneOf(kMatrixKeys, key) || IsOneOf(kFocalKeysX, key) ||
         IsOneOf(kFocalKeysY, key) || IsOneOf(kDistortionKeys, key) || IsOneOf(kOtherKeys, key) ||
         OtherLensOf(key);
}

json CameraKeysOf(const json& object) {
  json keys = json::object();
  for (const auto& [key, value] : object.items())
    if (IsCameraKey(key) && !value.is_null()) keys[key] = value;
  for (const auto& [other, key] : kOtherSpellings) {
    const std::string name(other);
    if (keys.contains(name) && !keys.contains(key)) keys[key] = keys[name];
    keys.erase(name);
  }
  for (const auto& [name, in_radians, in_degrees] : kFieldsOfView) {
    if (!keys.contains(name)) continue;
    const bool is_degrees = keys[name].is_number() && keys[name] > std::numbers::pi;
    const char* key = is_degrees ? in_degrees : in_radians;
    if (!keys.contains(key)) keys[key] = keys[name];
    keys.erase(name);
  }
  if (IsAnyOf(kFocalKeysX, keys) || IsAnyOf(kFocalKeysY, keys)) return keys;
  for (const std::string_view key : kMatrixKeys)
    if (const auto matrix = keys.find(std::string(key)); matrix != keys.end())
      if (const auto read = KeysOfMatrix(*matrix)) {
        keys.erase(matrix);
        keys.update(*read);
      }
  return keys;
}

json MergedCameraKeys(const json& set, const json& frame) {
  json keys = set;
  const auto erase = [&](const auto& group) {
    for (const std::string_view key : group) keys.erase(std::string(key));
  };
  const bool sets_x = IsAnyOf(kFocalKeysX, frame), sets_y = IsAnyOf(kFocalKeysY, frame);
  const bool replaces_x = sets_x && IsAnyOf(kFocalKeysX, set),
             replaces_y = sets_y && IsAnyOf(kFocalKeysY, set);
  if (sets_x || replaces_y) erase(kFocalKeysX);
  if (sets_y || replaces_x) erase(kFocalKeysY);
  if (frame.contains("camera_model") || frame.contains("is_fisheye"))
    for (const char* kind : {"camera_model", "is_fisheye"}) keys.erase(kind);
  if (frame.contains("distortion_params")) erase(kDistortionKeys);
  if (IsAnyOf(kDistortionKeys, frame)) keys.erase("distortion_params");
  keys.update(frame);
  return keys;
}

bool HasSize(const JsonPlace& place) { return place.Has("w") && place.Has("h"); }

bool HasIntrinsics(const JsonPlace& place) {
  const auto has = [&](std::string_view key) { return place.Has(std::string(key).c_str()); };
  return std::ranges::any_of(kFocalKeysX, has) || std::ranges::any_of(kFocalKeysY, has);
}

CameraModel ReadCamera(const JsonPlace& place, const fs::path& example_image, FittedLenses* fitted) {
  CameraModel camera;
  const cv::Size size = HasSize(place) ? cv::Size(SidePx(place, "w"), SidePx(place, "h"))
                                       : ReadImageSize(example_image.string());
  camera.width = size.width;
  camera.height = size.height;
  const auto fx = FocalPx(place, "x", camera.width), fy = FocalPx(place, "y", camera.height);
  if (!fx && !fy)
    throw Error(
        "{}: none of 'fl_x', 'camera_angle_x' and 'x_fov' is there; add the focal length in pixels as "
        "'fl_x'",
        place.where);
  camera.fx = fx ? *fx : *fy;
  camera.fy = fy ? *fy : *fx;
  RequireMatrixAgrees(place, camera.fx);
  camera.cx = place.Number("cx", 0.5 * camera.width);
  camera.cy = place.Number("cy", 0.5 * camera.height);
  // The principal point keeps this margin, in parts of the picture: no lens has its axis at a picture's
  // corner.
  constexpr int kLeastSide = 8;
  if (std::abs(camera.cx) <= 1 && std::abs(camera.cy) <= 1 &&
      std::max(camera.width, camera.height) >= kLeastSide)
    throw Error(
        "{}: 'cx' and 'cy' are {} and {}, in the corner of pictures of {}x{}: are they in parts of the "
        "picture, or from its middle? Write pixels from the upper left corner; the middle is {} {}",
        place.where, camera.cx, camera.cy, camera.width, camera.height, 0.5 * camera.width,
        0.5 * camera.height);

  RefuseOtherLenses(place);
  const std::string model = ModelOf(place);
  constexpr std::string_view kFisheyes[] = {"OPENCV_FISHEYE", "SIMPLE_RADIAL_FISHEYE", "RADIAL_FISHEYE",
                                            "SIMPLE_FISHEYE", "FISHEYE"};
  constexpr std::string_view kPerspective[] = {"OPENCV",        "PINHOLE", "SIMPLE_PINHOLE",
                                               "SIMPLE_RADIAL", "RADIAL",  "FULL_OPENCV"};
  if (!IsOneOf(kFisheyes, model) && !IsOneOf(kPerspective, model))
    throw Error(
        "{}: camera model '{}' is not supported; undistort to PINHOLE (a panorama: cut it into perspective "
        "pictures), or use OPENCV or OPENCV_FISHEYE",
        place.where, place.Text("camera_model", "OPENCV"));
  const bool fisheye = IsOneOf(kFisheyes, model) || IsFisheye(place);
  const auto [k1, k2, k3, k4, p1, p2] = DistortionOf(place);
  if (model == "FULL_OPENCV" && k4 != 0)
    throw Error("{}: 'k4' is {}, by which FULL_OPENCV divides, and ulf has no such lens; {}", place.where, k4,
                kUndistort);
  camera.coefficients =
      fisheye ? std::array<double, 5>{k1, k2, k3, k4, 0} : std::array<double, 5>{k1, k2, p1, p2, k3};
  const bool all_zero = camera.coefficients == std::array<double, 5>{};
  camera.distortion = fisheye               ? Distortion::kFisheye
                      : all_zero && k4 == 0 ? Distortion::kNone
                                            : Distortion::kRadialTangential;
  if (!fisheye && k4 != 0 && !fitted)
    throw Error(
        "{}: 'k4' is {}: OPENCV has no such coefficient; calibrate without it, or undistort to PINHOLE",
        place.where, k4);
  if (fisheye && (p1 != 0 || p2 != 0))
    throw Error(
        "{}: 'p1' and 'p2' are {} and {}, which do not belong to OPENCV_FISHEYE (k1 k2 k3 k4); calibrate "
        "without them, or undistort to PINHOLE",
        place.where, p1, p2);
  camera.Validate(place.where);
  if (fisheye || k4 == 0) return camera;
  CameraModel taken = fitted->Take(LongPolynomial(camera, k4), camera, kLensWithK4, place.where, kUndistort);
  if (taken.coefficients == std::array<double, 5>{}) taken.distortion = Distortion::kNone;
  return taken;
}

void WriteCamera(const CameraModel& camera, json& object) {
  object["w"] = camera.width;
  object["h"] = camera.height;
  object["fl_x"] = camera.fx;
  object["fl_y"] = camera.fy;
  object["cx"] = camera.cx;
  object["cy"] = camera.cy;
  const auto& c = camera.coefficients;
  switch (camera.distortion) {
    case Distortion::kNone:
      object["camera_model"] = "OPENCV";  // as nerfstudio writes it; Brush refuses PINHOLE
      break;
    case Distortion::kRadialTangential:
      object["camera_model"] = "OPENCV";
      object["k1"] = c[0];
      object["k2"] = c[1];
      object["p1"] = c[2];
      object["p2"] = c[3];
      object["k3"] = c[4];
      break;
    case Distortion::kFisheye:
      object["camera_model"] = "OPENCV_FISHEYE";
      object["is_fisheye"] = true;
      object["k1"] = c[0];
      object["k2"] = c[1];
      object["k3"] = c[2];
      object["k4"] = c[3];
      break;
  }
}

void WriteCameraKind(const std::vector<CameraModel>& cameras, json& object) {
  const auto is_fisheye = [](const CameraModel& camera) { return camera.distortion == Distortion::kFisheye; };
  if (cameras.empty()) return;
  if (std::ranges::all_of(cameras, is_fisheye))
    object["camera_model"] = "OPENCV_FISHEYE";
  else if (std::ranges::none_of(cameras, is_fisheye))
    object["camera_model"] = "OPENCV";
}

}  // namespace ulf
