// Builds a scene from solids, lamps and the subject, then bakes the light.
#pragma once

#include <memory>

#include "acquisition/simulator/scene/scene.h"

namespace ulf::acquisition {

struct Solid {
  Shape shape = Shape::kSphere;
  std::array<float, 3> size{};
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  int material = 0;
  float texel_m = 0.001f, light_m = 0.003f;
  bool of_subject = true;
  Finish finish = Finish::kMatte;
  float mirrored = 0.045f;
  float glow = 1;
  bool thin = false, moves = false;
  int main_chart = -1;
  Eigen::Quaterniond world_from_local = Eigen::Quaterniond::Identity();
};

class SceneBuilder {
 public:
  SceneBuilder() : scene_(new Scene) {}

  void Add(const Solid& solid);
  // Adds a round rod between two points of the world; `solid` says the rest.
  void AddRod(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius, Solid solid);
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
  // Bakes the scene. A capture starts in `first_direction` from the subject, at `first_distance`.
  std::shared_ptr<const Scene> Finish(const Eigen::Vector3d& first_direction, double first_distance = 1);

 private:
  std::shared_ptr<Scene> scene_;
};

Eigen::Quaterniond TurnedAbout(const Eigen::Vector3d& axis, double degrees);

}  // namespace ulf::acquisition
