#include "acquisition/simulator/scene/kept_charts.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "acquisition/simulator/scene/bake.h"
#include "acquisition/simulator/scene/scene.h"
#include "core/base/atomic_file.h"
#include "core/base/descriptor.h"
#include "core/base/error.h"
#include "core/geometry/digest.h"

namespace ulf::acquisition {
namespace {

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

// The file: the digest, the number of charts, their sizes, then their texels.
struct FileHead {
  std::uint64_t digest = 0, charts = 0;
};
struct ChartHead {
  std::int32_t width = 0, height = 0, wrap_u = 0, wrap_v = 0;
};

struct MappedFile {
  explicit MappedFile(const fs::path& path) {
    const Descriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC));
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
