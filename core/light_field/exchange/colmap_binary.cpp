#include "core/light_field/exchange/colmap_binary.h"

#include "core/geometry/byte_stream.h"

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

}  // namespace

ColmapFiles ToColmapBinary(const ColmapReconstruction& model) {
  return {CamerasBin(model), ImagesBin(model), Points3dBin(model)};
}

}  // namespace ulf
