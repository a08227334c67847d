// A mesh with the depth maps of the recorded views: geometry in which each view has its own surface (Penner
// and Zhang 2017, "Soft 3D reconstruction for view synthesis"). The soft field reads the maps; all other
// fields use the mesh.
#pragma once

#include <map>
#include <memory>

#include "render/proxy/proxy.h"
#include "render/proxy/view_depth_map.h"

namespace ulf::render {

class SoftProxy : public MeshProxy {
 public:
  using Maps = std::map<int, std::shared_ptr<const LazyDepthMap>>;  // by View::id
  static Maps InMemory(std::map<int, ViewDepthMap> maps);           // for maps that need not be read
  // `of_maps` is a digest of the maps, for Fingerprint().
  SoftProxy(const Subject& subject, std::shared_ptr<const TriangleMesh> mesh, Maps maps,
            std::uint64_t of_maps = 0);
  std::uint64_t Fingerprint() const override;
  bool HasDepthMaps() const override { return true; }
  // Returns for a view without its own map the mesh as the view sees it.
  std::shared_ptr<const LazyDepthMap> DepthMapOf(int view_id, const CameraModel& camera,
                                                 const Rigid3& cam_from_world) const override;

 private:
  Maps maps_;
  std::uint64_t of_maps_;
};

}  // namespace ulf::render
