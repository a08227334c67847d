#include "core/light_field/exchange/writers/unit_cube.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/base/quantile.h"

namespace ulf {
namespace {

// The subject's diameter in the unit cube. Guessed: silhouettes and shadows close by stay in the cube.
constexpr double kSubjectShare = 0.7;
// Quantiles for the middle of a place's points, and for all of its content. Guessed.
constexpr double kMiddleFrom = 0.1, kMiddleTo = 0.9, kContent = 0.95;
constexpr int kMostAabbScale = 128;  // instant-ngp's limit

std::optional<Subject> MiddleOfPoints(const LightField& light_field) {
  constexpr std::size_t kFewest = 10;
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

}  // namespace

Subject SubjectForExport(const LightField& light_field, const char* form) {
  if (light_field.subject) return *light_field.subject;
  if (const auto subject = SubjectFromAxes(light_field)) return *subject;
  throw Refusal(light_field.root.string(), "", "has no subject, and its optical axes do not meet",
                fmt::format("{} wants one in the middle: give {} x,y,z,radius", form, Parameter("subject")));
}

UnitCube UnitCubeOf(const LightField& light_field) {
  const auto middle = light_field.subject ? light_field.subject : MiddleOfPoints(light_field);
  const Subject subject = middle ? *middle : SubjectForExport(light_field, "instant-ngp");
  UnitCube cube;
  cube.scale = kSubjectShare / (2 * subject.radius);
  cube.offset = Eigen::Vector3d::Constant(0.5) - cube.scale * subject.center_in_world;
  if (light_field.turntable) return cube;
  const auto reach = [&](const Eigen::Vector3d& point) {  // in half unit cubes
    return 2 * cube.scale * (point - subject.center_in_world).cwiseAbs().maxCoeff();
  };
  std::vector<double> of_points;
  for (const ScenePoint& point : light_field.points) of_points.push_back(reach(point.position_in_world));
  double needed = Quantile(std::move(of_points), kContent);
  for (const View& view : light_field.views) needed = std::max(needed, reach(view.CenterInWorld()));
  while (cube.aabb_scale < needed && cube.aabb_scale < kMostAabbScale) cube.aabb_scale *= 2;
  return cube;
}

}  // namespace ulf
