#include "core/light_field/formats/transforms_camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <string_view>

#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/image/files/image_header.h"
#include "core/image/files/picture_file.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::string_view kCameraKeys[] = {"fl_x", "fl_y", "cx", "cy", "w", "h", "camera_angle_x",
                                            "camera_angle_y", "k1", "k2", "k3", "k4", "p1", "p2",
                                            "camera_model", "is_fisheye",
                                            // instant-ngp's; refused.
                                            "ftheta_p0", "latlong", "equirectangular"};

constexpr int kMostPx = 1 << 20;

int SidePx(const JsonPlace& place, const char* key) {
  const double side = std::round(place.Number(key));
  if (!(side >= 1 && side <= kMostPx))
    throw Error("{}: '{}' is {} px; an image has 1 to {} on a side", place.where, key,
                JsonText(place.Raw(key)).substr(0, 40), kMostPx);
  return static_cast<int>(side);
}

}  // namespace

bool IsCameraKey(const std::string& key) {
  return std::ranges::find(kCameraKeys, key) != std::end(kCameraKeys);
}

json CameraKeysOf(const json& object) {
  json keys = json::object();
  for (const auto& [key, value] : object.items())
    if (IsCameraKey(key) && !value.is_null()) keys[key] = value;
  return keys;
}

json MergedCameraKeys(const json& set, const json& frame) {
  json keys = set;
  if (frame.contains("fl_x") || frame.contains("camera_angle_x"))
    for (const char* focal : {"fl_x", "fl_y", "camera_angle_x", "camera_angle_y"}) keys.erase(focal);
  if (frame.contains("camera_model") || frame.contains("is_fisheye"))
    for (const char* kind : {"camera_model", "is_fisheye"}) keys.erase(kind);
  keys.update(frame);
  return keys;
}

bool HasSize(const JsonPlace& place) { return place.Has("w") && place.Has("h"); }

bool HasIntrinsics(const JsonPlace& place) { return place.Has("fl_x") || place.Has("camera_angle_x"); }

CameraModel ReadCamera(const JsonPlace& place, const fs::path& example_image) {
  CameraModel camera;
  const cv::Size size = HasSize(place) ? cv::Size(SidePx(place, "w"), SidePx(place, "h"))
                                       : ReadImageSize(example_image.string());
  camera.width = size.width;
  camera.height = size.height;
  if (place.Has("fl_x")) {
    camera.fx = place.Number("fl_x");
    camera.fy = place.Number("fl_y", camera.fx);
  } else if (place.Has("camera_angle_x")) {
    camera.fx = 0.5 * camera.width / std::tan(0.5 * place.Number("camera_angle_x"));
    camera.fy = place.Has("camera_angle_y")
                    ? 0.5 * camera.height / std::tan(0.5 * place.Number("camera_angle_y"))
                    : camera.fx;
  } else {
    throw Error("{}: neither 'fl_x' nor 'camera_angle_x' is there; add the focal length in pixels as 'fl_x'",
                place.where);
  }
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

  for (const char* other : {"ftheta_p0", "latlong", "equirectangular"})
    if (place.Has(other) && place.Raw(other) != false)
      throw Error("{}: '{}' is of a lens model of instant-ngp that ulf does not have; undistort to PINHOLE",
                  place.where, other);
  const std::string model = place.Text("camera_model", "OPENCV");
  const bool fisheye =
      model == "OPENCV_FISHEYE" || (place.Has("is_fisheye") && place.Raw("is_fisheye") == true);
  constexpr const char* kPerspective[] = {"OPENCV", "PINHOLE", "SIMPLE_PINHOLE", "SIMPLE_RADIAL", "RADIAL"};
  if (!fisheye && std::ranges::find(kPerspective, model) == std::end(kPerspective))
    throw Error(
        "{}: camera model '{}' is not supported; undistort to PINHOLE, or use OPENCV or OPENCV_FISHEYE",
        place.where, model);
  const double k1 = place.Number("k1", 0), k2 = place.Number("k2", 0), k3 = place.Number("k3", 0);
  const double k4 = place.Number("k4", 0), p1 = place.Number("p1", 0), p2 = place.Number("p2", 0);
  camera.coefficients =
      fisheye ? std::array<double, 5>{k1, k2, k3, k4, 0} : std::array<double, 5>{k1, k2, p1, p2, k3};
  const bool all_zero = camera.coefficients == std::array<double, 5>{};
  camera.distortion = fisheye    ? Distortion::kFisheye
                      : all_zero ? Distortion::kNone
                                 : Distortion::kRadialTangential;
  if (!fisheye && k4 != 0)
    throw Error("{}: 'k4' belongs to OPENCV_FISHEYE; the model here is {}", place.where, model);
  if (fisheye && (p1 != 0 || p2 != 0))
    throw Error(
        "{}: 'p1' and 'p2' are {} and {}, which do not belong to OPENCV_FISHEYE (k1 k2 k3 k4); calibrate "
        "without them, or undistort to PINHOLE",
        place.where, p1, p2);
  camera.Validate(place.where);
  return camera;
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
      object["camera_model"] = "PINHOLE";
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
