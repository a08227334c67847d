// The simulator's scenes: solids with painted, lit surfaces, in metres; world z is up.
//
//   studio  a still life (spheres, carton, can, cone, ring on a plinth; the dark sphere is glazed) on a
//           terrazzo table in front of a stone wall
//   easel   the studio, and a board of markers on an easel beside the subject (its frame is the board's)
//   wall    one plane covered with posters: the degenerate case for two-view initialisation
//
// The lights do not move. All view-independent radiance is therefore computed once and baked into mip-mapped
// textures: reflectance times irradiance (a large area light with exact penumbras, ambient light with
// occlusion). Only the mirror image of the lamps in the glaze depends on the viewpoint. Not simulated:
// indirect light beyond a constant term, refraction, lens blur.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/simulator/scene/primitive.h"
#include "acquisition/simulator/scene/texture.h"
#include "core/fiducials/board.h"
#include "core/light_field/light_field.h"

namespace ulf::acquisition {

// A rectangular lamp that shines towards its normal.
struct AreaLight {
  Eigen::Vector3f center, half_u, half_v, normal;
  float power = 1;  // irradiance on a surface that faces it at one metre, unshadowed
};

// A printed board that stands in the scene.
struct StandingBoard {
  Board board;
  Rigid3 board_from_world;  // metres, the frame of core/fiducials/board.h
};

class Scene {
 public:
  // Built on first use and shared from then on. Throws UsageError that lists the scenes for any other name.
  static std::shared_ptr<const Scene> Named(const std::string& name);
  static std::vector<std::string> Names();

  const std::vector<Primitive>& primitives() const { return primitives_; }
  const MipTexture& Chart(int index) const { return charts_[static_cast<std::size_t>(index)]; }
  const std::vector<AreaLight>& lights() const { return lights_; }

  // The sphere that encloses the subject: exact geometry, no estimate.
  const Subject& subject() const { return subject_; }
  Eigen::Vector3d UpInWorld() const { return Eigen::Vector3d::UnitZ(); }
  // Only in the scene `easel`.
  const std::optional<StandingBoard>& board() const { return board_; }
  // From the subject to where a capture starts, unit, and how far away.
  const Eigen::Vector3d& FirstDirection() const { return first_direction_; }
  double FirstDistance() const { return 1.0; }

  // Distance along a unit direction to the first surface, in double precision; finite, because the room
  // encloses the scene.
  double DepthAlong(const Eigen::Vector3d& origin_in_world, const Eigen::Vector3d& direction_in_world) const;
  // The solid at this distance: index into primitives().
  int PartAlong(const Eigen::Vector3d& origin_in_world, const Eigen::Vector3d& direction_in_world) const;

  // The radiance of the lamps and the room, reflected at a mirror with this normal. World frame.
  F4 GlossRadiance(const Eigen::Vector3f& point, const Eigen::Vector3f& normal,
                   const Eigen::Vector3f& direction) const;

 private:
  friend class SceneBuilder;
  Scene() = default;
  std::vector<Primitive> primitives_;
  std::vector<MipTexture> charts_;
  std::vector<AreaLight> lights_;
  Subject subject_;
  std::optional<StandingBoard> board_;
  Eigen::Vector3d first_direction_;
};

}  // namespace ulf::acquisition
