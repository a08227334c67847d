#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <optional>
#include <sstream>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/light_field/exchange/readers/set_readers.h"
#include "core/light_field/exchange/readers/timed_views.h"
#include "core/light_field/formats/text_file.h"
#include "core/light_field/points/ply_reader.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

constexpr double kSecondsOfNs = 1e-9;

// The values of a sensor.yaml, by the beginnings of its lines: the files have no other nesting than T_BS.
class SensorYaml {
 public:
  explicit SensorYaml(const fs::path& file) : file_(file.string()), text_(ReadWholeFile(file)) {}

  // Returns what stands behind the key in its line, without a comment; "" if the key is missing.
  std::string Text(const std::string& key) const {
    const std::size_t begin = After(key);
    if (begin == std::string::npos) return {};
    std::string value = text_.substr(begin, text_.find_first_of("#\r\n", begin) - begin);
    value.erase(value.find_last_not_of(" \t\"'") + 1);
    value.erase(0, value.find_first_not_of(" \t\"'"));
    return value;
  }

  // Returns the list of this key, also over several lines.
  std::vector<double> Numbers(const std::string& key, std::size_t count) const {
    std::size_t begin = After(key);
    if (key == "T_BS" && begin != std::string::npos) begin = text_.find("data:", begin);
    const std::size_t open = begin == std::string::npos ? begin : text_.find('[', begin);
    const std::size_t close = open == std::string::npos ? open : text_.find(']', open);
    if (close == std::string::npos) throw Error("{}: '{}' with {} numbers is missing", file_, key, count);
    std::string list = text_.substr(open + 1, close - open - 1);
    std::ranges::replace(list, ',', ' ');
    std::istringstream words(list);
    std::vector<double> numbers;
    for (std::string word; words >> word;) {
      double& number = numbers.emplace_back();
      if (!ParseNumber(word, number) || !std::isfinite(number))
        throw Error("{}: '{}' holds '{:.40}', which is not a finite number", file_, key, word);
    }
    if (numbers.size() != count)
      throw Error("{}: '{}' must have {} numbers, not {}", file_, key, count, numbers.size());
    return numbers;
  }

  // Returns the sensor's pose in the body: x_body = T x_sensor.
  Rigid3 BodyFromSensor() const {
    const std::vector<double> rows = Numbers("T_BS", 16);
    const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> matrix(rows.data());
    return {NearestRotation(matrix.topLeftCorner<3, 3>(), file_, "T_BS"), matrix.topRightCorner<3, 1>()};
  }

  const std::string& file() const { return file_; }

 private:
  std::size_t After(const std::string& key) const {
    for (std::size_t line = 0; line < text_.size();) {
      const std::size_t begin = text_.find_first_not_of(" \t", line);
      if (begin != std::string::npos && text_.compare(begin, key.size() + 1, key + ":") == 0)
        return begin + key.size() + 1;
      const std::size_t end = text_.find('\n', line);
      if (end == std::string::npos) break;
      line = end + 1;
    }
    return std::string::npos;
  }

  std::string file_, text_;
};

CameraModel CameraOfSensor(const SensorYaml& sensor) {
  const auto refuse = [&](const char* key, const std::string& value) {
    throw Error(
        "{}: {} is '{}'; pinhole cameras with the distortion radial-tangential or equidistant are read: "
        "calibrate the camera again with one of these",
        sensor.file(), key, value);
  };
  if (const std::string model = sensor.Text("camera_model"); model != "pinhole")
    refuse("camera_model", model);
  const std::vector<double> size = sensor.Numbers("resolution", 2), k = sensor.Numbers("intrinsics", 4);
  constexpr double kMostSide = 1 << 20;
  if (!(size[0] >= 1 && size[1] >= 1 && size[0] <= kMostSide && size[1] <= kMostSide))
    throw Error("{}: 'resolution' is {} x {}", sensor.file(), size[0], size[1]);
  CameraModel camera =
      CameraModel::FromOpenCv(static_cast<int>(size[0]), static_cast<int>(size[1]), k[0], k[1], k[2], k[3]);
  const std::string distortion = sensor.Text("distortion_model");
  if (distortion != "none" && !distortion.empty()) {
    const std::vector<double> d = sensor.Numbers("distortion_coefficients", 4);
    camera.coefficients = {d[0], d[1], d[2], d[3], 0};
    if (distortion == "equidistant")
      camera.distortion = Distortion::kFisheye;
    else if (distortion == "radial-tangential" || distortion == "radtan")
      camera.distortion = Distortion::kRadialTangential;
    else
      refuse("distortion_model", distortion);
  }
  camera.Validate(sensor.file());
  return camera;
}

