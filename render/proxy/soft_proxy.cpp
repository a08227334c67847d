#include "render/proxy/soft_proxy.h"

#include <algorithm>
#include <utility>

namespace ulf::render {
namespace {

// Longer side of the map of a view without its own: the mesh has no more detail. Guessed.
constexpr int kMeshMapPx = 480;
// Uncertainty of such a map's inverse depths, as a share. Guessed.
constexpr double kMeshMapStep = 0.005;

CameraModel MapCamera(const CameraModel& view) {
  const double share = std::min(1.0, kMeshMapPx / static_cast<double>(std::max(view.width, view.height)));
  return view
      .ScaledTo(std::max(1, static_cast<int>(share * view.width)),
                std::max(1, static_cast<int>(share * view.height)))
      .WithoutDistortion();
}

}  // namespace

SoftProxy::Maps SoftProxy::InMemory(std::map<int, ViewDepthMap> maps) {
  Maps in_memory;
  for (auto& [view, map] : maps)
    in_memory.emplace(view, std::make_shared<LazyDepthMap>([map = std::move(map)] { return map; }));
  return in_memory;
}

SoftProxy::SoftProxy(const Subject& subject, std::shared_ptr<const TriangleMesh> mesh, Maps maps,
                     std::uint64_t of_maps)
    : MeshProxy(subject, std::move(mesh), "soft"), maps_(std::move(maps)), of_maps_(of_maps) {}

std::uint64_t SoftProxy::Fingerprint() const {
  std::uint64_t sum = MeshProxy::Fingerprint() ^ of_maps_;
  for (const auto& [view, map] : maps_) sum = 1099511628211u * sum + static_cast<std::uint64_t>(view);
  return sum;
}

std::shared_ptr<const LazyDepthMap> SoftProxy::DepthMapOf(int view_id, const CameraModel& camera,
                                                          const Rigid3& cam_from_world) const {
  if (const auto found = maps_.find(view_id); found != maps_.end()) return found->second;
  return std::make_shared<LazyDepthMap>([mesh = Occluder(), camera = MapCamera(camera), cam_from_world] {
    ViewDepthMap map = DepthMapOfMesh(*mesh, camera, cam_from_world, 0);
    double most = 0;
    cv::minMaxLoc(map.inverse_depth, nullptr, &most);
    map.step = kMeshMapStep * map.unit * std::max(1.0, most);
    return map;
  });
}

}  // namespace ulf::render
