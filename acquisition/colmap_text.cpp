#include "acquisition/colmap_text.h"

#include <fmt/format.h>

#include <iterator>

namespace ulf {
namespace {

void AppendPoints(const std::vector<ColmapReconstruction::Point2d>& points, std::string& text) {
  auto out = std::back_inserter(text);
  const char* before = "";
  for (const ColmapReconstruction::Point2d& seen : points) {
    fmt::format_to(out, "{}{:.4f} {:.4f} ", before, seen.in_img.x(), seen.in_img.y());
    if (seen.point == ColmapReconstruction::kNoPoint)
      fmt::format_to(out, "-1");
    else
      fmt::format_to(out, "{}", seen.point);
    before = " ";
  }
  text += '\n';
}

}  // namespace

ColmapFiles ToColmapText(const ColmapReconstruction& model) {
  ColmapFiles text;
  text.cameras = "# CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]\n";
  for (const ColmapReconstruction::Camera& camera : model.cameras)
    fmt::format_to(std::back_inserter(text.cameras), "{} {} {} {} {}\n", camera.id, camera.name, camera.width,
                   camera.height, fmt::join(camera.parameters, " "));

  text.images = "# IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, then a line of POINTS2D[] X Y POINT3D_ID\n";
  for (const ColmapReconstruction::Image& image : model.images) {
    const Eigen::Quaterniond& q = image.cam_from_world.rotation;
    const Eigen::Vector3d& t = image.cam_from_world.translation;
    fmt::format_to(std::back_inserter(text.images), "{} {} {} {} {} {} {} {} {} {}\n", image.id, q.w(), q.x(),
                   q.y(), q.z(), t.x(), t.y(), t.z(), image.camera, image.name);
    AppendPoints(image.points, text.images);
  }

  text.points3d = "# POINT3D_ID X Y Z R G B ERROR TRACK[] as IMAGE_ID POINT2D_IDX\n";
  for (const ColmapReconstruction::Point& point : model.points) {
    auto out = std::back_inserter(text.points3d);
    fmt::format_to(out, "{} {} {} {} {} {} {} {:.5g}", point.id, point.position.x(), point.position.y(),
                   point.position.z(), point.rgb[0], point.rgb[1], point.rgb[2], point.error_px);
    for (const ColmapReconstruction::Seen& seen : point.track)
      fmt::format_to(out, " {} {}", seen.image, seen.index);
    text.points3d += '\n';
  }
  return text;
}

}  // namespace ulf