// Calls `use` with the fields of each row that is not a comment, and its number.
template <typename Use>
void ForEachCsvRow(const fs::path& csv, const Use& use) {
  std::ifstream stream = OpenTextFile(csv);
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    line.erase(line.find_last_not_of(" \t\r") + 1);
    if (line.empty() || line.front() == '#') continue;
    std::vector<std::string> fields;
    std::istringstream row(line);
    for (std::string field; std::getline(row, field, ',');) {
      field.erase(0, field.find_first_not_of(" \t"));
      field.erase(field.find_last_not_of(" \t") + 1);
      fields.push_back(field);
    }
    use(fields, number);
  }
}

std::vector<TimedPhotograph> PhotographsOfSensor(const fs::path& csv) {
  std::vector<TimedPhotograph> photographs;
  ForEachCsvRow(csv, [&](const std::vector<std::string>& fields, int line) {
    double time_ns = 0;
    if (fields.size() < 2 || !ParseNumber(fields[0], time_ns) || !std::isfinite(time_ns) || fields[1].empty())
      throw Error("{}, line {}: expected `timestamp [ns],filename`", csv.string(), line);
    photographs.push_back({time_ns * kSecondsOfNs, fields[1], line});
  });
  if (photographs.empty()) throw Error("{}: names no photograph; download the sequence again", csv.string());
  return photographs;
}

// Returns the poses of the camera. `body_from_cam` and `body_from_sensor` say where camera and sensor are.
std::vector<TimedPose> PosesOfSensor(const fs::path& csv, const Rigid3& body_from_sensor,
                                     const Rigid3& body_from_cam) {
  const Rigid3 cam_from_sensor = body_from_cam.Inverse() * body_from_sensor;
  std::vector<TimedPose> poses;
  ForEachCsvRow(csv, [&](const std::vector<std::string>& fields, int line) {
    std::array<double, 8> n{};
    bool is_pose = fields.size() >= n.size();
    for (std::size_t i = 0; is_pose && i < n.size(); ++i)
      is_pose = ParseNumber(fields[i], n[i]) && std::isfinite(n[i]);
    const Eigen::Quaterniond rotation(n[4], n[5], n[6], n[7]);
    if (!is_pose || !(std::abs(rotation.norm() - 1) < 1e-2))
      throw Error("{}, line {}: expected a pose, `timestamp [ns], x, y, z, q_w, q_x, q_y, q_z`", csv.string(),
                  line);
    const Rigid3 world_from_sensor{rotation.normalized(), {n[1], n[2], n[3]}};
    poses.push_back({n[0] * kSecondsOfNs, cam_from_sensor * world_from_sensor.Inverse()});
  });
  if (poses.empty()) throw Error("{}: holds no pose; download the sequence again", csv.string());
  return poses;
}

}  // namespace

PosedSet ReadEurocSet(const fs::path& mav0, const fs::path& chosen) {
  std::error_code unknown;
  fs::path truth = mav0 / "state_groundtruth_estimate0";
  if (!fs::is_regular_file(truth / "data.csv", unknown)) truth = mav0 / "mocap0";
  if (!fs::is_regular_file(truth / "data.csv", unknown))
    throw Error(
        "{}: has neither state_groundtruth_estimate0/data.csv nor mocap0/data.csv, the poses; put one there, "
        "or "
        "record the sequence without them ('ulf capture replay:{} -o DIR')",
        mav0.string(), (mav0 / "cam0" / "data").string());
  const fs::path camera = mav0 / "cam0";
  const SensorYaml sensor(camera / "sensor.yaml");
  const Rigid3 body_from_sensor = fs::is_regular_file(truth / "sensor.yaml", unknown)
                                      ? SensorYaml(truth / "sensor.yaml").BodyFromSensor()
                                      : Rigid3();
  const SetImages images(camera, chosen, {"data", "."});
  PosedSet set;
  set.format = "EuRoC MAV";
  set.light_field.units = "metres";
  AddTimedViews(PhotographsOfSensor(camera / "data.csv"),
                PosesOfSensor(truth / "data.csv", body_from_sensor, sensor.BodyFromSensor()),
                camera / "data.csv", truth / "data.csv", images, CameraOfSensor(sensor), set);
  if (fs::is_directory(mav0 / "cam1", unknown))
    set.light_field.doubts.push_back("cam1: the photographs of the second camera are not used");
  return set;
}

}  // namespace ulf
