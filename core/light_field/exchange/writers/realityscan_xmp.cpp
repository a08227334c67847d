#include "core/light_field/exchange/writers/set_writers.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.h"

namespace ulf {
namespace {

constexpr double kLargerSideOf35mm = 36;  // millimetres

}  // namespace

void RequireRealityScanLenses(const LightField& light_field) {
  for (std::size_t i = 0; i < light_field.cameras.size(); ++i)
    if (light_field.cameras[i].distortion == Distortion::kFisheye)
      throw Refusal(light_field.root.string(), "",
                    fmt::format("camera {} is a fisheye, which RealityScan's XMP files cannot say", i + 1),
                    "give " + Parameter("undistort"));
}

std::string RealityScanXmpText(const CameraModel& camera, int camera_group, const Rigid3& cam_from_world) {
  const double scale = std::max(camera.width, camera.height);
  const auto& c = camera.coefficients;
  const bool straight = camera.distortion == Distortion::kNone || c == std::array<double, 5>{};
  const bool tangential = !straight && (c[2] != 0 || c[3] != 0);
  std::string distortion = "0 0 0 0 0 0";
  if (!straight) distortion = fmt::format("{} {} {} 0 {} {}", c[0], c[1], c[4], c[3], c[2]);
  const Eigen::Matrix3d columns = cam_from_world.RotationMatrix().transpose();
  const Eigen::Vector3d center = cam_from_world.OriginInSource();
  return fmt::format(
      "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\">\n"
      "  <rdf:RDF xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\">\n"
      "    <rdf:Description xmlns:xcr=\"http://www.capturingreality.com/ns/xcr/1.1#\" xcr:Version=\"3\"\n"
      "       xcr:PosePrior=\"locked\" xcr:Coordinates=\"absolute\"\n"
      "       xcr:DistortionModel=\"{}\" xcr:FocalLength35mm=\"{}\" xcr:Skew=\"0\" xcr:AspectRatio=\"{}\"\n"
      "       xcr:PrincipalPointU=\"{}\" xcr:PrincipalPointV=\"{}\" xcr:CalibrationPrior=\"exact\"\n"
      "       xcr:CalibrationGroup=\"{}\" xcr:DistortionGroup=\"{}\" xcr:InTexturing=\"1\" "
      "xcr:InMeshing=\"1\">\n"
      "      <xcr:Rotation>{}</xcr:Rotation>\n"
      "      <xcr:Position>{} {} {}</xcr:Position>\n"
      "      <xcr:DistortionCoeficients>{}</xcr:DistortionCoeficients>\n"
      "    </rdf:Description>\n"
      "  </rdf:RDF>\n"
      "</x:xmpmeta>\n",
      straight     ? "perspective"
      : tangential ? "brown3t2"
                   : "brown3",
      camera.fx / scale * kLargerSideOf35mm, camera.fy / camera.fx, (camera.cx - 0.5 * camera.width) / scale,
      (camera.cy - 0.5 * camera.height) / scale, camera_group, camera_group,
      fmt::join(columns.data(), columns.data() + 9, " "), center.x(), center.y(), center.z(), distortion);
}

}  // namespace ulf
