#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <optional>
#include <span>
#include <sstream>

#include "core/base/at.h"
#include "core/base/atomic_file.h"
#include "core/base/counted.h"
#include "core/base/error.h"
#include "core/image/files/picture_file.h"
#include "core/light_field/exchange/readers/named_views.h"
#include "core/light_field/exchange/readers/set_readers.h"
#include "core/light_field/formats/fitted_lens.h"
#include "core/light_field/formats/text_file.h"
#include "core/light_field/points/ply_reader.h"
#include "core/light_field/points/point_tracks.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr const char* kNvmBlanks = " \t\r";

struct NvmCamera {
  std::string name;
  int line = 0;
  double focal_px = 0;
  double r = 0;                          // radial distortion
  std::optional<Rigid3> cam_from_world;  // none: not registered
};

struct NvmObservation {
  int camera = 0;
  Vector2d from_center;
};

struct NvmPoint {
  ScenePoint point;
  std::vector<NvmObservation> seen;
};

struct NvmModel {
  std::vector<NvmCamera> cameras;
  std::vector<NvmPoint> points;
};

// The intrinsics of all cameras, if the title has them: f_x c_x f_y c_y r.
using NvmFixed = std::optional<std::array<double, 5>>;

// Reads the file line by line; empty lines and comments are passed over.
class NvmLines {
 public:
  explicit NvmLines(const fs::path& file) : name_(file.string()), stream_(OpenTextFile(file)) {}

  // Returns false at the end.
  bool Next() {
    while (std::getline(stream_, line_)) {
      ++number_;
      line_.erase(line_.find_last_not_of(kNvmBlanks) + 1);
      line_.erase(0, line_.find_first_not_of(kNvmBlanks));
      if (!line_.empty() && line_.front() != '#') return true;
    }
    line_.clear();
    return false;
  }

  // Goes to the next line, which must exist.
  void Require(const std::string& what) {
    if (!Next()) throw Error("{}: ends before {}; it is cut short: copy or export it again", name_, what);
  }

  // Returns the count of which the line consists.
  int Count(const std::string& what) const {
    double count = 0;
    constexpr double kMost = 1e9;
    if (!ParseNumber(line_, count) || !(count >= 0 && count <= kMost) || count != std::floor(count))
      throw Error("{}: expected the number of {}, found \"{:.60}\"", Where(), what, line_);
    return static_cast<int>(count);
  }

  const std::string& line() const { return line_; }
  int number() const { return number_; }
  std::string Where() const { return fmt::format("{}, line {}", name_, number_); }

 private:
  std::string name_, line_;
  std::ifstream stream_;
  int number_ = 0;
};

// Returns the last `count` words of the line as numbers, and what stands before them.
std::pair<std::string, std::vector<double>> NameAndNumbers(const NvmLines& lines, std::size_t count) {
  std::string rest = lines.line();
  std::vector<double> numbers(count);
  for (std::size_t i = count; i-- > 0;) {
    const std::size_t blank = rest.find_last_of(kNvmBlanks);
    if (blank == std::string::npos || !ParseNumber(std::string_view(rest).substr(blank + 1), numbers[i]) ||
        !std::isfinite(numbers[i]))
      throw Error("{}: expected the name of a photograph and {} numbers, found \"{:.80}\"", lines.Where(),
                  count, lines.line());
    rest.erase(rest.find_last_not_of(kNvmBlanks, blank) + 1);
  }
  if (rest.empty()) throw Error("{}: the name of the photograph is missing", lines.Where());
  return {rest, numbers};
}

NvmCamera ReadNvmCamera(const NvmLines& lines, bool has_matrices) {
  const std::size_t of_rotation = has_matrices ? 9 : 4;
  const auto [name, numbers] = NameAndNumbers(lines, of_rotation + 6);
  NvmCamera camera{name, lines.number(), numbers[0], numbers[of_rotation + 4], std::nullopt};
  const Vector3d place(numbers[of_rotation + 1], numbers[of_rotation + 2], numbers[of_rotation + 3]);
  const auto rotation = std::span(numbers).subspan(1, of_rotation);
  if (!(camera.focal_px > 0) || std::ranges::all_of(rotation, [](double value) { return value == 0; }))
    return camera;
  Rigid3 cam_from_world;
  if (has_matrices) {
    cam_from_world.rotation =
        NearestRotation(Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rotation.data()),
                        lines.Where(), "the rotation");
    cam_from_world.translation = place;
  } else {
    const Eigen::Quaterniond turn(rotation[0], rotation[1], rotation[2], rotation[3]);
    constexpr double kTolerance = 1e-2;  // many writers print few digits
    if (!(std::abs(turn.norm() - 1) < kTolerance))
      throw Error("{}: the quaternion has the length {:.4g}, not 1; export the set again", lines.Where(),
                  turn.norm());
    cam_from_world.rotation = turn.normalized();
    cam_from_world.translation = -(cam_from_world.rotation * place);
  }
  camera.cam_from_world = cam_from_world;
  return camera;
}

