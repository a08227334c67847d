#include "core/light_field/formats/colmap_files.h"

#include <fmt/format.h>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/geometry/byte_stream.h"
#include "core/light_field/formats/colmap_rigs.h"

namespace ulf {
namespace {

void PutCount(std::size_t count, ByteWriter& out) { out.Put(static_cast<std::uint64_t>(count)); }

std::string CamerasBin(const ColmapReconstruction& model) {
  ByteWriter out;
  PutCount(model.cameras.size(), out);
  for (const ColmapReconstruction::Camera& camera : model.cameras) {
    out.Put(camera.id);
    out.Put(static_cast<std::int32_t>(camera.model));
    out.Put(camera.width);
    out.Put(camera.height);
    for (const double parameter : camera.parameters) out.Put(parameter);
  }
  return std::move(out.bytes());
}

std::string ImagesBin(const ColmapReconstruction& model) {
  ByteWriter out;
  PutCount(model.images.size(), out);
  for (const ColmapReconstruction::Image& image : model.images) {
    const Eigen::Quaterniond& q = image.cam_from_world.rotation;
    out.Put(image.id);
    for (const double part : {q.w(), q.x(), q.y(), q.z()}) out.Put(part);
    out.Put(image.cam_from_world.translation);
    out.Put(image.camera);
    out.PutText(image.name);
    out.Put('\0');
    PutCount(image.points.size(), out);
    for (const ColmapReconstruction::Point2d& seen : image.points) {
      out.Put(seen.in_img);
      out.Put(seen.point);
    }
  }
  return std::move(out.bytes());
}

std::string Points3dBin(const ColmapReconstruction& model) {
  ByteWriter out;
  PutCount(model.points.size(), out);
  for (const ColmapReconstruction::Point& point : model.points) {
    out.Put(point.id);
    out.Put(point.position);
    out.Put(point.rgb);
    out.Put(point.error_px);
    PutCount(point.track.size(), out);
    for (const ColmapReconstruction::Seen& seen : point.track) {
      out.Put(seen.image);
      out.Put(seen.index);
    }
  }
  return std::move(out.bytes());
}

void RequireWhole(const ByteReader& in, const std::filesystem::path& file) {
  if (in.IsShort())
    throw Error(
        "{}: is cut short, or a count in it is wrong; copy it again, or write the model anew ('colmap "
        "model_converter')",
        file.string());
}

// Reads a count, and as many items of at least `least` bytes each.
template <typename Item, typename Read>
void ReadItems(const std::filesystem::path& file, std::size_t least, std::vector<Item>& items,
               const Read& read) {
  const std::string bytes = ReadWholeFile(file);
  ByteReader in(bytes);
  const std::size_t count = in.Count64(least);
  for (std::size_t i = 0; i < count && !in.IsShort(); ++i) read(in, items.emplace_back());
  RequireWhole(in, file);
}

void ReadCamerasBin(const std::filesystem::path& file, ColmapReconstruction& model) {
  constexpr std::size_t kLeastBytes = 24;
  ReadItems(file, kLeastBytes, model.cameras, [&](ByteReader& in, ColmapReconstruction::Camera& camera) {
    camera.id = in.Get<std::uint32_t>();
    camera.model = in.Get<std::int32_t>();
    camera.width = in.Get<std::uint64_t>();
    camera.height = in.Get<std::uint64_t>();
    RequireWhole(in, file);
    const std::string where = fmt::format("{}, camera {}", file.string(), camera.id);
    for (std::size_t left = ColmapParameters(camera.model, where); left > 0; --left)
      camera.parameters.push_back(in.Get<double>());
  });
}

void ReadImagesBin(const std::filesystem::path& file, ColmapReconstruction& model) {
  constexpr std::size_t kLeastBytes = 73, kPointBytes = 24;
  ReadItems(file, kLeastBytes, model.images, [&](ByteReader& in, ColmapReconstruction::Image& image) {
    image.id = in.Get<std::uint32_t>();
    Eigen::Quaterniond& q = image.cam_from_world.rotation;
    for (const int part : {3, 0, 1, 2}) q.coeffs()(part) = in.Get<double>();
    image.cam_from_world.translation = in.Get3();
    image.camera = in.Get<std::uint32_t>();
    image.name = in.GetText();
    RequireWhole(in, file);
    image.points.resize(in.Count64(kPointBytes));
    for (ColmapReconstruction::Point2d& point : image.points) {
      point.in_img = in.Get2();
      point.point = in.Get<std::uint64_t>();
    }
  });
}

void ReadPoints3dBin(const std::filesystem::path& file, ColmapReconstruction& model) {
  constexpr std::size_t kLeastBytes = 51, kSeenBytes = 8;
  ReadItems(file, kLeastBytes, model.points, [](ByteReader& in, ColmapReconstruction::Point& point) {
    point.id = in.Get<std::uint64_t>();
    point.position = in.Get3();
    point.rgb = in.Get<std::array<std::uint8_t, 3>>();
    point.error_px = in.Get<double>();
    point.track.resize(in.Count64(kSeenBytes));
    for (ColmapReconstruction::Seen& seen : point.track) {
      seen.image = in.Get<std::uint32_t>();
      seen.index = in.Get<std::uint32_t>();
    }
  });
}

}  // namespace

ColmapFiles ToColmapBinary(const ColmapReconstruction& model) {
  return {CamerasBin(model), ImagesBin(model), Points3dBin(model)};
}

ColmapReconstruction ReadColmapBinary(const std::filesystem::path& dir) {
  ColmapReconstruction model;
  ReadCamerasBin(dir / "cameras.bin", model);
  ReadImagesBin(dir / "images.bin", model);
  if (std::filesystem::exists(dir / "points3D.bin")) ReadPoints3dBin(dir / "points3D.bin", model);
  SettleColmapPoses(dir, true, model);
  return model;
}

}  // namespace ulf
