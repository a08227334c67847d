#include "acquisition/simulator/scene/bake.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "acquisition/simulator/scene/materials.h"
#include "acquisition/simulator/scene/scene.h"
#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/file_descriptor.h"
#include "core/geometry/digest.h"

namespace ulf::acquisition {
namespace {

using Eigen::Vector3f;

constexpr F4 kSky{0.27f, 0.245f, 0.23f, 0};     // blue-ish fill from above
constexpr F4 kBounce{0.085f, 0.1f, 0.115f, 0};  // warm, from table and floor
constexpr F4 kKeyColor{0.93f, 0.98f, 1.03f, 0};
constexpr int kLampGrid = 6;  // samples per side of a lamp; guessed, as the following
constexpr int kAmbientRays = 32;
constexpr unsigned kMostBakeThreads = 8;
constexpr float kAmbientReach = 0.6f;  // metres; farther surfaces are part of the room's light
constexpr float kUnseenTexelM = 0.02f, kUnseenLightM = 0.1f;  // resolution of charts that no camera sees
static_assert(kLampGrid * kLampGrid % 4 == 0 && kAmbientRays % kLanes == 0);

class Illumination {
 public:
  explicit Illumination(const Scene& scene) : scene_(scene) {
    for (int i = 0; i < kAmbientRays; ++i) {  // a spiral over the hemisphere, cosine-weighted
      const float share = (static_cast<float>(i) + 0.5f) / kAmbientRays,
                  angle = 2.39996323f * static_cast<float>(i);
      const float across = std::sqrt(share);
      hemisphere_.emplace_back(across * std::cos(angle), across * std::sin(angle), std::sqrt(1 - share));
    }
    for (const Primitive& primitive : scene.primitives()) {
      if (primitive.shape == Shape::kRoom || primitive.finish == Finish::kGlass) continue;
      const Vec3<float> center = primitive.BoundCenter();
      const Eigen::Vector3d in_world =
          primitive.local_from_world.Inverse() * Eigen::Vector3d(center.x, center.y, center.z);
      occluders_.push_back({&primitive, in_world.cast<float>(), primitive.BoundRadius(),
                            primitive.local_from_world.RotationMatrix().cast<float>(),
                            primitive.local_from_world.translation.cast<float>()});
    }
  }

  F4 At(const Vector3f& point, const Vector3f& normal) const {
    const Vector3f from = point + 2e-4f * normal;
    F4 total = Ambient(from, normal);
    for (const AreaLight& lamp : scene_.lights()) total += kKeyColor * Direct(lamp, from, normal);
    return total;
  }

 private:
  struct Occluder {
    const Primitive* primitive;
    Vector3f center;
    float radius;
    Eigen::Matrix3f rotation;
    Vector3f translation;
  };

  // Returns which of eight rays meet a surface before `reach`.
  I8 Blocked(const Vector3f& from, const Vec3<F8>& directions, F8 reach) const {
    I8 blocked{};
    for (const Occluder& occluder : occluders_) {
      const Vector3f to_center = occluder.center - from;
      const float distance2 = to_center.squaredNorm();
      if (distance2 > occluder.radius * occluder.radius) {
        const F8 along =
            directions.x * to_center.x() + directions.y * to_center.y() + directions.z * to_center.z();
        const I8 passes =
            (along < 0.0f) | (F8{} + distance2 - along * along > F8{} + occluder.radius * occluder.radius);
        if (!Any(~passes)) continue;
      }
      const Vector3f o = occluder.rotation * from + occluder.translation;
      const auto& r = occluder.rotation;
      const Vec3<F8> d{r(0, 0) * directions.x + r(0, 1) * directions.y + r(0, 2) * directions.z,
                       r(1, 0) * directions.x + r(1, 1) * directions.y + r(1, 2) * directions.z,
                       r(2, 0) * directions.x + r(2, 1) * directions.y + r(2, 2) * directions.z};
      const Vec3<F8> origin{F8{} + o.x(), F8{} + o.y(), F8{} + o.z()};
      blocked |= Intersect<F8>(*occluder.primitive, origin, d) < reach;
      if (!Any(~blocked)) break;
    }
    return blocked;
  }

