#include "acquisition/point_ply.h"

#include <fmt/core.h>

#include <cstring>
#include <string_view>

#include "acquisition/atomic_file.h"
#include "acquisition/error.h"

namespace ulf {
namespace {

constexpr std::size_t kBytesPerPoint = 3 * sizeof(float) + 3;

std::string Header(std::size_t count) {
  return fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\n"
      "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n",
      count);
}

}  // namespace

std::string PointPlyBytes(const std::vector<ScenePoint>& points) {
  std::string bytes = Header(points.size());
  for (const ScenePoint& point : points) {
    const Eigen::Vector3f position = point.position_in_world.cast<float>();
    bytes.append(reinterpret_cast<const char*>(position.data()), 3 * sizeof(float));
    bytes.append(reinterpret_cast<const char*>(point.rgb.data()), 3);
  }
  return bytes;
}

std::vector<ScenePoint> ReadPointPly(const std::filesystem::path& file) {
  const std::string bytes = ReadWholeFile(file);
  constexpr std::string_view kElement = "element vertex ";
  const std::size_t at = bytes.find(kElement);
  const std::size_t count =
      at == std::string::npos ? 0 : std::strtoull(bytes.c_str() + at + kElement.size(), nullptr, 10);
  const std::string header = Header(count);
  if (!bytes.starts_with(header) || bytes.size() != header.size() + count * kBytesPerPoint)
    throw Error(
        "{}: not a points file of this program's (binary x y z red green blue), or truncated; remove it",
        file.string());
  std::vector<ScenePoint> points(count);
  const char* next = bytes.data() + header.size();
  for (ScenePoint& point : points) {
    Eigen::Vector3f position;
    std::memcpy(position.data(), next, 3 * sizeof(float));
    std::memcpy(point.rgb.data(), next + 3 * sizeof(float), 3);
    point.position_in_world = position.cast<double>();
    next += kBytesPerPoint;
  }
  return points;
}

}  // namespace ulf
