// A proxy of tracked points. For each camera the points that it sees are triangulated in its image
// (Delaunay), and inverse depth is linear over a triangle (thesis, section 5.4; Buehler et al. 2001). A point
// whose depth differs from all its neighbours' gets their median. Points around the image, whose depths are
// extrapolated, extend the triangles past its edges.
#pragma once

#include <vector>

#include "core/base/mutex.h"
#include "render/proxy/proxy.h"

namespace ulf::render {

class PointsProxy : public Proxy {
 public:
  static constexpr std::size_t kFewest = 4;
  // Takes world points and ignores those that are not finite. Throws Error for fewer than kFewest.
  PointsProxy(const Subject& subject, const std::vector<ScenePoint>& points);
  std::string Name() const override { return "points"; }
  std::uint64_t Fingerprint() const override;
  PlaneInCamera Background(const Rigid3& cam_from_world) const override {
    return PlaneThroughSubject(subject_, cam_from_world);
  }
  // Returns null if the camera sees fewer than kFewest points. Several threads may call it.
  std::shared_ptr<const TriangleMesh> Triangles(const CameraModel& camera,
                                                const Rigid3& cam_from_world) const override;

 private:
  Subject subject_;
  std::vector<Eigen::Vector3d> points_;
  // The result for the last camera is cached.
  mutable Mutex mutex_;
  mutable CameraModel last_camera_ ULF_GUARDED_BY(mutex_);
  mutable std::optional<Eigen::Matrix4d> last_cam_from_world_ ULF_GUARDED_BY(mutex_);
  mutable std::shared_ptr<const TriangleMesh> last_ ULF_GUARDED_BY(mutex_);
};

}  // namespace ulf::render
