#include "core/light_field/points/point_io.h"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/geometry/byte_stream.h"
#include "core/geometry/digest.h"
#include "core/light_field/journal_stamp.h"
#include "core/light_field/points/ply_reader.h"
#include "core/light_field/points/point_tracks.h"

namespace ulf {

namespace {

constexpr char kPointsMagic[8] = {'u', 'l', 'f', 'p', 't', 's', '\0', 1};  // the last byte is the version
constexpr std::size_t kSumBytes = sizeof(std::uint64_t);

// Identifies a file that ulf wrote for a light field, against edited ones and other light fields' files.
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
  double left = body.Count(property);
  while (left-- > 0) {
    const double value = body.Next(property.type);
    if (property.count_type) continue;
    for (std::size_t i = 0; i < 3; ++i) {
      if (property.name == kAxes[i]) point.position_in_world[static_cast<Eigen::Index>(i)] = value;
      if ((property.name == kColors[i][0] || property.name == kColors[i][1]) && std::isfinite(value))
        point.rgb[i] = Byte(property.type, value);
    }
  }
}

// Returns whether the vertices of two such files are the same, whatever their headers say.
bool HoldsSamePoints(std::string_view ply, std::string_view other) { return BodyOf(ply) == BodyOf(other); }

// Returns whether ulf wrote the file for this light field and nobody changed it since, by mark and checksum
// in its header.
bool IsOwnPointPly(std::string_view ply, const std::string& light_field) {
  const std::string_view header = ply.substr(0, ply.size() - BodyOf(ply).size());
  return header.find("comment " + OwnComment(BodyOf(ply), light_field) + "\n") != std::string_view::npos;
}

namespace fs = std::filesystem;

constexpr const char* kPointFile = "points.ulf";
constexpr const char* kPointPly = "points.ply";

StoredPoints StoredIn(const fs::path& file, const LightField& light_field) {
  try {
    return PointsFromBytes(ReadWholeFile(file), light_field);
  } catch (const Error& error) {
    return {error.what(), {}, {}};
  }
}

// Identifies light fields by the beginning of their journals: the device, the first view and its times.
std::string LightFieldMark(const fs::path& root) {
  std::ifstream journal(root / kJournalFile);
  std::string begin;
  for (std::string line; std::getline(journal, line);) {
    begin += line;
    if (line.find("\"event\":\"view\"") != std::string::npos) break;
  }
  return ChecksumText(FastChecksumOf(begin));
}

// Returns whether another program, a person, or ulf for another light field wrote the file. A file of this
// light field that is only older, because a kill came between the two files, is ours: the next writer makes
// it again.
bool IsOfAnother(const fs::path& ply, const std::vector<ScenePoint>& points) {
  std::error_code unknown;
  if (!fs::is_regular_file(ply, unknown)) return false;
  const std::string bytes = ReadWholeFile(ply);
  return !HoldsSamePoints(bytes, PointPlyBytes(points)) &&
         !IsOwnPointPly(bytes, LightFieldMark(FolderOf(ply)));
}

}  // namespace

std::string PointFileBytes(const LightField& light_field) {
  ByteWriter out;
  out.Put(kPointsMagic);
  out.Count(light_field.views.size());
  for (const View& view : light_field.views) {
    out.Put(static_cast<std::int32_t>(view.id));
    out.Put(light_field.PoseDigest(view));
  }
  out.Count(light_field.points.size());
  for (const ScenePoint& point : light_field.points) {
    out.Put(point.position_in_world);
    out.Put(point.rgb);
    out.Count(static_cast<std::size_t>(std::ranges::count_if(point.track, [&](const ViewObservation& seen) {
      return light_field.FindView(seen.view_id) != nullptr;
    })));
    for (const ViewObservation& seen : point.track) {
      const View* view = light_field.FindView(seen.view_id);
      if (!view) continue;
      out.Count(static_cast<std::size_t>(view - light_field.views.data()));
      out.Put(static_cast<float>(seen.in_img.x()));
      out.Put(static_cast<float>(seen.in_img.y()));
    }
  }
  out.Put(ChecksumOf(out.bytes()));
  return std::move(out.bytes());
}

