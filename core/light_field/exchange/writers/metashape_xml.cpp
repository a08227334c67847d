#include "core/light_field/exchange/writers/set_writers.h"

#include <fmt/format.h>

#include <filesystem>
#include <iterator>

#include "core/light_field/formats/xml_file.h"

namespace ulf {
namespace {

// Values of zero are omitted.
void AppendValue(std::string& text, const char* name, double value) {
  if (value != 0) fmt::format_to(std::back_inserter(text), "          <{0}>{1}</{0}>\n", name, value);
}

std::string SensorText(const CameraModel& camera, std::size_t id) {
  const bool fisheye = camera.distortion == Distortion::kFisheye;
  const char* type = fisheye ? "fisheye" : "frame";
  const std::string size =
      fmt::format("<resolution width=\"{}\" height=\"{}\"/>", camera.width, camera.height);
  std::string text = fmt::format(
      "      <sensor id=\"{0}\" label=\"camera {1}\" type=\"{2}\">\n"
      "        {3}\n"
      "        <calibration type=\"{2}\" class=\"adjusted\">\n"
      "          {3}\n",
      id, id + 1, type, size);
  AppendValue(text, "f", camera.fy);
  AppendValue(text, "cx", camera.cx - 0.5 * camera.width);
  AppendValue(text, "cy", camera.cy - 0.5 * camera.height);
  AppendValue(text, "b1", camera.fx - camera.fy);
  const auto& c = camera.coefficients;
  if (fisheye) {
    const char* const names[] = {"k1", "k2", "k3", "k4"};
    for (std::size_t i = 0; i < std::size(names); ++i) AppendValue(text, names[i], c[i]);
  } else if (camera.distortion == Distortion::kRadialTangential) {
    AppendValue(text, "k1", c[0]);
    AppendValue(text, "k2", c[1]);
    AppendValue(text, "k3", c[4]);
    AppendValue(text, "p1", c[3]);
    AppendValue(text, "p2", c[2]);
  }
  return text + "        </calibration>\n      </sensor>\n";
}

std::string CameraText(const View& view, std::size_t id) {
  const Eigen::Matrix4d columns = view.cam_from_world.Inverse().Matrix().transpose();
  return fmt::format(
      "      <camera id=\"{}\" sensor_id=\"{}\" component_id=\"0\" label=\"{}\">\n"
      "        <transform>{}</transform>\n"
      "        <orientation>1</orientation>\n"
      "      </camera>\n",
      id, view.camera, XmlEscaped(std::filesystem::path(view.image_path).stem().string()),
      fmt::join(columns.data(), columns.data() + 16, " "));
}

}  // namespace

std::string MetashapeXmlText(const LightField& exported) {
  std::string sensors, cameras, numbers;
  for (std::size_t i = 0; i < exported.cameras.size(); ++i) sensors += SensorText(exported.cameras[i], i);
  for (std::size_t i = 0; i < exported.views.size(); ++i) {
    cameras += CameraText(exported.views[i], i);
    numbers += fmt::format("{}{}", i == 0 ? "" : " ", i);
  }
  // A scale tells Metashape that lengths are known; `units` tells ulf what they are.
  const bool is_metric = exported.units == "metres";
  const char* transform = is_metric ? "        <transform>\n"
                                      "          <rotation>1 0 0 0 1 0 0 0 1</rotation>\n"
                                      "          <translation>0 0 0</translation>\n"
                                      "          <scale>1</scale>\n"
                                      "        </transform>\n"
                                    : "";
  const char* units =
      is_metric ? "    <meta>\n      <property name=\"ulf/units\" value=\"metres\"/>\n    </meta>\n" : "";
  return fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<document version=\"2.0.0\">\n"
      "  <chunk label=\"ulf\" enabled=\"true\">\n"
      "    <sensors next_id=\"{}\">\n{}    </sensors>\n"
      "    <components next_id=\"1\" active_id=\"0\">\n"
      "      <component id=\"0\" label=\"Component 1\">\n{}"
      "        <partition>\n          <camera_ids>{}</camera_ids>\n        </partition>\n"
      "      </component>\n"
      "    </components>\n"
      "    <cameras next_id=\"{}\" next_group_id=\"0\">\n{}    </cameras>\n{}"
      "  </chunk>\n"
      "</document>\n",
      exported.cameras.size(), sensors, transform, numbers, exported.views.size(), cameras, units);
}

}  // namespace ulf