  float Direct(const AreaLight& lamp, const Vector3f& from, const Vector3f& normal) const {
    float sum = 0;
    constexpr int kSamples = kLampGrid * kLampGrid;
    for (int first = 0; first < kSamples; first += kLanes) {
      Vec3<F8> directions{};
      F8 reach{}, gain{};
      for (int lane = 0; lane < kLanes; ++lane) {
        const int i = std::min(first + lane, kSamples - 1);
        const int row = i / kLampGrid, column = i % kLampGrid;
        const float s = (static_cast<float>(column) + 0.5f) / kLampGrid * 2 - 1;
        const float t = (static_cast<float>(row) + 0.5f) / kLampGrid * 2 - 1;
        const Vector3f to_lamp = lamp.center + s * lamp.half_u + t * lamp.half_v - from;
        const float distance = to_lamp.norm();
        const Vector3f d = to_lamp / distance;
        directions.x[lane] = d.x();
        directions.y[lane] = d.y();
        directions.z[lane] = d.z();
        reach[lane] = distance;
        gain[lane] =
            first + lane >= kSamples
                ? 0.0f
                : std::max(0.0f, d.dot(normal)) * std::max(0.0f, -d.dot(lamp.normal)) / (distance * distance);
      }
      if (!Any(gain > 0.0f)) continue;
      const F8 visible = Select(Blocked(from, directions, reach), F8{}, gain);
      for (int lane = 0; lane < kLanes; ++lane) sum += visible[lane];
    }
    return lamp.power * sum / kSamples;
  }

  F4 Ambient(const Vector3f& from, const Vector3f& normal) const {
    const Vector3f side = normal.unitOrthogonal(), other = normal.cross(side);
    F4 sum{};
    for (int first = 0; first < kAmbientRays; first += kLanes) {
      Vec3<F8> directions{};
      for (int lane = 0; lane < kLanes; ++lane) {
        const Vector3f& h = hemisphere_[static_cast<std::size_t>(first + lane)];
        const Vector3f d = h.x() * side + h.y() * other + h.z() * normal;
        directions.x[lane] = d.x();
        directions.y[lane] = d.y();
        directions.z[lane] = d.z();
      }
      const I8 blocked = Blocked(from, directions, F8{} + kAmbientReach);
      for (int lane = 0; lane < kLanes; ++lane) {
        const float up = std::clamp(0.5f + directions.z[lane], 0.0f, 1.0f);
        const F4 open = kBounce + up * (kSky - kBounce);
        sum += blocked[lane] ? 0.35f * kBounce : open;
      }
    }
    return sum / static_cast<float>(kAmbientRays);
  }

  const Scene& scene_;
  std::vector<Vector3f> hemisphere_;
  std::vector<Occluder> occluders_;
};

// A coarse map of the light over a chart, interpolated between its samples.
struct LightMap {
  int width = 0, height = 0;
  std::vector<F4> values;