NvmPoint ReadNvmPoint(const NvmLines& lines, std::size_t cameras) {
  std::istringstream words(lines.line());
  const auto next = [&](bool is_position = false) {
    std::string word;
    double value = 0;
    if (!(words >> word) || !ParseNumber(word, value) || (!is_position && !std::isfinite(value)))
      throw Error("{}: expected a point: x y z, its colour and its measurements", lines.Where());
    return value;
  };
  NvmPoint read;
  for (double& value : read.point.position_in_world) value = next(true);
  for (std::uint8_t& channel : read.point.rgb)
    channel = static_cast<std::uint8_t>(std::lround(std::clamp(next(), 0.0, 255.0)));
  const double seen = next();
  for (int i = 0; i < seen; ++i) {
    const double camera = next();
    next();  // the number of the feature
    const double x = next(), y = next();
    if (!(camera >= 0 && camera < static_cast<double>(cameras)) || camera != std::floor(camera))
      throw Error("{}: the point is seen by camera {}, and there are {}, counted from 0", lines.Where(),
                  camera, cameras);
    read.seen.push_back({static_cast<int>(camera), {x, y}});
  }
  return read;
}

// Reads a model after the line with its number of cameras.
NvmModel ReadNvmModel(NvmLines& lines, int cameras, bool has_matrices) {
  NvmModel model;
  for (int i = 0; i < cameras; ++i) {
    lines.Require(fmt::format("camera {} of {}", i + 1, cameras));
    model.cameras.push_back(ReadNvmCamera(lines, has_matrices));
  }
  if (!lines.Next()) return model;  // Some writers leave the points out.
  const int points = lines.Count("points");
  for (int i = 0; i < points; ++i) {
    lines.Require(fmt::format("point {} of {}", i + 1, points));
    model.points.push_back(ReadNvmPoint(lines, model.cameras.size()));
  }
  return model;
}

std::size_t RegisteredIn(const NvmModel& model) {
  return static_cast<std::size_t>(std::ranges::count_if(
      model.cameras, [](const NvmCamera& camera) { return camera.cam_from_world.has_value(); }));
}

struct NvmFile {
  NvmModel model;  // the largest
  NvmFixed fixed;
};

NvmFile ReadNvm(const fs::path& file, std::vector<std::string>& doubts) {
  NvmLines lines(file);
  lines.Require("its title");
  std::istringstream title(lines.line());
  std::string version, key;
  title >> version >> key;
  if (version != "NVM_V3" && version != "NVM_V3_R9T")
    throw Error("{}: begins with \"{:.20}\" and not with NVM_V3; other versions are not read", file.string(),
                lines.line());
  NvmFile read;
  if (key == "FixedK" || key == "FixedK:") {
    std::array<double, 5> numbers{};
    for (double& number : numbers)
      if (!(title >> number)) throw Error("{}: FixedK needs five numbers: f_x c_x f_y c_y r", lines.Where());
    read.fixed = numbers;
  }
  std::vector<std::size_t> registered;
  while (lines.Next()) {
    const int cameras = lines.Count("cameras");
    if (cameras == 0) break;  // The files of dense points follow.
    NvmModel model = ReadNvmModel(lines, cameras, version != "NVM_V3");
    registered.push_back(RegisteredIn(model));
    if (registered.size() == 1 || registered.back() > RegisteredIn(read.model)) read.model = std::move(model);
  }
  if (registered.empty() || RegisteredIn(read.model) == 0)
    throw Error("{}: holds no model with registered cameras; run the reconstruction and save it again",
                file.string());
  std::erase(registered, std::size_t{0});  // the photographs without a pose
  if (registered.size() > 1)
    doubts.push_back(fmt::format("of {} the largest is read, with {}", Counted(registered.size(), "model"),
                                 Counted(RegisteredIn(read.model), "camera")));
  return read;
}

// Throws an Error if a measurement lies outside its photograph, which was resized then: the file says no
// sizes.
void RequireInPhotograph(const NvmObservation& seen, const CameraModel& camera, const std::string& where) {
  constexpr double kRounding_px = 2;
  if (std::abs(seen.from_center.x()) > 0.5 * camera.width + kRounding_px ||
      std::abs(seen.from_center.y()) > 0.5 * camera.height + kRounding_px)
    throw Error(
        "{}: a point was measured ({:.6g}, {:.6g}) px from the middle of a photograph of {}x{}: it was "
        "resized or "
        "cropped since; take the photographs that were measured",
        where, seen.from_center.x(), seen.from_center.y(), camera.width, camera.height);
}

