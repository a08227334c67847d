// Defines the simulator's scenes: solids with painted, lit surfaces, in metres; world z is up.
//
// docs/devices.md#the-simulated-camera-sim-and-ulf-simulate says what is in each, and what is hard about it.
//
// The lamps do not move. All view-independent radiance is therefore computed once and baked into mip-mapped
// textures: reflectance times irradiance (a large area light with exact penumbras, ambient light with
// occlusion). What depends on the viewpoint, mirror images and glass, is in surface_light.h. What sways keeps
// the light and the shadows that it has at rest. Not simulated: indirect light beyond a constant term, light
// bent by glass onto other things, light of what shines by itself (Primitive::glow) onto others, lens blur.
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

// The motion of a pendulum or a turntable: a rotation about an axis through a pivot, world frame.
struct Sway {
  Eigen::Vector3d pivot = Eigen::Vector3d::Zero(), axis = Eigen::Vector3d::UnitY();
  double amplitude = 0;  // radians
  double period_s = 1;
  bool goes_round = false;  // a turntable, as fast as SimulationOptions::turn_speed says
};

// The first surface along a ray.
struct Hit {
  double distance = std::numeric_limits<double>::infinity();
  int part = -1;  // index into Scene::primitives()
};

class Scene {
 public:
  // Built on first use and shared from then on. Throws Refusal that lists the scenes for any other name.
  static std::shared_ptr<const Scene> Named(const std::string& name);
  static std::vector<std::string> Names();

  const std::vector<Primitive>& primitives() const { return primitives_; }
  const MipTexture& Chart(int index) const { return charts_[static_cast<std::size_t>(index)]; }
  const std::vector<AreaLight>& lights() const { return lights_; }

  // Returns the sphere that encloses the subject: exact geometry, no estimate.
  const Subject& subject() const { return subject_; }
  Eigen::Vector3d UpInWorld() const { return Eigen::Vector3d::UnitZ(); }
  // Returns the board, only in the scenes `easel` and `turntable`, with the turntable at rest.
  const std::optional<StandingBoard>& board() const { return board_; }
  // Return where a capture starts: the direction from the subject, unit length, and the distance.
  const Eigen::Vector3d& FirstDirection() const { return first_direction_; }
  double FirstDistance() const { return first_distance_; }

  // Returns the motion, only in the scenes `branch` and `turntable`.
  const std::optional<Sway>& sway() const { return sway_; }
  bool IsTurntable() const { return sway_ && sway_->goes_round; }
  // Returns the angle of what moves, `since_s` after it has begun to: a swing that grows and dies away within
  // `lasts_s`; 0 before and after, and in scenes where nothing sways.
  double SwayAngle(double since_s, double lasts_s) const;
  // Returns the motion of a moving part from rest to that angle.
  Rigid3 MovedFromRest(double sway_angle) const;

  // Returns the first surface along a unit direction, in double precision; there is one, because the room
  // encloses the scene. Glass is a surface like others.
  Hit FirstHit(const Eigen::Vector3d& origin_in_world, const Eigen::Vector3d& direction_in_world,
               double sway_angle = 0, bool through_glass = false) const;
  double DepthAlong(const Eigen::Vector3d& origin_in_world, const Eigen::Vector3d& direction_in_world,
                    double sway_angle = 0) const {
    return FirstHit(origin_in_world, direction_in_world, sway_angle).distance;
  }
  int PartAlong(const Eigen::Vector3d& origin_in_world, const Eigen::Vector3d& direction_in_world) const {
    return FirstHit(origin_in_world, direction_in_world).part;
  }

 private:
  friend class SceneBuilder;
  Scene() = default;
  struct Bound {
    Eigen::Vector3d center_in_world;  // at rest
    double radius;
  };
  std::vector<Primitive> primitives_;
  std::vector<Bound> bounds_;  // of the primitives
  std::vector<MipTexture> charts_;
  std::vector<AreaLight> lights_;
  Subject subject_;
  std::optional<StandingBoard> board_;
  std::optional<Sway> sway_;
  Eigen::Vector3d first_direction_;
  double first_distance_ = 1;
};

}  // namespace ulf::acquisition
