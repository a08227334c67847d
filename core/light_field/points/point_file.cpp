#include "core/light_field/points/point_file.h"

#include <algorithm>
#include <cstring>
#include <map>

#include "core/geometry/byte_stream.h"
#include "core/geometry/digest.h"

namespace ulf {
namespace {

constexpr char kPointsMagic[8] = {'u', 'l', 'f', 'p', 't', 's', '\0', 1};  // the last byte is the version
constexpr std::size_t kSumBytes = sizeof(std::uint64_t);

std::uint64_t MeasuredUnder(const LightField& light_field, const View& view) {
  Digest digest;
  digest.Add(view.cam_from_world);
  digest.Add(light_field.CameraOf(view));
  return digest.Value();
}

}  // namespace

std::string PointFileBytes(const LightField& light_field) {
  ByteWriter out;
  out.Put(kPointsMagic);
  std::map<int, std::uint32_t> index;
  out.Count(light_field.views.size());
  for (const View& view : light_field.views) {
    index.emplace(view.id, static_cast<std::uint32_t>(index.size()));
    out.Put(static_cast<std::int32_t>(view.id));
    out.Put(MeasuredUnder(light_field, view));
  }
  out.Count(light_field.points.size());
  for (const ScenePoint& point : light_field.points) {
    out.Put(point.position_in_world);
    out.Put(point.rgb);
    out.Count(static_cast<std::size_t>(std::ranges::count_if(
        point.track, [&](const ViewObservation& seen) { return index.contains(seen.view_id); })));
    for (const ViewObservation& seen : point.track) {
      const auto view = index.find(seen.view_id);
      if (view == index.end()) continue;
      out.Put(view->second);
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

  const StoredPoints inconsistent{"its content is inconsistent", {}, {}};
  StoredPoints stored;
  ByteReader in(bytes);
  std::map<int, const View*> views;
  for (const View& view : light_field.views) views[view.id] = &view;
  constexpr std::size_t kViewBytes = 12, kPointBytes = 31, kSeenBytes = 12;
  std::vector<int> ids(in.Count(kViewBytes));
  for (int& id : ids) {
    id = in.Get<std::int32_t>();
    const auto digest = in.Get<std::uint64_t>();
    const auto view = views.find(id);
    if (view != views.end() && MeasuredUnder(light_field, *view->second) != digest) stored.moved.insert(id);
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

}  // namespace ulf