StoredPoints PointsFromBytes(std::string_view bytes, const LightField& light_field) {
  if (bytes.size() < sizeof kPointsMagic + kSumBytes || std::memcmp(bytes.data(), kPointsMagic, 6) != 0)
    return {"it is no file of points", {}, {}};
  if (bytes[7] != kPointsMagic[7]) return {"it is of another version", {}, {}};
  std::uint64_t checksum;
  std::memcpy(&checksum, bytes.data() + bytes.size() - kSumBytes, kSumBytes);
  bytes.remove_suffix(kSumBytes);
  if (ChecksumOf(bytes) != checksum) return {"it is damaged", {}, {}};
  bytes.remove_prefix(sizeof kPointsMagic);

  StoredPoints inconsistent{"its content is inconsistent", {}, {}};
  StoredPoints stored;
  ByteReader in(bytes);
  constexpr std::size_t kViewBytes = 12, kPointBytes = 31, kSeenBytes = 12;
  std::vector<int> ids(in.Count(kViewBytes));
  for (int& id : ids) {
    id = in.Get<std::int32_t>();
    const auto digest = in.Get<std::uint64_t>();
    const View* view = light_field.FindView(id);
    if (view && light_field.PoseDigest(*view) != digest) stored.moved.insert(id);
  }
  stored.points.resize(in.Count(kPointBytes));
  for (ScenePoint& point : stored.points) {
    point.position_in_world = in.Get3();
    point.rgb = in.Get<std::array<std::uint8_t, 3>>();
    point.track.resize(in.Count(kSeenBytes));
    for (ViewObservation& seen : point.track) {
      const auto view = in.Get<std::uint32_t>();
      if (view >= ids.size()) return inconsistent;
      seen.view_id = ids[view];
      seen.in_img.x() = in.Get<float>();
      seen.in_img.y() = in.Get<float>();
      if (!seen.in_img.allFinite()) return inconsistent;
    }
    if (!point.position_in_world.allFinite()) return inconsistent;
  }
  return in.IsShort() || !in.AtEnd() ? inconsistent : stored;
}

std::string PointPlyBytes(const std::vector<ScenePoint>& points, const std::string& light_field) {
  std::string body;
  for (const ScenePoint& point : points) {
    const Eigen::Vector3f position = point.position_in_world.cast<float>();
    body.append(reinterpret_cast<const char*>(position.data()), 3 * sizeof(float));
    body.append(reinterpret_cast<const char*>(point.rgb.data()), 3);
  }
  return Header(points.size(), body, light_field) + body;
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

bool ReadPointPositions(const fs::path& ply, LightField& light_field) {
  std::error_code unknown;
  if (!fs::is_regular_file(ply, unknown)) return false;
  try {
    light_field.points = ReadPointPly(ply);
  } catch (const Error& error) {
    light_field.doubts.push_back(fmt::format("{}; the light field is read without points", error.what()));
  }
  return true;
}

void ReadPoints(LightField& light_field) {
  const fs::path file = light_field.root / kPointFile, ply = light_field.root / kPointPly;
  std::error_code unknown;
  if (!fs::is_regular_file(file, unknown)) {
    ReadPointPositions(ply, light_field);
    return;
  }
  StoredPoints stored = StoredIn(file, light_field);
  if (!stored.problem.empty()) {
    light_field.doubts.push_back(fmt::format(
        "{}: {}; points.ply is read instead, which has no observations (ulf refine measures new ones)",
        file.string(), stored.problem));
    ReadPointPositions(ply, light_field);
    return;
  }
  if (IsOfAnother(ply, stored.points))
    light_field.doubts.push_back(fmt::format(
        "{}: holds other points than points.ulf, which is used; to use this file, remove points.ulf",
        ply.string()));
  light_field.points = std::move(stored.points);
  FitPointsOf(stored.moved, light_field);
  light_field.misplaced_observations = MeasurePoints(light_field);
}

void WritePoints(const LightField& light_field) {
  WriteFileAtomically(light_field.root / kPointFile, PointFileBytes(light_field));
  WriteFileAtomically(light_field.root / kPointPly,
                      PointPlyBytes(light_field.points, LightFieldMark(light_field.root)));
}

}  // namespace ulf
