#include "acquisition/calibration/calibration_formats.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <opencv2/core.hpp>
#include <sstream>
#include <vector>

#include "core/base/error.h"
#include "core/light_field/exchange/colmap_model.h"

namespace ulf::acquisition {
namespace {

constexpr std::array kNames{"kalibr", "ros", "opencv", "colmap"};

// The wanted name, or the only one.
std::string Pick(const std::vector<std::string>& names, const std::string& wanted, const std::string& where) {
  if (names.empty()) throw Error("{}: contains no camera", where);
  if (wanted.empty() && names.size() > 1)
    throw Error(
        "{}: contains {} cameras ({}); extract one with ulf calibration {} --camera {} -o camera.json", where,
        names.size(), fmt::join(names, ", "), where, names[0]);
  if (wanted.empty()) return names[0];
  if (std::find(names.begin(), names.end(), wanted) == names.end())
    throw Error("{}: there is no camera '{}' (there are: {})", where, wanted, fmt::join(names, ", "));
  return wanted;
}

std::array<double, 5> Coefficients(const std::vector<double>& values) {
  std::array<double, 5> coefficients{};
  std::copy_n(values.begin(), std::min<std::size_t>(5, values.size()), coefficients.begin());
  return coefficients;
}

bool IsZeroFrom(const std::vector<double>& values, std::size_t first) {
  return std::all_of(values.begin() + static_cast<std::ptrdiff_t>(std::min(first, values.size())),
                     values.end(), [](double value) { return value == 0; });
}

// `d`: k1 k2 p1 p2 [k3 [k4 k5 k6 [s1..s4 [tx ty]]]], as in OpenCV and ROS.
CameraModel FromOpenCvCoefficients(int width, int height, const std::vector<double>& k,
                                   const std::vector<double>& d, bool fisheye, const std::string& where) {
  if (width <= 0 || height <= 0) throw Error("{}: the image's size is missing", where);
  if (fisheye && d.size() > 4 && !IsZeroFrom(d, 4))
    throw Error("{}: a fisheye model with {} coefficients; ulf reads the one with k1 k2 k3 k4", where,
                d.size());
  if (!fisheye && !IsZeroFrom(d, 5))
    throw Error(
        "{}: a rational, thin prism or tilted model ({} coefficients); ulf reads k1 k2 p1 p2 k3: calibrate "
        "again without CALIB_RATIONAL_MODEL and similar flags",
        where, d.size());
  const bool plain = IsZeroFrom(d, 0);
  CameraModel camera = CameraModel::FromOpenCv(width, height, k[0], k[4], k[2], k[5],
                                               fisheye ? Distortion::kFisheye
                                               : plain ? Distortion::kNone
                                                       : Distortion::kRadialTangential,
                                               Coefficients(d));
  if (k[1] != 0) throw Error("{}: the camera matrix has skew ({}), which ulf does not support", where, k[1]);
  camera.Validate(where);
  return camera;
}

template <typename T>
T Get(const YAML::Node& node, const char* key, const std::string& where) {
  if (!node[key]) throw Error("{}: the key '{}' is missing", where, key);
  try {
    return node[key].as<T>();
  } catch (const YAML::Exception&) {
    throw Error("{}: '{}' has the wrong type", where, key);
  }
}

YAML::Node LoadYaml(const std::string& text, const std::string& where) {
  try {
    return YAML::Load(text);
  } catch (const YAML::Exception& error) {
    throw Error("{}: not valid YAML: {}", where, error.what());
  }
}

CameraModel ReadKalibr(const std::string& text, const std::string& where, const std::string& wanted) {
  const YAML::Node top = LoadYaml(text, where);
  std::vector<std::string> names;
  for (const auto& entry : top)
    if (entry.second.IsMap() && entry.second["camera_model"]) names.push_back(entry.first.as<std::string>());
  const std::string name = Pick(names, wanted, where), place = where + ", " + name;
  const YAML::Node camera = top[name];
  const auto model = Get<std::string>(camera, "camera_model", place);
  if (model != "pinhole")
    throw Error("{}: ulf does not read the camera model '{}'; calibrate with pinhole-radtan or pinhole-equi",
                place, model);
  const auto intrinsics = Get<std::vector<double>>(camera, "intrinsics", place);
  const auto size = Get<std::vector<int>>(camera, "resolution", place);
  if (intrinsics.size() != 4 || size.size() != 2)
    throw Error("{}: a pinhole has 4 intrinsics and 2 numbers of resolution", place);
  const auto distortion = Get<std::string>(camera, "distortion_model", place);
  std::vector<double> coefficients;
  if (distortion != "none") coefficients = Get<std::vector<double>>(camera, "distortion_coeffs", place);
  if (distortion != "radtan" && distortion != "equidistant" && distortion != "none")
    throw Error("{}: ulf does not read the distortion model '{}'; it reads radtan, equidistant and none",
                place, distortion);
  if (distortion != "none" && coefficients.size() != 4)
    throw Error("{}: {} has 4 coefficients, not {}", place, distortion, coefficients.size());
  const std::vector<double> k = {intrinsics[0], 0, intrinsics[2], 0, intrinsics[1], intrinsics[3], 0, 0, 1};
  return FromOpenCvCoefficients(size[0], size[1], k, coefficients, distortion == "equidistant", place);
}

CameraModel ReadRos(const std::string& text, const std::string& where) {
  const YAML::Node top = LoadYaml(text, where);
  const auto k = Get<std::vector<double>>(top["camera_matrix"], "data", where + ", camera_matrix");
  if (k.size() != 9) throw Error("{}: the camera matrix has {} numbers, not 9", where, k.size());
  const auto model = Get<std::string>(top, "distortion_model", where);
  if (model != "plumb_bob" && model != "equidistant" && model != "rational_polynomial")
    throw Error(
        "{}: ulf does not read the distortion model '{}'; it reads plumb_bob, equidistant and "
        "rational_polynomial without k4 k5 k6",
        where, model);
  std::vector<double> d;
  if (top["distortion_coefficients"])
    d = Get<std::vector<double>>(top["distortion_coefficients"], "data", where);
  return FromOpenCvCoefficients(Get<int>(top, "image_width", where), Get<int>(top, "image_height", where), k,
                                d, model == "equidistant", where + ", " + model);
}

// OpenCV takes the memory that a matrix's rows and columns ask for before it looks whether its numbers are there, and
// takes a size that is no number for two billion.
cv::Mat SmallMatrix(const cv::FileNode& node, const std::string& where) {
  constexpr int kMostSide = 100;  // generous: there are nine numbers, or fourteen
  for (const char* side : {"rows", "cols"})
    if (!node.isMap() || !node[side].isInt() || static_cast<int>(node[side]) < 0 ||
        static_cast<int>(node[side]) > kMostSide)
      throw Error("{}: '{}' is no matrix with rows and columns", where, node.name());
  return node.mat();
}

// OpenCV's parsers go into brackets, tags, and YAML's indented keys and items by recursion.
bool IsNestedDeeply(const std::string& text) {
  constexpr int kMostLevels = 100;
  int levels = 0, levels_of_line = 0;
  bool is_indentation = true;
  for (std::size_t at = 0; at < text.size(); ++at) {
    const char c = text[at], next = at + 1 < text.size() ? text[at + 1] : ' ';
    const bool is_end_tag = c == '<' && next == '/', is_empty_tag = c == '/' && next == '>';
    const bool is_tag = c == '<' && std::isalpha(static_cast<unsigned char>(next)) != 0;
    const bool is_item = c == '-' && std::isspace(static_cast<unsigned char>(next)) != 0;
    if (c == '[' || c == '{' || is_tag) ++levels;
    if (c == ']' || c == '}' || is_end_tag || is_empty_tag) --levels;
    // Below its indentation stands what it belongs to, one column a level at least.
    is_indentation = c == '\n' || (is_indentation && c == ' ');
    if (c == '\n') levels_of_line = 0;
    if (c == ':' || is_item || (is_indentation && c == ' ')) ++levels_of_line;
    if (std::max(levels, levels_of_line) > kMostLevels) return true;
  }
  return false;
}

CameraModel ReadOpenCv(const std::string& text, const std::string& where) {
  if (IsNestedDeeply(text)) throw Error("{}: values are nested too deeply for a calibration", where);
  cv::Mat k, d;
  int width = 0, height = 0, fisheye = 0;
  try {
    const cv::FileStorage file(text, cv::FileStorage::READ | cv::FileStorage::MEMORY);
    for (const char* key : {"camera_matrix", "cameraMatrix", "K", "Camera_Matrix"})
      if (k.empty() && !file[key].empty()) k = SmallMatrix(file[key], where);
    for (const char* key : {"distortion_coefficients", "distCoeffs", "D", "Distortion_Coefficients"})
      if (d.empty() && !file[key].empty()) d = SmallMatrix(file[key], where);
    for (const char* key : {"image_width", "image_Width", "width"})
      if (!file[key].empty()) file[key] >> width;
    for (const char* key : {"image_height", "image_Height", "height"})
      if (!file[key].empty()) file[key] >> height;
    if (!file["fisheye_model"].empty()) file["fisheye_model"] >> fisheye;
  } catch (const cv::Exception& error) {
    throw Error("{}: OpenCV cannot read it: {}", where, error.err);
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {  // of the standard library, where numbers are too large
    throw Error("{}: OpenCV cannot read it: {}", where, error.what());
  }
  if (k.total() != 9) throw Error("{}: contains no 3x3 camera_matrix", where);
  k.convertTo(k, CV_64F);
  d.convertTo(d, CV_64F);
  const std::vector<double> matrix(k.begin<double>(), k.end<double>());
  std::vector<double> coefficients;
  if (!d.empty()) coefficients.assign(d.begin<double>(), d.end<double>());
  return FromOpenCvCoefficients(width, height, matrix, coefficients, fisheye != 0, where);
}

std::map<std::string, std::string> ColmapLines(const std::string& text) {
  std::map<std::string, std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string id;
    if (words >> id && id[0] != '#') lines[id] = line;
  }
  return lines;
}

CameraModel ReadColmap(const std::string& text, const std::string& where, const std::string& wanted) {
  const auto lines = ColmapLines(text);
  std::vector<std::string> ids;
  for (const auto& [id, line] : lines) ids.push_back(id);
  const std::string id = Pick(ids, wanted, where), place = where + ", camera " + id;
  std::istringstream row(lines.at(id));
  std::string number;
  row >> number;
  return ReadColmapCamera(row, place);
}

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

std::optional<CalibrationFormat> DetectCalibrationFormat(const std::string& text) {
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first == std::string::npos) return std::nullopt;
  if (text.compare(first, 5, "%YAML") == 0 || text.compare(first, 5, "<?xml") == 0 ||
      text.compare(first, 15, "<opencv_storage") == 0 || text.find("!!opencv-matrix") != std::string::npos)
    return CalibrationFormat::kOpenCv;
  if (text.find("camera_model:") != std::string::npos && text.find("intrinsics:") != std::string::npos)
    return CalibrationFormat::kKalibr;
  if (text.find("camera_matrix:") != std::string::npos) return CalibrationFormat::kRos;
  for (const auto& [id, line] : ColmapLines(text)) {
    std::istringstream words(line);
    std::string number, model;
    words >> number >> model;
    const bool is_model = model.size() > 2 && std::all_of(model.begin(), model.end(), [](char c) {
                            return (c >= 'A' && c <= 'Z') || c == '_' || (c >= '0' && c <= '9');
                          });
    if (is_model && model[0] >= 'A' && number.find_first_not_of("0123456789") == std::string::npos)
      return CalibrationFormat::kColmap;
    break;
  }
  return std::nullopt;
}

CameraModel ReadCalibrationText(CalibrationFormat format, const std::string& text, const std::string& where,
                                const std::string& camera) {
  try {
    switch (format) {
      case CalibrationFormat::kKalibr:
        return ReadKalibr(text, where, camera);
      case CalibrationFormat::kRos:
        return ReadRos(text, where);
      case CalibrationFormat::kOpenCv:
        return ReadOpenCv(text, where);
      default:
        return ReadColmap(text, where, camera);
    }
  } catch (const YAML::Exception& error) {
    throw Error("{}: its YAML has not the structure of a {} file: {}", where, Name(format), error.what());
  }
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
