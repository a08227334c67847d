#include "acquisition/simulator/scene/scene_builder.h"

#include "acquisition/simulator/scene/bake.h"
#include "acquisition/simulator/scene/materials.h"
#include "core/geometry/angles.h"
#include "core/geometry/small_matrices.h"

namespace ulf::acquisition {

using Eigen::Vector3d;
using Eigen::Vector3f;

Primitive Matte(Shape shape, const std::array<float, 3>& size, const Vector3d& position, int material,
                double turned_deg) {
  return {.shape = shape,
          .size = size,
          .position = position,
          .material = material,
          .world_from_local = TurnedAbout(Vector3d::UnitZ(), turned_deg)};
}

void SceneBuilder::Add(Primitive solid) {
  const bool curved =
      solid.shape == Shape::kSphere || solid.shape == Shape::kFrustum || solid.shape == Shape::kBust;
  CV_Assert(curved || solid.finish == Finish::kMatte);
  solid.local_from_world = Rigid3{solid.world_from_local, solid.position}.Inverse();
  scene_->primitives_.push_back(solid);
}

void SceneBuilder::AddRod(const Vector3d& from, const Vector3d& to, double radius, Primitive solid) {
  const Vector3d along = to - from;
  solid.shape = Shape::kFrustum;
  solid.size = {static_cast<float>(radius), static_cast<float>(radius), static_cast<float>(along.norm())};
  solid.position = from;
  solid.world_from_local = TurnBetween(Vector3d::UnitZ(), along);
  Add(solid);
}

void SceneBuilder::AddRoom(double wall_y) {
  Add({.shape = Shape::kRoom,
       .size = {2.3f, 2.2f, 1.55f},
       .position = {0, wall_y - 2.15, 0.8},
       .material = material::kPlaster,
       .texel_m = 0.012f,
       .light_m = 0.12f,
       .of_subject = false});
}

void SceneBuilder::AddStudio() {
  constexpr double kWallY = 0.55;
  constexpr int kTowardsHand = 3, kTop = 4;  // a box's faces
  AddRoom(kWallY);
  Add({.shape = Shape::kBox,
       .size = {2.2f, 0.02f, 1.5f},
       .position = {0, kWallY + 0.02, 0.78},
       .material = material::kFieldstone,
       .texel_m = 0.003f,
       .light_m = 0.03f,
       .of_subject = false,
       .main_chart = kTowardsHand});
  Add({.shape = Shape::kBox,
       .size = {1.15f, 0.75f, 0.02f},
       .position = {0, kWallY - 0.75, -0.02},
       .material = material::kTerrazzo,
       .texel_m = 0.0017f,
       .light_m = 0.008f,
       .of_subject = false,
       .main_chart = kTop});
}

void SceneBuilder::AddStudioLamps() {
  AddLight({-1.25f, -0.45f, 1.3f}, {0, 0, 0.1f}, 0.26f, 0.26f, 4.0f);
  AddLight({1.3f, -1.1f, 0.9f}, {0, 0, 0.1f}, 0.16f, 0.45f, 0.45f);
}

void SceneBuilder::AddLight(const Vector3f& center, const Vector3f& at, float half_width, float half_height,
                            float power) {
  const Vector3f normal = (at - center).normalized();
  const Vector3f u = normal.cross(Vector3f::UnitZ()).normalized(), v = u.cross(normal);
  scene_->lights_.push_back({center, half_width * u, half_height * v, normal, power});
}

void SceneBuilder::AddBoard(const Rigid3& world_from_local, int material, bool moves) {
  const Board& board = MarkerSheet::BoardOf(material);
  constexpr float kHalfThickness = 0.003f;
  constexpr int kFront = 3;
  Add({.shape = Shape::kBox,
       .size = {static_cast<float>(0.5 * MarkerSheet::WidthM(board)), kHalfThickness,
                static_cast<float>(0.5 * MarkerSheet::HeightM(board))},
       .position = world_from_local.translation,
       .material = material,
       .texel_m = 0.0005f,
       .light_m = 0.01f,
       .of_subject = false,
       .moves = moves,
       .main_chart = kFront,
       .world_from_local = world_from_local.rotation});
  // Local x to the right, z up, -y towards the viewer; of the board x to the right, y down, z into the
  // sheet.
  Eigen::Matrix3d board_from_local;
  board_from_local << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  const Rigid3 in_board{Eigen::Quaterniond(board_from_local),
                        {0.0005 * board.WidthMm(), 0.0005 * board.HeightMm(), kHalfThickness}};
  scene_->board_ = StandingBoard{board, in_board * world_from_local.Inverse()};
}

void SceneBuilder::EncloseSubject(const Vector3d& center) {
  double radius = 0;
  for (const Primitive& primitive : scene_->primitives_)
    if (primitive.of_subject) radius = std::max(radius, primitive.FarthestFrom(center));
  scene_->subject_ = {center, radius};
}

std::shared_ptr<const Scene> SceneBuilder::Finish(const Vector3d& first_direction, double first_distance) {
  scene_->first_direction_ = first_direction.normalized();
  scene_->first_distance_ = first_distance;
  int charts = 0;
  for (Primitive& primitive : scene_->primitives_) {
    primitive.first_chart = charts;
    charts += primitive.ChartCount();
    const Vec3<float> middle = primitive.BoundCenter();
    scene_->bounds_.push_back({primitive.local_from_world.Inverse() * Vector3d(middle.x, middle.y, middle.z),
                               static_cast<double>(primitive.BoundRadius())});
  }
  scene_->charts_ = KeptOrBakedCharts(*scene_);
  return scene_;
}

Eigen::Quaterniond TurnedAbout(const Vector3d& axis, double degrees) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(Radians(degrees), axis.normalized()));
}

}  // namespace ulf::acquisition
