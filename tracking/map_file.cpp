#include "tracking/map_file.h"

#include <bit>
#include <cstring>
#include <optional>
#include <type_traits>
#include <vector>

namespace ulf {
namespace {

static_assert(std::endian::native == std::endian::little, "the file's numbers are little-endian");

constexpr char kMagic[8] = {'u', 'l', 'f', 'm', 'a', 'p', '\0', 1};  // the last byte is the version

std::uint64_t ChecksumOf(std::string_view bytes) {
  Digest digest;
  digest.Add(std::as_bytes(std::span(bytes)));
  return digest.Value();
}

class Writer {
 public:
  template <typename T>
  void Put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void Put(const Eigen::Vector2d& v) { Put(v.x()), Put(v.y()); }
  void Put(const Eigen::Vector3d& v) { Put(v.x()), Put(v.y()), Put(v.z()); }
  void Put(const Rigid3& pose) {
    for (int i = 0; i < 4; ++i) Put(pose.rotation.coeffs()(i));
    Put(pose.translation);
  }
  void Count(std::size_t count) { Put(static_cast<std::uint32_t>(count)); }
  std::string& bytes() { return bytes_; }

 private:
  std::string bytes_;
};

// Past the end it gives zeros and remembers.
class Reader {
 public:
  explicit Reader(std::string_view bytes) : bytes_(bytes) {}
  template <typename T>
  T Get() {
    T value{};
    if (sizeof value > bytes_.size() - at_) {
      short_ = true;
      at_ = bytes_.size();
      return value;
    }
    std::memcpy(&value, bytes_.data() + at_, sizeof value);
    at_ += sizeof value;
    return value;
  }
  Eigen::Vector2d Get2() {
    const double x = Get<double>(), y = Get<double>();
    return {x, y};
  }
  Eigen::Vector3d Get3() {
    const double x = Get<double>(), y = Get<double>(), z = Get<double>();
    return {x, y, z};
  }
  Rigid3 GetPose() {
    Rigid3 pose;
    for (int i = 0; i < 4; ++i) pose.rotation.coeffs()(i) = Get<double>();
    pose.translation = Get3();
    return pose;
  }
  // Of things that take at least `least` bytes each; more than are left cannot be.
  std::size_t Count(std::size_t least) {
    const std::size_t count = Get<std::uint32_t>();
    if (count * least > bytes_.size() - at_) short_ = true;
    return short_ ? 0 : count;
  }
  bool IsShort() const { return short_; }
  bool AtEnd() const { return at_ == bytes_.size(); }

 private:
  std::string_view bytes_;
  std::size_t at_ = 0;
  bool short_ = false;
};

void PutKeyframe(const Map& map, const Keyframe& keyframe, Writer& out) {
  out.Put(keyframe.alive);
  // A removed one is only asked where it was.
  out.Put(map.PoseOf(keyframe.id));
  out.Put(keyframe.time_s);
  if (!keyframe.alive) return;
  out.Put(keyframe.points_at_birth);
  out.Count(static_cast<std::size_t>(keyframe.features->size()));
  for (const Feature& feature : keyframe.features->all()) {
    out.Put(feature.img);
    out.Put(feature.angle_rad);
    out.Put(static_cast<std::uint8_t>(feature.level));
    out.Put(feature.descriptor);
  }
}

std::optional<Keyframe> GetKeyframe(Reader& in, const CameraModel& camera) {
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

void PutPoint(const MapPoint& point, Writer& out) {
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
  out.Put(point.patch != nullptr);
  if (!point.patch) return;
  out.Put(point.patch_keyframe);
  out.Put(*point.patch);
}

// False when it names what is not there.
bool GetPoint(Reader& in, Map& map) {
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
        o.feature >= map.keyframe(o.keyframe).features->size() || !map.Observe(id, o))
      return false;
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

void Digest::Add(std::span<const std::byte> bytes) {
  for (const std::byte byte : bytes) {
    value_ ^= static_cast<std::uint64_t>(byte);
    value_ *= 1099511628211ull;
  }
}
void Digest::Add(double number) { Add(std::as_bytes(std::span(&number, 1))); }
void Digest::Add(const Rigid3& pose) {
  for (int i = 0; i < 4; ++i) Add(pose.rotation.coeffs()(i));
  for (int i = 0; i < 3; ++i) Add(pose.translation(i));
}
void Digest::Add(const std::string& text) {
  Add(static_cast<double>(text.size()));
  Add(std::as_bytes(std::span(text)));
}

std::string MapToBytes(const Map& map, std::uint64_t key) {
  Writer out;
  out.Put(kMagic);
  out.Put(key);
  out.Count(map.keyframes().size());
  for (const Keyframe& keyframe : map.keyframes()) PutKeyframe(map, keyframe, out);
  out.Count(static_cast<std::size_t>(map.LivingPoints()));
  for (const MapPoint& point : map.points())
    if (point.alive) PutPoint(point, out);
  out.Put(ChecksumOf(out.bytes()));
  return std::move(out.bytes());
}

std::string MapFromBytes(std::string_view bytes, std::uint64_t key, const CameraModel& camera, Map& map) {
  constexpr std::size_t kSum = sizeof(std::uint64_t);
  if (bytes.size() < sizeof kMagic + 2 * kSum || std::memcmp(bytes.data(), kMagic, 6) != 0)
    return "it is not a map";
  if (bytes[7] != kMagic[7]) return "it is of another version";
  std::uint64_t checksum;
  std::memcpy(&checksum, bytes.data() + bytes.size() - kSum, kSum);
  bytes.remove_suffix(kSum);
  if (ChecksumOf(bytes) != checksum) return "it is damaged";
  bytes.remove_prefix(sizeof kMagic);
  Reader in(bytes);
  if (in.Get<std::uint64_t>() != key)
    return "it belongs to other views or poses, or to another --tracking-side";
  constexpr std::size_t kKeyframeBytes = 65, kPointBytes = 44;
  const std::string inconsistent = "it contradicts itself";
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
  return {};
}

}  // namespace ulf
