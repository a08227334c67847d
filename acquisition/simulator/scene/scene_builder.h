// Builds a scene from solids, lamps and the subject, then bakes the light (bake.h). World frame, metres.
#pragma once

#include <memory>

#include "acquisition/simulator/scene/scene.h"

namespace ulf::acquisition {

// Returns a matte solid that is part of the subject, turned about z.
Primitive Matte(Shape shape, const std::array<float, 3>& size, const Eigen::Vector3d& position, int material,
                double turned_deg = 0);

class SceneBuilder {
 public:
  SceneBuilder() : scene_(new Scene) {}

  void Add(Primitive solid);
  // Adds a round rod between two points; `solid` says its material and all else.
  void AddRod(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius, Primitive solid);
  // Adds a sheet of markers (kMarkerSheet, kTurntableSheet) whose front faces -y of `world_from_local`.
  void AddBoard(const Rigid3& world_from_local, int material, bool moves = false);
  // Adds the plaster room that encloses a scene, 4.6 by 4.4 by 3.1 m; its far wall is 5 cm beyond `wall_y`.
  void AddRoom(double wall_y);
  // Adds that room, a stone wall 0.55 m behind the origin, and a terrazzo table whose top is at z = 0.
  void AddStudio();
  void AddStudioLamps();
  // Adds a lamp that shines from `center` towards `at`. `power`: see AreaLight.
  void AddLight(const Eigen::Vector3f& center, const Eigen::Vector3f& at, float half_width, float half_height,
                float power);

  void SetSubject(const Eigen::Vector3d& center, double radius) { scene_->subject_ = {center, radius}; }
  // Sets the subject's sphere around `center`, large enough for the solids that belong to it.
  void EncloseSubject(const Eigen::Vector3d& center);
  void SetSway(const Sway& sway) { scene_->sway_ = sway; }
  // Bakes the scene; call it last. Both parameters say where from the subject a capture starts (Scene).
  std::shared_ptr<const Scene> Finish(const Eigen::Vector3d& first_direction, double first_distance = 1);

 private:
  std::shared_ptr<Scene> scene_;
};

Eigen::Quaterniond TurnedAbout(const Eigen::Vector3d& axis, double degrees);

}  // namespace ulf::acquisition