  F4 At(float u, float v) const {
    const float x = std::clamp(u * static_cast<float>(width) - 0.5f, 0.0f, static_cast<float>(width - 1));
    const float y = std::clamp(v * static_cast<float>(height) - 0.5f, 0.0f, static_cast<float>(height - 1));
    const int x0 = std::min(static_cast<int>(x), width - 2), y0 = std::min(static_cast<int>(y), height - 2);
    const float ax = x - static_cast<float>(x0), ay = y - static_cast<float>(y0);
    const F4* row0 = values.data() + static_cast<std::size_t>(y0) * width + x0;
    const F4* row1 = row0 + width;
    const F4 top = row0[0] + ax * (row0[1] - row0[0]), bottom = row1[0] + ax * (row1[1] - row1[0]);
    return top + ay * (bottom - top);
  }
};

int RoundedUp(float length_m, float step_m, int multiple) {
  const int count = static_cast<int>(std::ceil(length_m / step_m / static_cast<float>(multiple)));
  return std::max(1, count) * multiple;
}

MipTexture BakeChart(const Illumination& light, const Primitive& primitive, int chart) {
  const ChartSize size = SizeOfChart(primitive, chart);
  const bool unseen = (primitive.shape == Shape::kFrustum && chart == 2) ||
                      (primitive.main_chart >= 0 && primitive.main_chart != chart);
  const float texel_m = unseen ? kUnseenTexelM : primitive.texel_m;
  const float light_step_m = unseen ? std::max(kUnseenLightM, primitive.light_m) : primitive.light_m;
  const Rigid3 world_from_local = primitive.local_from_world.Inverse();
  LightMap map{std::max(4, RoundedUp(size.width_m, light_step_m, 1)),
               std::max(4, RoundedUp(size.height_m, light_step_m, 1)),
               {}};
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x) {
      const ChartPoint at = PointOnChart(primitive, chart, (static_cast<float>(x) + 0.5f) / map.width,
                                         (static_cast<float>(y) + 0.5f) / map.height);
      map.values.push_back(light.At((world_from_local * at.local.cast<double>()).cast<float>(),
                                    (world_from_local.rotation * at.normal.cast<double>()).cast<float>()));
    }

  constexpr int kMultiple = 32;  // so that every mip level has an even size
  const int width = RoundedUp(size.width_m, texel_m, kMultiple),
            height = RoundedUp(size.height_m, texel_m, kMultiple);
  std::vector<F4> bgr;
  bgr.reserve(static_cast<std::size_t>(width) * height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const float u = (static_cast<float>(x) + 0.5f) / static_cast<float>(width);
      const float v = (static_cast<float>(y) + 0.5f) / static_cast<float>(height);
      const ChartPoint at = PointOnChart(primitive, chart, u, v);
      bgr.push_back(map.At(u, v) * Reflectance(primitive.material, {at.local, u * size.width_m,
                                                                    v * size.height_m, chart, texel_m}));
    }
  return {width, height, size.wrap_u, size.wrap_v, bgr};
}

namespace fs = std::filesystem;

std::uint64_t DigestOf(const Scene& scene) {
  Digest digest;
  digest.Add(std::string(ULF_SCENE_SOURCES));
  for (const Primitive& primitive : scene.primitives()) {
    digest.Add(primitive.local_from_world);
    for (const float size : primitive.size) digest.Add(static_cast<double>(size));
    for (const double value :
         {static_cast<double>(primitive.shape), static_cast<double>(primitive.material),
          static_cast<double>(primitive.texel_m), static_cast<double>(primitive.light_m),
          static_cast<double>(primitive.main_chart), static_cast<double>(primitive.finish)})
      digest.Add(value);
  }
  for (const AreaLight& light : scene.lights()) {
    for (const Eigen::Vector3f* vector : {&light.center, &light.half_u, &light.half_v, &light.normal})
      for (const float value : *vector) digest.Add(static_cast<double>(value));
    digest.Add(static_cast<double>(light.power));
  }
  return digest.Value();
}

// The file has the digest, the number of charts, their sizes, then their texels.
struct FileHead {
  std::uint64_t digest = 0, charts = 0;
};
struct ChartHead {
  std::int32_t width = 0, height = 0, wrap_u = 0, wrap_v = 0;
};

struct MappedFile {
  explicit MappedFile(const fs::path& path) {
    const FileDescriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC));
    if (!file.IsOpen()) return;
    struct stat status {};
    if (fstat(file.Number(), &status) == 0 && status.st_size > 0) {
      size = static_cast<std::size_t>(status.st_size);
      void* mapped = mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file.Number(), 0);
      if (mapped != MAP_FAILED) bytes = static_cast<const std::byte*>(mapped);
    }
  }
  ~MappedFile() {
    if (bytes) munmap(const_cast<std::byte*>(bytes), size);
  }
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  const std::byte* bytes = nullptr;
  std::size_t size = 0;
};

