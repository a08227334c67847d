#include "core/light_field/exchange/colmap_text.h"

#include <fmt/format.h>

#include <cerrno>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>

#include "core/base/error.h"
#include "core/light_field/view_json.h"

namespace ulf {
namespace {

// As ToColmapText() writes it.
constexpr const char* kStamp = "from journal.jsonl, ";
constexpr const char* kStampFormat = "%" SCNu64 " bytes, crc32 %" SCNu32;

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

ColmapPoses ReadColmapPoses(const std::filesystem::path& images_txt) {
  std::ifstream file(images_txt);
  if (!file) throw Error("{}: cannot be read: {}", images_txt.string(), std::strerror(errno));
  ColmapPoses poses;
  int number = 0;
  for (std::string line; std::getline(file, line);) {
    ++number;
    if (line.starts_with('#')) {
      JournalStamp stamp;
      const std::size_t at = line.find(kStamp);
      if (at != std::string::npos &&
          std::sscanf(line.c_str() + at + std::strlen(kStamp), kStampFormat, &stamp.bytes, &stamp.crc32) == 2)
        poses.made_from = stamp;
      continue;
    }
    if (line.find_first_not_of(" \r") == std::string::npos) continue;
    std::istringstream row(line);
    int id = 0;
    double w = 0, x = 0, y = 0, z = 0;
    ColmapPoses::Image image;
    Eigen::Vector3d& t = image.cam_from_world.translation;
    row >> id >> w >> x >> y >> z >> t.x() >> t.y() >> t.z() >> image.camera;
    image.cam_from_world.rotation = Eigen::Quaterniond(w, x, y, z);
    if (!row || id < 1 || id > kMostViewId || !t.allFinite() ||
        !(std::abs(image.cam_from_world.rotation.norm() - 1) < 1e-3) ||
        !std::getline(row >> std::ws, image.name))
      throw Error("{}, line {}: is no row of an image (IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME)",
                  images_txt.string(), number);
    image.cam_from_world.rotation.normalize();
    poses.images[id] = image;
    std::getline(file, line);  // its points, which may be none
    ++number;
  }
  return poses;
}

std::map<int, CameraModel> ReadColmapCameras(const std::filesystem::path& cameras_txt) {
  std::ifstream file(cameras_txt);
  if (!file) throw Error("{}: cannot be read: {}", cameras_txt.string(), std::strerror(errno));
  std::map<int, CameraModel> cameras;
  int number = 0;
  for (std::string line; std::getline(file, line);) {
    ++number;
    if (line.starts_with('#') || line.find_first_not_of(" \r") == std::string::npos) continue;
    const std::string where = fmt::format("{}, line {}", cameras_txt.string(), number);
    std::istringstream row(line);
    int id = 0;
    if (!(row >> id)) throw Error("{}: is no row of a camera (CAMERA_ID MODEL WIDTH HEIGHT PARAMS[])", where);
    cameras[id] = ReadColmapCamera(row, where);
  }
  return cameras;
}

ColmapFiles ToColmapText(const ColmapReconstruction& model, const std::optional<JournalStamp>& made_from) {
  ColmapFiles text;
  text.cameras = "# CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]\n";
  for (const ColmapReconstruction::Camera& camera : model.cameras)
    fmt::format_to(std::back_inserter(text.cameras), "{} {} {} {} {}\n", camera.id, camera.name, camera.width,
                   camera.height, fmt::join(camera.parameters, " "));

  text.images = "# IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, then a line of POINTS2D[] X Y POINT3D_ID";
  if (made_from)
    text.images += fmt::format("; {}{} bytes, crc32 {}", kStamp, made_from->bytes, made_from->crc32);
  text.images += '\n';
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
