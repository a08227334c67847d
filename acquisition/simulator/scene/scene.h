// Defines the simulator's scenes: solids with painted, lit surfaces, in metres; world z is up.
//
// docs/devices.md#the-simulated-camera-sim-and-ulf-simulate says what is in each scene, and why it is hard.
//
// The lamps do not move. All view-independent radiance is therefore computed once and baked into mip-mapped
// textures: reflectance times irradiance (a large area light with exact penumbras, ambient light with
// occlusion). Mirror images and glass depend on the viewpoint; surface_light.h computes them. Moving parts
// keep the light, and cast the shadows, that they have at rest. Not simulated: indirect light beyond a
// constant term, caustics, light that glowing things (Primitive::glow) cast on others, lens blur.
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

// A rectangular lamp that shines towards its normal (unit length). Its corners are
// center +- half_u +- half_v, metres, world frame.
struct AreaLight {
  Eigen::Vector3f center, half_u, half_v, normal;
  float power = 1;  // irradiance at one metre on a surface that faces it; 1 gives a white card radiance 1
};

// A printed board that stands in the scene.
struct StandingBoard {
  Board board;
  Rigid3 board_from_world;  // metres, the frame of core/fiducials/board.h
};

// The motion of the parts with Primitive::moves, as a pendulum or a turntable: a rotation about an axis (unit
// length) through a pivot, world frame.
struct Sway {
  Eigen::Vector3d pivot = Eigen::Vector3d::Zero(), axis = Eigen::Vector3d::UnitY();
  double amplitude = 0;  // radians; with period_s, of a pendulum only
  double period_s = 1;
  bool goes_round = false;  // a turntable, as fast as SimulationOptions::turn_speed says
};

// The first surface along a ray, and its distance in metres.
struct Hit {
  double distance = std::numeric_limits<double>::infinity();
  int part = -1;  // index into Scene::primitives()
};

class Scene {
 public:
  // Returns a scene. The first call builds it, which takes seconds; later calls share it. Several threads may
  // call it. Throws Refusal, which lists the names, for any other name.
  static std::shared_ptr<const Scene> Named(const std::string& name);
  static std::vector<std::string> Names();

  const std::vector<Primitive>& primitives() const { return primitives_; }
  // Returns the baked radiance of a chart; `index` is Primitive::first_chart + SurfacePoint::chart.
  const MipTexture& Chart(int index) const { return charts_[static_cast<std::size_t>(index)]; }
  const std::vector<AreaLight>& lights() const { return lights_; }

  // Returns the subject's bounding sphere.
  const Subject& subject() const { return subject_; }
  Eigen::Vector3d UpInWorld() const { return Eigen::Vector3d::UnitZ(); }
  // Returns the board of `easel` or `turntable`, with the turntable at rest; none in other scenes.
  const std::optional<StandingBoard>& board() const { return board_; }
  // Return where a capture starts: direction (unit length) and distance (metres) from the subject's centre.
  const Eigen::Vector3d& FirstDirection() const { return first_direction_; }
  double FirstDistance() const { return first_distance_; }

  // Returns the motion in `branch` or `turntable`; none in other scenes.
  const std::optional<Sway>& sway() const { return sway_; }
  bool IsTurntable() const { return sway_ && sway_->goes_round; }
  // Returns the angle, radians, of a swing that began `since_s` ago and grows and dies away within `lasts_s`.
  // It is 0 before and after, where nothing sways, and for a turntable (see SimulatedCamera::SwayAngle).
  double SwayAngle(double since_s, double lasts_s) const;
  // Returns the transform, in the world frame, that moves a moving part from rest to that angle.
  Rigid3 MovedFromRest(double sway_angle) const;

  // Returns the first surface along a unit direction, in double precision; there is one, because the room
  // encloses the scene. `through_glass` leaves out surfaces of glass.
  Hit FirstHit(const Eigen::Vector3d& origin_in_world, const Eigen::Vector3d& direction_in_world,
               double sway_angle = 0, bool through_glass = false) const;
  // Return the distance of that surface, and the solid, with moving parts at rest unless an angle is given.
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
