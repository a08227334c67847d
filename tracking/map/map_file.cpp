#include "tracking/map/map_file.h"

#include <fmt/core.h>

#include <algorithm>
#include <cstring>
#include <optional>
#include <vector>

#include "core/base/at.h"
#include "core/base/error.h"
#include "core/geometry/byte_stream.h"
#include "core/geometry/digest.h"

namespace ulf::tracking {
namespace {

constexpr char kMagic[8] = {'u', 'l', 'f', 'm', 'a', 'p', '\0', 2};  // the last byte is the version

// The file keeps the main part, because recorded views are in its world.
bool IsKept(const Map& map, const Keyframe& keyframe) {
  return keyframe.alive && keyframe.part == map.main_part();
}

void PutKeyframe(const Map& map, const Keyframe& keyframe, ByteWriter& out) {
  out.Put(IsKept(map, keyframe));
  // A removed keyframe is only asked for its pose.
  out.Put(map.PoseOf(keyframe.id));
  out.Put(keyframe.time_s);
  if (!IsKept(map, keyframe)) return;
  out.Put(keyframe.points_at_birth);
  out.Count(At(keyframe.features->size()));
  for (const Feature& feature : keyframe.features->all()) {
    out.Put(feature.img);
    out.Put(feature.angle_rad);
    out.Put(static_cast<std::uint8_t>(feature.level));
    out.Put(feature.descriptor);
  }
}

std::optional<Keyframe> GetKeyframe(ByteReader& in, const CameraModel& camera) {
  Keyframe keyframe;
  const bool alive = in.Get<std::uint8_t>() != 0;
  keyframe.cam_from_world = in.GetPose();
  keyframe.time_s = in.Get<double>();
  std::vector<Feature> features;
  if (alive) {
    keyframe.points_at_birth = in.Get<int>();
    constexpr std::size_t kFeatureBytes = 53;
    features.resize(in.Count(kFeatureBytes));
    for (Feature& feature : features) {
      feature.img = in.Get2();
      feature.angle_rad = in.Get<float>();
      feature.level = in.Get<std::uint8_t>();
      feature.descriptor = in.Get<Descriptor>();
      const auto ray = camera.RayFromImg(feature.img);
      if (!ray || feature.level >= kPyramidLevels) return std::nullopt;
      feature.ray = *ray;
    }
  }
  keyframe.pinned = true;
  keyframe.features = std::make_shared<const FeatureSet>(std::move(features), camera.width, camera.height);
  keyframe.alive = alive;
  return keyframe;
}

void PutPoint(const MapPoint& point, ByteWriter& out) {
  out.Put(point.position);
  out.Put(point.rgb);
  out.Put(point.expected);
  out.Put(point.found);
  out.Put(point.first_keyframe);
  out.Count(point.observations.size());
  for (const Observation& o : point.observations) {
    out.Put(o.keyframe);
    out.Put(o.feature);
    out.Put(o.img);
    out.Put(o.sigma_px);
  }
  out.Count(point.views.size());
  for (const ViewObservation& o : point.views) {
    out.Put(o.view_id);
    out.Put(o.in_img);
  }
  out.Put(point.patch != nullptr);
  if (!point.patch) return;
  out.Put(point.patch_keyframe);
  out.Put(*point.patch);
}

// Returns false when the point refers to a keyframe or feature that does not exist.
bool GetPoint(ByteReader& in, Map& map) {
  const int keyframes = static_cast<int>(map.keyframes().size());
  const int id = map.AddPoint(in.Get3());
  MapPoint& point = map.point(id);
  point.rgb = in.Get<std::array<std::uint8_t, 3>>();
  point.expected = in.Get<int>();
  point.found = in.Get<int>();
  point.first_keyframe = in.Get<int>();
  constexpr std::size_t kObservationBytes = 32;
  const std::size_t count = in.Count(kObservationBytes);
  for (std::size_t i = 0; i < count; ++i) {
    Observation o;
    o.keyframe = in.Get<int>();
    o.feature = in.Get<int>();
    o.img = in.Get2();
    o.sigma_px = in.Get<double>();
    if (o.keyframe < 0 || o.keyframe >= keyframes || !map.keyframe(o.keyframe).alive || o.feature < 0 ||
        o.feature >= map.keyframe(o.keyframe).features->size() || !map.AddObservation(id, o))
      return false;
  }
  constexpr std::size_t kViewBytes = 20;
  point.views.resize(in.Count(kViewBytes));
  for (ViewObservation& o : point.views) {
    o.view_id = in.Get<int>();
    o.in_img = in.Get2();
  }
  if (in.Get<std::uint8_t>() != 0) {
    point.patch_keyframe = in.Get<int>();
    point.patch = std::make_shared<const ReferencePatch>(in.Get<ReferencePatch>());
    if (point.patch_keyframe < 0 || point.patch_keyframe >= keyframes || point.patch->level < 0 ||
        point.patch->level >= kPyramidLevels)
      return false;
  }
  return !in.IsShort();
}

}  // namespace

std::string MapToBytes(const Map& map, std::uint64_t key) {
  ByteWriter out;
  out.Put(kMagic);
  out.Put(key);
  out.Count(map.keyframes().size());
  for (const Keyframe& keyframe : map.keyframes()) PutKeyframe(map, keyframe, out);
  const auto is_kept = [&](const MapPoint& point) { return point.alive && point.part == map.main_part(); };
  out.Count(At(std::count_if(map.points().begin(), map.points().end(), is_kept)));
  for (const MapPoint& point : map.points())
    if (is_kept(point)) PutPoint(point, out);
  out.Put(ChecksumOf(out.bytes()));
  return std::move(out.bytes());
}

std::optional<MapRefusal> MapFromBytes(std::string_view bytes, std::uint64_t key, const CameraModel& camera,
                                       Map& map) {
  const auto unusable = [](const char* words) { return MapRefusal{MapProblem::kUnusable, words}; };
  constexpr std::size_t kSum = sizeof(std::uint64_t);
  if (bytes.size() < sizeof kMagic + 2 * kSum || std::memcmp(bytes.data(), kMagic, 6) != 0)
    return unusable("the kept map is no map");
  if (bytes[7] != kMagic[7]) return unusable("the kept map is of another version of ulf");
  std::uint64_t checksum;
  std::memcpy(&checksum, bytes.data() + bytes.size() - kSum, kSum);
  bytes.remove_suffix(kSum);
  if (ChecksumOf(bytes) != checksum) return unusable("the kept map is damaged");
  bytes.remove_prefix(sizeof kMagic);
  ByteReader in(bytes);
  map.SetMainPart(map.BeginPart());
  if (in.Get<std::uint64_t>() != key)
    return MapRefusal{MapProblem::kOtherViews,
                      fmt::format("views, poses or {} have changed since", Parameter("tracking_side"))};
  constexpr std::size_t kKeyframeBytes = 65, kPointBytes = 48;
  const MapRefusal inconsistent = unusable("the kept map contradicts itself");
  const std::size_t keyframes = in.Count(kKeyframeBytes);
  for (std::size_t i = 0; i < keyframes; ++i) {
    auto keyframe = GetKeyframe(in, camera);
    if (!keyframe) return inconsistent;
    const bool alive = keyframe->alive;
    const int id = map.AddKeyframe(std::move(*keyframe));
    if (alive) continue;
    map.keyframe(id).features.reset();
    map.keyframe(id).point_of_feature.clear();
  }
  const std::size_t points = in.Count(kPointBytes);
  for (std::size_t i = 0; i < points; ++i)
    if (!GetPoint(in, map)) return inconsistent;
  if (in.IsShort() || !in.AtEnd()) return inconsistent;
  for (const MapPoint& point : map.points()) map.Update(point.id);
  return std::nullopt;
}

}  // namespace ulf::tracking
