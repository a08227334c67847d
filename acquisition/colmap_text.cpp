#include "acquisition/colmap_text.h"

#include <fmt/format.h>

#include <iterator>

namespace ulf {
namespace {

std::string CameraLine(int id, const CameraModel& camera) {
  const auto& c = camera.coefficients;
  const std::string pinhole = fmt::format("{} {} {} {}", camera.fx, camera.fy, camera.cx, camera.cy);
  const auto line = [&](const char* model, const std::string& rest) {
    return fmt::format("{} {} {} {} {}{}\n", id, model, camera.width, camera.height, pinhole, rest);
  };
  switch (camera.distortion) {
    case Distortion::kFisheye:
      return line("OPENCV_FISHEYE", fmt::format(" {} {} {} {}", c[0], c[1], c[2], c[3]));
    case Distortion::kRadialTangential:
      if (c[4] != 0)
        return line("FULL_OPENCV", fmt::format(" {} {} {} {} {} 0 0 0", c[0], c[1], c[2], c[3], c[4]));
      return line("OPENCV", fmt::format(" {} {} {} {}", c[0], c[1], c[2], c[3]));
    case Distortion::kNone:
      break;
  }
  return line("PINHOLE", "");
}

std::string NameInImagesFolder(const std::string& image_path) {
  constexpr std::string_view kFolder = "images/";
  return image_path.starts_with(kFolder) ? image_path.substr(kFolder.size()) : image_path;
}

}  // namespace

ColmapText ToColmapText(const LightField& light_field) {
  ColmapText text;
  text.cameras = "# CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]\n";
  for (std::size_t i = 0; i < light_field.cameras.size(); ++i)
    text.cameras += CameraLine(static_cast<int>(i) + 1, light_field.cameras[i]);

  text.images = "# IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, then a line of POINTS2D[] (empty)\n";
  for (const View& view : light_field.views) {
    const Eigen::Quaterniond& q = view.cam_from_world.rotation;
    const Eigen::Vector3d& t = view.cam_from_world.translation;
    fmt::format_to(std::back_inserter(text.images), "{} {} {} {} {} {} {} {} {} {}\n\n", view.id, q.w(),
                   q.x(), q.y(), q.z(), t.x(), t.y(), t.z(), view.camera + 1,
                   NameInImagesFolder(view.image_path));
  }

  text.points3d = "# POINT3D_ID X Y Z R G B ERROR TRACK[]\n";
  for (std::size_t i = 0; i < light_field.points.size(); ++i) {
    const ScenePoint& point = light_field.points[i];
    fmt::format_to(std::back_inserter(text.points3d), "{} {} {} {} {} {} {} 0\n", i + 1,
                   point.position_in_world.x(), point.position_in_world.y(), point.position_in_world.z(),
                   point.rgb[0], point.rgb[1], point.rgb[2]);
  }
  return text;
}

}  // namespace ulf
