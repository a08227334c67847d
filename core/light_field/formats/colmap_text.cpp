#include "core/light_field/formats/colmap_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>
#include <iterator>
#include <sstream>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/light_field/formats/colmap_rigs.h"
#include "core/light_field/formats/text_file.h"
#include "core/light_field/formats/view_json.h"
#include "core/light_field/journal_stamp.h"

namespace ulf {
namespace {

// The form is that of ToColmapText().
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

[[noreturn]] void RefuseImageRow(const std::filesystem::path& images_txt, int number) {
  throw Error("{}, line {}: is no row of an image (IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME)",
              images_txt.string(), number);
}

// Calls `comment` with each line that is empty or a comment, and `use` with each image, the line of its
// points and its line's number.
void ForEachImage(
    const std::filesystem::path& images_txt, const std::function<void(const std::string&)>& comment,
    const std::function<void(std::uint32_t, ColmapPoses::Image&&, const std::string&, int)>& use) {
  std::ifstream file = OpenTextFile(images_txt);
  int number = 0;
  for (std::string line; std::getline(file, line);) {
    ++number;
    if (IsEmptyOrComment(line)) {
      comment(line);
      continue;
    }
    std::istringstream row(line);
    std::uint32_t id = 0;
    double w = 0, x = 0, y = 0, z = 0;
    ColmapPoses::Image image;
    Eigen::Vector3d& t = image.cam_from_world.translation;
    row >> id >> w >> x >> y >> z >> t.x() >> t.y() >> t.z() >> image.camera;
    image.cam_from_world.rotation = Eigen::Quaterniond(w, x, y, z);
    if (!row || !std::getline(row >> std::ws, image.name)) RefuseImageRow(images_txt, number);
    image.name.erase(image.name.find_last_not_of(" \t\r") + 1);
    const int at = number;
    line.clear();
    std::getline(file, line);  // its points, possibly none
    ++number;
    use(id, std::move(image), line, at);
  }
}

// A row has X Y POINT3D_ID for each point; a comment in its place stands for none, as in COLMAP's manual.
std::vector<ColmapReconstruction::Point2d> Points2dOf(const std::string& line, const std::string& where) {
  std::vector<ColmapReconstruction::Point2d> points;
  if (IsEmptyOrComment(line)) return points;
  const char* at = line.c_str();
  const auto skip = [&] {
    while (*at == ' ' || *at == '\r' || *at == '\t') ++at;
    return *at != '\0';
  };
  const auto number = [&](auto parse) {
    char* end = nullptr;
    const auto value = skip() ? parse(at, &end) : 0;
    if (end == nullptr || end == at)
      throw Error("{}: its points are no list of X Y POINT3D_ID; the file may be cut short: write it anew",
                  where);
    at = end;
    return value;
  };
  const auto decimal = [](const char* text, char** end) { return std::strtod(text, end); };
  while (skip()) {
    ColmapReconstruction::Point2d point;
    point.in_img.x() = number(decimal);
    point.in_img.y() = number(decimal);
    const long long id = number([](const char* text, char** end) { return std::strtoll(text, end, 10); });
    if (id >= 0) point.point = static_cast<std::uint64_t>(id);
    points.push_back(point);
  }
  return points;
}

// Calls `use` with each line that is neither empty nor a comment, and its place.
void ForEachRow(const std::filesystem::path& path,
                const std::function<void(std::istringstream&, const std::string&)>& use) {
  std::ifstream file = OpenTextFile(path);
  int number = 0;
  for (std::string line; std::getline(file, line);) {
    ++number;
    if (IsEmptyOrComment(line)) continue;
    std::istringstream row(line);
    use(row, fmt::format("{}, line {}", path.string(), number));
  }
}

void ReadPoints3d(const std::filesystem::path& points_txt, ColmapReconstruction& model) {
  ForEachRow(points_txt, [&](std::istringstream& row, const std::string& where) {
    ColmapReconstruction::Point point;
    std::array<int, 3> rgb{};
    row >> point.id >> point.position.x() >> point.position.y() >> point.position.z() >> rgb[0] >> rgb[1] >>
        rgb[2] >> point.error_px;
    if (!row) throw Error("{}: is no row of a point (POINT3D_ID X Y Z R G B ERROR TRACK[])", where);
    for (std::size_t i = 0; i < rgb.size(); ++i)
      point.rgb[i] = static_cast<std::uint8_t>(std::clamp(rgb[i], 0, 255));
    for (ColmapReconstruction::Seen seen; row >> seen.image;) {
      if (!(row >> seen.index))
        throw Error("{}: its track ends in the middle of a pair (IMAGE_ID POINT2D_IDX); write the file anew",
                    where);
      point.track.push_back(seen);
    }
    model.points.push_back(std::move(point));
  });
}

}  // namespace

ColmapPoses ReadColmapPoses(const std::filesystem::path& images_txt) {
  ColmapPoses poses;
  ForEachImage(
      images_txt,
      [&](const std::string& line) {
        JournalStamp stamp;
        const std::size_t at = line.find(kStamp);
        if (at != std::string::npos && std::sscanf(line.c_str() + at + std::strlen(kStamp), kStampFormat,
                                                   &stamp.bytes, &stamp.crc32) == 2)
          poses.made_from = stamp;
      },
      [&](std::uint32_t id, ColmapPoses::Image&& image, const std::string&, int number) {
        const std::string where = fmt::format("{}, line {}", images_txt.string(), number);
        if (id < 1 || id > static_cast<std::uint32_t>(kMostViewId) ||
            NormalizeColmapPose(image.cam_from_world, where) > kQuaternionTolerance)
          RefuseImageRow(images_txt, number);
        poses.images[static_cast<int>(id)] = std::move(image);
      });
  return poses;
}

std::map<int, CameraModel> ReadColmapCameras(const std::filesystem::path& cameras_txt) {
  std::map<int, CameraModel> cameras;
  ForEachRow(cameras_txt, [&](std::istringstream& row, const std::string& where) {
    int id = 0;
    if (!(row >> id)) throw Error("{}: is no row of a camera (CAMERA_ID MODEL WIDTH HEIGHT PARAMS[])", where);
    cameras[id] = ReadColmapCamera(row, where);
  });
  return cameras;
}

ColmapReconstruction ReadColmapText(const std::filesystem::path& dir) {
  ColmapReconstruction model;
  for (const auto& [id, camera] : ReadColmapCameras(dir / "cameras.txt")) {
    model.cameras.push_back(ToColmapCamera(camera));
    model.cameras.back().id = static_cast<std::uint32_t>(id);
  }
  const std::filesystem::path images_txt = dir / "images.txt";
  ForEachImage(
      images_txt, [](const std::string&) {},
      [&](std::uint32_t id, ColmapPoses::Image&& image, const std::string& points, int number) {
        model.images.push_back(
            {id, static_cast<std::uint32_t>(image.camera), image.cam_from_world, image.name,
             Points2dOf(points,
                        fmt::format("{}, line {} ({})", images_txt.string(), number + 1, image.name))});
      });
  if (std::filesystem::exists(dir / "points3D.txt")) ReadPoints3d(dir / "points3D.txt", model);
  SettleColmapPoses(dir, false, model);
  return model;
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
