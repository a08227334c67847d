#include "core/light_field/exchange/readers/metashape_sensor.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "core/base/error.h"

namespace ulf {
namespace {

constexpr int kMostSensorSide_px = 1 << 20;
constexpr const char* kOptimiseWithout =
    "optimise the cameras without it (Tools > Optimize Cameras), or export undistorted photographs with "
    "their cameras";

// Returns the adjusted calibration, or the only other one.
std::optional<XmlElement> CalibrationOf(const XmlElement& sensor) {
  const std::vector<XmlElement> all = sensor.Children("calibration");
  for (const XmlElement& calibration : all)
    if (calibration.Attribute("class") == "adjusted") return calibration;
  return all.empty() ? std::nullopt : std::optional(all.front());
}

}  // namespace

std::string LabelOf(const XmlElement& element) {
  const std::string label = element.Attribute("label").value_or("");
  return label.empty() ? "without a label" : "'" + label + "'";
}

CameraModel ModelOfSensor(const XmlElement& sensor, FittedLenses& fitted) {
  const std::string where = sensor.Where() + " " + LabelOf(sensor);
  const auto calibration = CalibrationOf(sensor);
  if (!calibration)
    throw Error("{}: has no <calibration>, and cameras with a pose use it; align them and export again",
                where);
  const std::string type =
      calibration->Attribute("type").value_or(sensor.Attribute("type").value_or("frame"));
  if (type != "frame" && type != "fisheye")
    throw Error(
        "{}: a sensor of type '{}' is not supported, only 'frame' and 'fisheye' are; convert the photographs "
        "to a frame camera's, or leave them out",
        where, type);
  const auto value = [&](const char* name) {
    const auto element = calibration->Find(name);
    return element ? element->Number() : 0;
  };
  const bool fisheye = type == "fisheye";
  if (!calibration->Find("f"))
    throw Error(
        "{}: its calibration has no <f>: an older PhotoScan wrote it; open the project in Metashape "
        "and export the cameras again",
        where);

  const auto own_size = calibration->Find("resolution");
  const XmlElement size = own_size ? *own_size : sensor.Child("resolution");
  CameraModel model;
  model.width = size.IntegerAttribute("width", 1, kMostSensorSide_px);
  model.height = size.IntegerAttribute("height", 1, kMostSensorSide_px);
  model.fy = value("f");
  model.fx = model.fy + value("b1");
  model.cx = 0.5 * model.width + value("cx");
  model.cy = 0.5 * model.height + value("cy");
  const double k1 = value("k1"), k2 = value("k2"), k3 = value("k3"), k4 = value("k4");
  if (fisheye) {
    model.distortion = Distortion::kFisheye;
    model.coefficients = {k1, k2, k3, k4, 0};
  } else {
    model.coefficients = {k1, k2, value("p2"), value("p1"), k3};
    if (model.coefficients != std::array<double, 5>{}) model.distortion = Distortion::kRadialTangential;
  }
  model.Validate(where);
  std::vector<std::string> others;  // terms that our model lacks
  for (const char* name : {"b2", "p3", "p4", fisheye ? "p1" : "k4", fisheye ? "p2" : "k4"})
    if (value(name) != 0 && (others.empty() || others.back() != name)) others.emplace_back(name);
  if (others.empty()) return model;
  const double p1 = value("p1"), p2 = value("p2"), p3 = value("p3"), p4 = value("p4");
  const auto project = [&](const Eigen::Vector3d& in_cam) -> std::optional<Eigen::Vector2d> {
    if (!fisheye && in_cam.z() <= 0) return std::nullopt;
    const double rho = in_cam.head<2>().norm();
    const double angle = std::atan2(rho, in_cam.z());
    const Eigen::Vector2d p = rho == 0  ? Eigen::Vector2d(0, 0)
                              : fisheye ? Eigen::Vector2d(angle / rho * in_cam.head<2>())
                                        : Eigen::Vector2d(in_cam.head<2>() / in_cam.z());
    const double r2 = p.squaredNorm(), radial = 1 + r2 * (k1 + r2 * (k2 + r2 * (k3 + r2 * k4)));
    const double tangential = 1 + r2 * (p3 + r2 * p4);
    const double x = p.x() * radial + (p1 * (r2 + 2 * p.x() * p.x()) + 2 * p2 * p.x() * p.y()) * tangential;
    const double y = p.y() * radial + (p2 * (r2 + 2 * p.y() * p.y()) + 2 * p1 * p.x() * p.y()) * tangential;
    return Eigen::Vector2d(model.cx + model.fx * x + value("b2") * y, model.cy + model.fy * y);
  };
  if (model.distortion == Distortion::kNone) model.distortion = Distortion::kRadialTangential;
  CameraModel taken = fitted.Take(
      project, model, fmt::format("a {} lens of Metashape with {}", type, fmt::join(others, ", ")), where,
      kOptimiseWithout);
  if (taken.coefficients == std::array<double, 5>{} && !fisheye) taken.distortion = Distortion::kNone;
  return taken;
}

}  // namespace ulf
