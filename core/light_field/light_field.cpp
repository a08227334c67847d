#include "core/light_field/light_field.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/quantile.h"
#include "core/geometry/digest.h"
#include "core/geometry/small_matrices.h"
#include "core/geometry/up_direction.h"

namespace ulf {

Subject ParseSubject(const std::string& text) {
  Subject subject;
  int used = 0;
  if (std::sscanf(text.c_str(), "%lf,%lf,%lf,%lf%n", &subject.center_in_world.x(),
                  &subject.center_in_world.y(), &subject.center_in_world.z(), &subject.radius, &used) != 4 ||
      static_cast<std::size_t>(used) != text.size() || !subject.center_in_world.allFinite() ||
      !std::isfinite(subject.radius))
    throw Refusal("", text, fmt::format("'{}' is not a subject", text),
                  "write x,y,z,radius in world units, such as 0,0,-8.12,1.5");
  if (!(subject.radius > 0))
    throw Refusal(
        "", text,
        fmt::format("'{}' is not a subject: its radius, the last of x,y,z,radius, must be positive", text),
        "");
  return subject;
}

int LightField::AddCamera(const NewCamera& camera) {
  const int index = static_cast<int>(cameras.size());
  cameras.push_back(camera.camera);
  if (camera.flat_field) flat_fields[index] = *camera.flat_field;
  if (camera.color_profile) color_profiles[index] = *camera.color_profile;
  if (!camera.calibration_source.empty()) calibration_sources[index] = camera.calibration_source;
  return index;
}

std::string LightField::CalibrationSource(int camera) const {
  const auto found = calibration_sources.find(camera);
  return found == calibration_sources.end() ? std::string() : found->second;
}

const View* LightField::FindView(int id) const {
  const auto found = std::ranges::lower_bound(views, id, {}, &View::id);
  return found != views.end() && found->id == id ? &*found : nullptr;
}

std::uint64_t LightField::PoseDigest(const View& view) const {
  Digest digest;
  digest.Add(view.cam_from_world);
  digest.Add(CameraOf(view));
  return digest.Value();
}

Eigen::Vector3d LightField::UpInWorld() const {
  if (up_in_world) return *up_in_world;
  std::vector<Eigen::Matrix3d> rotations;
  for (const View& view : views) rotations.push_back(view.cam_from_world.RotationMatrix());
  return UpOfCameras(rotations);
}

std::optional<Eigen::Vector3d> ConvergenceOfAxes(const LightField& light_field) {
  if (light_field.views.size() < 2) return std::nullopt;
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right_side = Eigen::Vector3d::Zero();
  for (const View& view : light_field.views) {
    const Eigen::Vector3d axis = view.cam_from_world.DirectionInSource(Eigen::Vector3d::UnitZ());
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - axis * axis.transpose();
    normal += across;
    right_side += across * view.CenterInWorld();
  }
  const Eigenvalues3 solver = EigenvaluesOf(normal);
  // Axes within about six degrees of each other determine the distance along them too poorly. Guessed.
  constexpr double kMinMeanSquaredSine = 0.01;
  if (solver.values(0) < kMinMeanSquaredSine * static_cast<double>(light_field.views.size()))
    return std::nullopt;
  return SolveNormal(normal, right_side);
}

std::optional<Subject> SubjectFromAxes(const LightField& light_field) {
  const auto meeting = ConvergenceOfAxes(light_field);
  if (!meeting) return std::nullopt;
  const Eigen::Vector3d& center = *meeting;
  std::vector<double> distances, half_angles;
  std::size_t views_of_center = 0;
  for (const View& view : light_field.views) {
    const Eigen::Vector3d center_in_cam = view.cam_from_world * center;
    if (center_in_cam.z() <= 0) return std::nullopt;
    distances.push_back(center_in_cam.norm());
    const CameraModel& camera = light_field.CameraOf(view);
    const auto img = camera.ImgFromCam(center_in_cam);
    views_of_center += img && camera.Contains(*img);
    half_angles.push_back(std::atan(0.5 * kSubjectSize * camera.width / camera.fx));
  }
  if (2 * views_of_center <= light_field.views.size()) return std::nullopt;  // a walk past many things
  return Subject{center, Median(distances) * std::sin(Median(half_angles))};
}

std::optional<Subject> MiddleOfPoints(const LightField& light_field) {
  constexpr std::size_t kFewest = 10;
  constexpr double kMiddleFrom = 0.1, kMiddleTo = 0.9;  // quantiles. Guessed.
  if (light_field.points.size() < kFewest) return std::nullopt;
  Eigen::Vector3d low, high;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const ScenePoint& point : light_field.points) values.push_back(point.position_in_world[axis]);
    low[axis] = Quantile(values, kMiddleFrom);
    high[axis] = Quantile(std::move(values), kMiddleTo);
  }
  const double radius = 0.5 * (high - low).maxCoeff();
  if (!(radius > 0)) return std::nullopt;
  return Subject{0.5 * (low + high), radius};
}

void PlaceSubject(const Subject& subject, LightField& light_field) {
  constexpr double kSame = 0.05;  // of the radius; corrected maps move a subject by less. Guessed.
  const std::optional<Subject> before = std::exchange(light_field.subject, subject);
  if (before && ((subject.center_in_world - before->center_in_world).norm() > kSame * before->radius ||
                 std::abs(subject.radius - before->radius) > kSame * before->radius))
    light_field.measured.reset();
}

std::string ExposureName(int view_id, std::size_t number) {
  return fmt::format("{}/{:06}-{}", kExposuresFolder, view_id, number);
}

std::string MergedPath(int view_id) { return fmt::format("{}/{:06}.exr", kMergedFolder, view_id); }

std::set<std::string> FilesOf(const View& view) {
  std::set<std::string> files{view.image_path, view.master_path};
  for (const ViewExposure& exposure : view.exposures)
    files.insert({exposure.image_path, exposure.master_path});
  if (view.merged) files.insert(view.merged->path);
  files.erase("");
  return files;
}

View PhotographOf(const View& view, const ViewExposure& exposure) {
  View photograph = view;
  static_cast<StoredExposure&>(photograph) = exposure;
  photograph.cam_from_world = exposure.exposure_from_view * view.cam_from_world;
  photograph.exposures.clear();
  photograph.merged.reset();
  return photograph;
}

}  // namespace ulf