// Returns the lens whose distorted points (in units of the focal length) are p with p (1 + r |p|²) = (x, y).
CameraModel ModelOfNvmCamera(const NvmCamera& camera, const NvmFixed& fixed, const fs::path& image,
                             const std::string& where, FittedLenses& fitted) {
  const cv::Size size = ReadImageSize(image.string());
  CameraModel model = CameraModel::Pinhole(size.width, size.height, camera.focal_px);
  double r = camera.r;
  if (fixed) {
    model.fx = (*fixed)[0];
    model.cx = (*fixed)[1];
    model.fy = (*fixed)[2];
    model.cy = (*fixed)[3];
    if ((*fixed)[4] != 0) r = (*fixed)[4];
  }
  model.Validate(where);
  RequireMeasuredSize(model, where);
  if (r == 0) return model;
  const CameraModel pinhole = model;
  const Projection project = [&](const Vector3d& point_in_cam) -> std::optional<Vector2d> {
    if (!(point_in_cam.z() > 0)) return std::nullopt;
    const Vector2d straight = point_in_cam.head<2>() / point_in_cam.z();
    const double radius = straight.norm();
    double distorted = radius;
    double step = 1;
    for (int i = 0; i < 50 && std::abs(step) > 1e-12 * (1 + radius); ++i) {  // Newton's method
      const double square = distorted * distorted, slope = 1 + 3 * r * square;
      if (!(slope > 0)) return std::nullopt;
      step = (distorted * (1 + r * square) - radius) / slope;
      distorted -= step;
    }
    if (!(std::abs(step) <= 1e-12 * (1 + radius))) return std::nullopt;
    const Vector2d p = radius > 0 ? Vector2d(straight * (distorted / radius)) : straight;
    return Vector2d(pinhole.fx * p.x() + pinhole.cx, pinhole.fy * p.y() + pinhole.cy);
  };
  model.distortion = Distortion::kRadialTangential;
  model.coefficients[0] = -r;
  return fitted.Take(project, model, "VisualSFM's radial distortion", where,
                     "export the undistorted photographs with their model (VisualSFM: Tools > CMVS)");
}

}  // namespace

PosedSet ReadVisualSfmSet(const fs::path& file, const fs::path& chosen) {
  PosedSet set;
  set.format = "VisualSFM";
  LightField& light_field = set.light_field;
  const NvmFile read = ReadNvm(file, light_field.doubts);
  const std::vector<NvmCamera>& cameras = read.model.cameras;
  std::vector<std::string> names;
  for (const NvmCamera& camera : cameras) {
    std::string& name = names.emplace_back(camera.name);
    std::ranges::replace(name, '"', ' ');  // how VisualSFM writes a space in a name; others quote it
    name.erase(name.find_last_not_of(' ') + 1);
    name.erase(0, name.find_first_not_of(' '));
  }
  const fs::path base = fs::absolute(file).lexically_normal().parent_path();
  SetImages images(base, chosen, FoldersOfNames(base, names));
  images.Reserve(names);

  NamedViews named(file, images, set);
  FittedLenses fitted;
  std::vector<int> view_ids(cameras.size(), 0);
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    if (!cameras[i].cam_from_world) continue;
    const std::string where = fmt::format("{}, line {} ({})", file.string(), cameras[i].line, names[i]);
    const std::string path = named.Find(names[i], where);
    if (path.empty()) continue;
    const CameraModel model = ModelOfNvmCamera(cameras[i], read.fixed, images.folder() / path, where, fitted);
    view_ids[i] = named.Add(path, model, *cameras[i].cam_from_world, where);
  }
  named.RequireFound();
  fitted.Note(light_field.doubts);
  NoteUnposed(cameras.size() - RegisteredIn(read.model), "camera", "not registered", set);
  std::size_t nowhere = 0;
  for (const NvmPoint& from : read.model.points) {
    ScenePoint point = from.point;
    if (!point.position_in_world.allFinite()) {
      ++nowhere;
      continue;
    }
    for (const NvmObservation& seen : from.seen) {
      const int view_id = view_ids[At(seen.camera)];
      if (view_id == 0) continue;
      const CameraModel& camera = light_field.CameraOf(light_field.views[At(view_id - 1)]);
      RequireInPhotograph(seen, camera, fmt::format("{} ({})", file.string(), names[At(seen.camera)]));
      AddObservation(view_id, {camera.cx + seen.from_center.x(), camera.cy + seen.from_center.y()}, point);
    }
    light_field.points.push_back(std::move(point));
  }
  NotePointsNowhere(nowhere, light_field);
  light_field.misplaced_observations = MeasurePoints(light_field);
  if (std::ranges::all_of(light_field.points, [](const ScenePoint& point) { return point.track.empty(); }))
    light_field.doubts.push_back(fmt::format(
        "{}: focal lengths are in pixels of photographs whose size it does not say: they are taken to "
        "have been as large as those in {}",
        file.string(), images.folder().string()));
  return set;
}

}  // namespace ulf
