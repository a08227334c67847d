#include "acquisition/colmap_text.h"

#include <fmt/format.h>

#include <cerrno>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>

#include "acquisition/error.h"

namespace ulf {
namespace {

// As ToColmapText() writes it.
constexpr const char* kStamp = "from journal.jsonl, ";
constexpr const char* kStampFormat = "%" SCNu64 " bytes, crc32 %" SCNu32;

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

std::string SafeName(const std::string& name) {
  std::string safe = name;
  for (char& c : safe)
    if (static_cast<unsigned char>(c) <= ' ' || c == '\x7f') c = '_';
  return safe;
}

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
    if (!row || !t.allFinite() || !(std::abs(image.cam_from_world.rotation.norm() - 1) < 1e-3) ||
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

ColmapText ToColmapText(const LightField& light_field, const std::optional<JournalStamp>& made_from) {
  ColmapText text;
  text.cameras = "# CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]\n";
  for (std::size_t i = 0; i < light_field.cameras.size(); ++i)
    text.cameras += CameraLine(static_cast<int>(i) + 1, light_field.cameras[i]);

  text.images = "# IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, then a line of POINTS2D[] (empty)";
  if (made_from)
    text.images += fmt::format("; {}{} bytes, crc32 {}", kStamp, made_from->bytes, made_from->crc32);
  text.images += '\n';
  for (const View& view : light_field.views) {
    const Eigen::Quaterniond& q = view.cam_from_world.rotation;
    const Eigen::Vector3d& t = view.cam_from_world.translation;
    fmt::format_to(std::back_inserter(text.images), "{} {} {} {} {} {} {} {} {} {}\n\n", view.id, q.w(),
                   q.x(), q.y(), q.z(), t.x(), t.y(), t.z(), view.camera + 1,
                   SafeName(NameInImagesFolder(view.image_path)));
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
