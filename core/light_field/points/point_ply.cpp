#include "core/light_field/points/point_ply.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "core/base/atomic_file.h"
#include "core/geometry/digest.h"
#include "core/light_field/points/ply_reader.h"

namespace ulf {
namespace {

// Tells a file that ulf wrote for a light field from one that somebody changed, and from another light field's.
std::string OwnComment(std::string_view body, const std::string& light_field) {
  return fmt::format("written by ulf, checksum of the vertices {}{}", ChecksumText(FastChecksumOf(body)),
                     light_field.empty() ? "" : ", of the light field " + light_field);
}

constexpr std::string_view kEndOfHeader = "end_header\n";

std::string Header(std::size_t count, std::string_view body, const std::string& light_field) {
  return fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment {}\nelement vertex {}\nproperty float x\n"
      "property float y\nproperty float z\nproperty uchar red\nproperty uchar green\nproperty uchar "
      "blue\n{}",
      OwnComment(body, light_field), count, kEndOfHeader);
}

std::string_view BodyOf(std::string_view ply) {
  const std::size_t end = ply.find(kEndOfHeader);
  return end == std::string_view::npos ? std::string_view() : ply.substr(end + kEndOfHeader.size());
}

// Colours may be bytes, 16 bits or fractions of 1.
std::uint8_t Byte(ply::Number type, double value) {
  const bool fraction = type == ply::Number::kFloat || type == ply::Number::kDouble;
  const double scale = fraction ? 255 : type == ply::Number::kUint16 ? 1 / 257.0 : 1;
  return static_cast<std::uint8_t>(std::lround(std::clamp(value * scale, 0.0, 255.0)));
}

void Take(const ply::Property& property, ply::Body& body, ScenePoint& point) {
  static constexpr std::array<std::array<std::string_view, 2>, 3> kColors{
      {{"red", "r"}, {"green", "g"}, {"blue", "b"}}};
  static constexpr std::array<std::string_view, 3> kAxes{"x", "y", "z"};
  const double count = body.Count(property);
  for (double k = 0; k < count; ++k) {
    const double value = body.Next(property.type);
    if (property.count_type) continue;
    for (std::size_t i = 0; i < 3; ++i) {
      if (property.name == kAxes[i]) point.position_in_world[static_cast<Eigen::Index>(i)] = value;
      if ((property.name == kColors[i][0] || property.name == kColors[i][1]) && std::isfinite(value))
        point.rgb[i] = Byte(property.type, value);
    }
  }
}

}  // namespace

std::string PointPlyBytes(const std::vector<ScenePoint>& points, const std::string& light_field) {
  std::string body;
  for (const ScenePoint& point : points) {
    const Eigen::Vector3f position = point.position_in_world.cast<float>();
    body.append(reinterpret_cast<const char*>(position.data()), 3 * sizeof(float));
    body.append(reinterpret_cast<const char*>(point.rgb.data()), 3);
  }
  return Header(points.size(), body, light_field) + body;
}

bool HoldsSamePoints(std::string_view ply, std::string_view other) { return BodyOf(ply) == BodyOf(other); }

bool IsOwnPointPly(std::string_view ply, const std::string& light_field) {
  const std::string_view header = ply.substr(0, ply.size() - BodyOf(ply).size());
  return header.find("comment " + OwnComment(BodyOf(ply), light_field) + "\n") != std::string_view::npos;
}

std::vector<ScenePoint> ReadPointPly(const std::filesystem::path& file) {
  const std::string bytes = ReadWholeFile(file);
  const ply::Header header = ply::ParseHeader(bytes, file.string());
  ply::Body body(bytes, header, file.string());
  std::vector<ScenePoint> points;
  for (const ply::Element& element : header.elements) {
    body.Require(element);
    if (element.name != "vertex" || element.properties.empty()) {
      body.Skip(element);
      continue;
    }
    points.reserve(element.count);
    for (std::size_t i = 0; i < element.count; ++i) {
      ScenePoint point;
      for (const ply::Property& property : element.properties) Take(property, body, point);
      if (point.position_in_world.allFinite()) points.push_back(point);
    }
  }
  return points;
}

}  // namespace ulf
