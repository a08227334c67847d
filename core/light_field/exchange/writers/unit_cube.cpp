#include "core/light_field/exchange/writers/unit_cube.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/base/quantile.h"

namespace ulf {
namespace {

// The subject's diameter in the unit cube. Guessed: silhouettes and shadows close by stay in the cube.
constexpr double kSubjectShare = 0.7;
// The quantile for all of a place's content. Guessed.
constexpr double kContent = 0.95;
constexpr int kMostAabbScale = 128;  // instant-ngp's limit

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
