#include "acquisition/calibration/calibration_formats.h"

#include <fmt/format.h>

#include <array>
#include <cstddef>
#include <opencv2/core.hpp>

#include "core/base/error.h"

namespace ulf::acquisition {
namespace {

constexpr std::array kNames{"kalibr", "ros", "opencv", "colmap"};

std::string JoinedCoefficients(const CameraModel& camera, std::size_t count) {
  std::string text;
  const bool plain = camera.distortion == Distortion::kNone;
  for (std::size_t i = 0; i < count; ++i)
    text += fmt::format("{}{}", i ? ", " : "", plain ? 0 : camera.coefficients[i]);
  return text;
}

std::string KalibrText(const CameraModel& camera) {
  if (camera.distortion == Distortion::kRadialTangential && camera.coefficients[4] != 0)
    throw Error(
        "Kalibr's radtan has no k3, but this calibration has ({}): calibrate with fewer coefficients, or "
        "write ros, opencv or colmap",
        camera.coefficients[4]);
  const bool fisheye = camera.distortion == Distortion::kFisheye;
  return fmt::format(
      "cam0:\n  camera_model: pinhole\n  intrinsics: [{}, {}, {}, {}]\n  distortion_model: {}\n"
      "  distortion_coeffs: [{}]\n  resolution: [{}, {}]\n  rostopic: /cam0/image_raw\n",
      camera.fx, camera.fy, camera.cx - 0.5, camera.cy - 0.5, fisheye ? "equidistant" : "radtan",
      JoinedCoefficients(camera, 4), camera.width, camera.height);
}

std::string RosText(const CameraModel& camera, const std::string& name) {
  const bool fisheye = camera.distortion == Distortion::kFisheye;
  const double cx = camera.cx - 0.5, cy = camera.cy - 0.5;
  const std::size_t count = fisheye ? 4 : 5;
  return fmt::format(
      "image_width: {}\nimage_height: {}\ncamera_name: {}\n"
      "camera_matrix:\n  rows: 3\n  cols: 3\n  data: [{}, 0, {}, 0, {}, {}, 0, 0, 1]\n"
      "distortion_model: {}\ndistortion_coefficients:\n  rows: 1\n  cols: {}\n  data: [{}]\n"
      "rectification_matrix:\n  rows: 3\n  cols: 3\n  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n"
      "projection_matrix:\n  rows: 3\n  cols: 4\n  data: [{}, 0, {}, 0, 0, {}, {}, 0, 0, 0, 1, 0]\n",
      camera.width, camera.height, name, camera.fx, cx, camera.fy, cy, fisheye ? "equidistant" : "plumb_bob",
      count, JoinedCoefficients(camera, count), camera.fx, cx, camera.fy, cy);
}

std::string OpenCvText(const CameraModel& camera, bool xml) {
  const bool fisheye = camera.distortion == Distortion::kFisheye;
  const cv::Matx33d k(camera.fx, 0, camera.cx - 0.5, 0, camera.fy, camera.cy - 0.5, 0, 0, 1);
  cv::Mat d = cv::Mat::zeros(fisheye ? 4 : 5, 1, CV_64F);
  if (camera.distortion != Distortion::kNone)
    for (int i = 0; i < d.rows; ++i) d.at<double>(i) = camera.coefficients[static_cast<std::size_t>(i)];
  cv::FileStorage file(xml ? ".xml" : ".yml", cv::FileStorage::WRITE | cv::FileStorage::MEMORY);
  file << "image_width" << camera.width << "image_height" << camera.height << "fisheye_model"
       << (fisheye ? 1 : 0) << "camera_matrix" << cv::Mat(k) << "distortion_coefficients" << d;
  return file.releaseAndGetString();
}

std::string ColmapCameraText(const CameraModel& camera) {
  const auto& c = camera.coefficients;
  const std::string four = fmt::format("{} {} {} {}", camera.fx, camera.fy, camera.cx, camera.cy);
  std::string model = "PINHOLE", parameters = four;
  if (camera.distortion == Distortion::kFisheye) {
    model = "OPENCV_FISHEYE";
    parameters = fmt::format("{} {} {} {} {}", four, c[0], c[1], c[2], c[3]);
  } else if (camera.distortion == Distortion::kRadialTangential) {
    const bool full = c[4] != 0;
    model = full ? "FULL_OPENCV" : "OPENCV";
    parameters = fmt::format("{} {} {} {} {}", four, c[0], c[1], c[2], c[3]);
    if (full) parameters += fmt::format(" {} 0 0 0", c[4]);
  } else if (camera.fx == camera.fy) {
    model = "SIMPLE_PINHOLE";
    parameters = fmt::format("{} {} {}", camera.fx, camera.cx, camera.cy);
  }
  return fmt::format("# CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]\n1 {} {} {} {}\n", model, camera.width,
                     camera.height, parameters);
}

}  // namespace

const char* Name(CalibrationFormat format) { return kNames[static_cast<std::size_t>(format)]; }

std::optional<CalibrationFormat> CalibrationFormatByName(const std::string& name) {
  for (std::size_t i = 0; i < kNames.size(); ++i)
    if (name == kNames[i]) return static_cast<CalibrationFormat>(i);
  return std::nullopt;
}

std::string CalibrationText(CalibrationFormat format, const CameraModel& camera, const std::string& name,
                            bool xml) {
  switch (format) {
    case CalibrationFormat::kKalibr:
      return KalibrText(camera);
    case CalibrationFormat::kRos:
      return RosText(camera, name);
    case CalibrationFormat::kOpenCv:
      return OpenCvText(camera, xml);
    default:
      return ColmapCameraText(camera);
  }
}

}  // namespace ulf::acquisition