std::optional<std::vector<MipTexture>> Kept(const fs::path& path, std::uint64_t digest) {
  const auto file = std::make_shared<const MappedFile>(path);
  FileHead head;
  if (!file->bytes || file->size < sizeof(head)) return std::nullopt;
  std::memcpy(&head, file->bytes, sizeof(head));
  if (head.digest != digest || head.charts > file->size / sizeof(ChartHead)) return std::nullopt;
  std::size_t at = sizeof(head) + head.charts * sizeof(ChartHead);
  if (at > file->size) return std::nullopt;
  std::vector<MipTexture> charts;
  for (std::size_t i = 0; i < head.charts; ++i) {
    ChartHead chart;
    std::memcpy(&chart, file->bytes + sizeof(head) + i * sizeof(chart), sizeof(chart));
    const std::size_t size = MipTexture::BytesOf(chart.width, chart.height);
    if (size > file->size - at) return std::nullopt;
    charts.emplace_back(chart.width, chart.height, chart.wrap_u != 0, chart.wrap_v != 0,
                        std::shared_ptr<const void>(file, file->bytes + at));
    at += size;
  }
  if (at != file->size) return std::nullopt;
  return charts;
}

void Keep(const fs::path& path, std::uint64_t digest, const std::vector<MipTexture>& charts) {
  std::string bytes;
  const auto add = [&](const void* data, std::size_t size) {
    bytes.append(static_cast<const char*>(data), size);
  };
  const FileHead head{digest, charts.size()};
  add(&head, sizeof(head));
  for (const MipTexture& chart : charts) {
    const ChartHead of_chart{chart.width(), chart.height(), chart.wrap_u(), chart.wrap_v()};
    add(&of_chart, sizeof(of_chart));
  }
  for (const MipTexture& chart : charts) add(chart.Texels().data(), chart.Texels().size());
  try {
    MakeFolder(path.parent_path());
    WriteFileAtomically(path, bytes);
  } catch (const Error&) {  // the next program bakes, too
  }
}

}  // namespace

std::vector<MipTexture> BakeCharts(const Scene& scene) {
  const Illumination light(scene);
  std::vector<std::pair<const Primitive*, int>> work;
  for (const Primitive& primitive : scene.primitives())
    for (int chart = 0; chart < primitive.ChartCount(); ++chart) work.emplace_back(&primitive, chart);
  std::vector<MipTexture> charts(work.size());
  std::atomic<std::size_t> next = 0;
  const auto bake = [&] {
    for (std::size_t i = next++; i < work.size(); i = next++)
      charts[i] = BakeChart(light, *work[i].first, work[i].second);
  };
  std::vector<std::thread> helpers;
  for (unsigned i = 1; i < std::min(kMostBakeThreads, std::thread::hardware_concurrency()); ++i)
    helpers.emplace_back(bake);
  bake();
  for (std::thread& helper : helpers) helper.join();
  return charts;
}

std::vector<MipTexture> KeptOrBakedCharts(const Scene& scene) {
  const char* folder = std::getenv("ULF_BAKED_SCENES");
  return folder && *folder ? KeptOrBakedCharts(scene, folder) : BakeCharts(scene);
}

std::vector<MipTexture> KeptOrBakedCharts(const Scene& scene, const fs::path& folder) {
  const std::uint64_t digest = DigestOf(scene);
  const fs::path path = folder / fmt::format("{:016x}.charts", digest);
  if (auto kept = Kept(path, digest)) return std::move(*kept);
  std::vector<MipTexture> charts = BakeCharts(scene);
  Keep(path, digest, charts);
  return charts;
}

}  // namespace ulf::acquisition
