#include "acquisition/simulator/scene/scene.h"

#include <fmt/format.h>

#include <map>

#include "acquisition/simulator/scene/bake.h"
#include "acquisition/simulator/scene/materials.h"
#include "core/base/error.h"
#include "core/base/mutex.h"
#include "core/geometry/angles.h"

namespace ulf::acquisition {

using Eigen::Vector3d;
using Eigen::Vector3f;

// Places solids, then bakes their charts.
class SceneBuilder {
 public:
  struct Solid {
    Shape shape = Shape::kSphere;
    std::array<float, 3> size{};
    Vector3d position = Vector3d::Zero();
    int material = 0;
    float texel_m = 0.001f, light_m = 0.003f;
    bool of_subject = true;
    bool glossy = false;
    int main_chart = -1;
    Eigen::Quaterniond world_from_local = Eigen::Quaterniond::Identity();
  };

  SceneBuilder() : scene_(new Scene) {}

  void Add(const Solid& solid) {
    Primitive primitive;
    primitive.shape = solid.shape;
    primitive.size = solid.size;
    primitive.local_from_world = Rigid3{solid.world_from_local, solid.position}.Inverse();
    primitive.material = solid.material;
    primitive.texel_m = solid.texel_m;
    primitive.light_m = solid.light_m;
    primitive.of_subject = solid.of_subject;
    primitive.glossy = solid.glossy;
    primitive.main_chart = solid.main_chart;
    scene_->primitives_.push_back(primitive);
  }

  void AddLight(const Vector3f& center, const Vector3f& at, float half_width, float half_height,
                float power) {
    const Vector3f normal = (at - center).normalized();
    const Vector3f u = normal.cross(Vector3f::UnitZ()).normalized(), v = u.cross(normal);
    scene_->lights_.push_back({center, half_width * u, half_height * v, normal, power});
  }

  void SetSubject(const Vector3d& center, double radius) { scene_->subject_ = {center, radius}; }

  // Adds a sheet of markers whose front faces -y of `world_from_local`.
  void AddBoard(const Rigid3& world_from_local) {
    const Board board = MarkerSheet::PrintedBoard();
    constexpr float kHalfThickness = 0.003f;
    constexpr int kFront = 3;
    Add({.shape = Shape::kBox,
         .size = {static_cast<float>(0.5 * MarkerSheet::WidthM()), kHalfThickness,
                  static_cast<float>(0.5 * MarkerSheet::HeightM())},
         .position = world_from_local.translation,
         .material = material::kMarkerSheet,
         .texel_m = 0.0005f,
         .light_m = 0.01f,
         .of_subject = false,
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

  void EncloseSubject(const Vector3d& center) {
    double radius = 0;
    for (const Primitive& primitive : scene_->primitives_)
      if (primitive.of_subject) radius = std::max(radius, primitive.FarthestFrom(center));
    scene_->subject_ = {center, radius};
  }

  std::shared_ptr<const Scene> Finish(const Vector3d& first_direction) {
    scene_->first_direction_ = first_direction.normalized();
    int charts = 0;
    for (Primitive& primitive : scene_->primitives_) {
      primitive.first_chart = charts;
      charts += primitive.ChartCount();
    }
    scene_->charts_ = BakeCharts(*scene_);
    return scene_;
  }

 private:
  std::shared_ptr<Scene> scene_;
};

namespace {

Eigen::Quaterniond TurnedAbout(const Vector3d& axis, double degrees) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(Radians(degrees), axis.normalized()));
}

void AddRoom(SceneBuilder& builder, double wall_y) {
  // x -2.3..2.3, z -0.75..2.35; the wall is a solid of its own, finer than the rest of the room.
  builder.Add({.shape = Shape::kRoom,
               .size = {2.3f, 2.2f, 1.55f},
               .position = {0, wall_y - 2.15, 0.8},
               .material = material::kPlaster,
               .texel_m = 0.012f,
               .light_m = 0.12f,
               .of_subject = false});
}

std::shared_ptr<const Scene> BuildStudioWith(bool easel) {
  SceneBuilder builder;
  constexpr double kWallY = 0.55, kPlinth = 0.026;
  AddRoom(builder, kWallY);
  constexpr int kTowardsHand = 3, kTop = 4;  // a box's faces
  builder.Add({.shape = Shape::kBox,
               .size = {2.2f, 0.02f, 1.5f},
               .position = {0, kWallY + 0.02, 0.78},
               .material = material::kFieldstone,
               .texel_m = 0.003f,
               .light_m = 0.03f,
               .of_subject = false,
               .main_chart = kTowardsHand});
  builder.Add({.shape = Shape::kBox,
               .size = {1.15f, 0.75f, 0.02f},
               .position = {0, kWallY - 0.75, -0.02},
               .material = material::kTerrazzo,
               .texel_m = 0.0017f,
               .light_m = 0.008f,
               .of_subject = false,
               .main_chart = kTop});

  const Vector3d z = Vector3d::UnitZ();
  builder.Add({.shape = Shape::kFrustum,
               .size = {0.146f, 0.14f, kPlinth},
               .position = {0, 0, 0},
               .material = material::kMosaic});
  builder.Add({.shape = Shape::kBox,
               .size = {0.042f, 0.034f, 0.06f},
               .position = {-0.056, 0.046, kPlinth + 0.06},
               .material = material::kPrinted,
               .world_from_local = TurnedAbout(z, 24)});
  builder.Add({.shape = Shape::kSphere,
               .size = {0.029f, 0, 0},
               .position = {-0.056, 0.046, kPlinth + 0.12 + 0.029},
               .material = material::kRedTerrazzo});
  builder.Add({.shape = Shape::kSphere,
               .size = {0.056f, 0, 0},
               .position = {0.058, 0.03, kPlinth + 0.056},
               .material = material::kMarbled,
               .world_from_local = TurnedAbout({1, 2, 0.5}, 40)});
  builder.Add({.shape = Shape::kFrustum,
               .size = {0.028f, 0.028f, 0.13f},
               .position = {0.018, 0.104, kPlinth},
               .material = material::kLabel,
               .world_from_local = TurnedAbout(z, 70)});
  builder.Add({.shape = Shape::kFrustum,
               .size = {0.031f, 0.005f, 0.104f},
               .position = {0.09, -0.056, kPlinth},
               .material = material::kPatchwork});
  builder.Add({.shape = Shape::kSphere,
               .size = {0.038f, 0, 0},
               .position = {0.012, -0.056, kPlinth + 0.038},
               .material = material::kGlaze,
               .glossy = true});
  // The ring leans against the carton.
  builder.Add({.shape = Shape::kTorus,
               .size = {0.039f, 0.0125f, 0},
               .position = {-0.08, -0.04, kPlinth + 0.046},
               .material = material::kBanded,
               .world_from_local = TurnedAbout(z, -28) * TurnedAbout(Vector3d::UnitX(), 68)});
  if (easel)
    builder.AddBoard({TurnedAbout(z, 18) * TurnedAbout(Vector3d::UnitX(), -22), {-0.3, 0.12, 0.125}});
  builder.EncloseSubject({0, 0, 0.07});
  builder.AddLight({-1.25f, -0.45f, 1.3f}, {0, 0, 0.1f}, 0.26f, 0.26f, 4.0f);
  builder.AddLight({1.3f, -1.1f, 0.9f}, {0, 0, 0.1f}, 0.16f, 0.45f, 0.45f);
  constexpr double kElevation = Radians(33);
  return builder.Finish({0, -std::cos(kElevation), std::sin(kElevation)});
}

std::shared_ptr<const Scene> BuildStudio() { return BuildStudioWith(false); }
std::shared_ptr<const Scene> BuildEasel() { return BuildStudioWith(true); }

std::shared_ptr<const Scene> BuildWall() {
  SceneBuilder builder;
  AddRoom(builder, 0.1);
  builder.Add({.shape = Shape::kBox,
               .size = {2.0f, 0.02f, 1.45f},
               .position = {0, 0.02, 0.78},
               .material = material::kPosters,
               .texel_m = 0.0022f,
               .light_m = 0.05f,
               .main_chart = 3});
  builder.SetSubject({0, 0, 0.85}, 0.16);
  builder.AddLight({-1.6f, -2.6f, 2.1f}, {0, 0, 0.8f}, 0.4f, 0.4f, 7.0f);
  return builder.Finish({0, -1, 0});
}

struct NamedScene {
  const char* name;
  std::shared_ptr<const Scene> (*build)();
};
constexpr NamedScene kScenes[] = {{"studio", BuildStudio}, {"easel", BuildEasel}, {"wall", BuildWall}};

struct Hit {
  double distance = std::numeric_limits<double>::infinity();
  int part = -1;
};
Hit FirstHit(const std::vector<Primitive>& primitives, const Vector3d& origin, const Vector3d& direction) {
  Hit first;
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    const Vector3d o = primitives[i].local_from_world * origin;
    const Vector3d d = primitives[i].local_from_world.rotation * direction;
    const double distance = Intersect<double>(primitives[i], {o.x(), o.y(), o.z()}, {d.x(), d.y(), d.z()});
    if (distance < first.distance) first = {distance, static_cast<int>(i)};
  }
  return first;
}

}  // namespace

std::vector<std::string> Scene::Names() {
  std::vector<std::string> names;
  for (const NamedScene& scene : kScenes) names.emplace_back(scene.name);
  return names;
}

std::shared_ptr<const Scene> Scene::Named(const std::string& name) {
  static Mutex mutex;
  static std::map<std::string, std::shared_ptr<const Scene>> built ULF_GUARDED_BY(mutex);
  const MutexLock lock(mutex);
  if (const auto found = built.find(name); found != built.end()) return found->second;
  for (const NamedScene& scene : kScenes)
    if (name == scene.name) return built[name] = scene.build();
  throw UsageError("there is no scene '{}' to simulate; there are: {}", name, fmt::join(Names(), ", "));
}

double Scene::DepthAlong(const Vector3d& origin_in_world, const Vector3d& direction_in_world) const {
  return FirstHit(primitives_, origin_in_world, direction_in_world).distance;
}

int Scene::PartAlong(const Vector3d& origin_in_world, const Vector3d& direction_in_world) const {
  return FirstHit(primitives_, origin_in_world, direction_in_world).part;
}

F4 Scene::GlossRadiance(const Vector3f& point, const Vector3f& normal, const Vector3f& direction) const {
  const float facing = std::max(0.0f, -normal.dot(direction));
  const float grazing = 1 - facing, grazing2 = grazing * grazing;
  const float fresnel =
      0.045f + 0.955f * grazing2 * grazing2 * grazing;  // Schlick 1994, refractive index 1.54
  const Vector3f mirrored = direction + 2 * facing * normal;
  // The room: bright above, the table below.
  const float up = std::clamp(0.5f + 2 * mirrored.z(), 0.0f, 1.0f);
  float light = 0.09f + up * (0.1f + 0.24f * std::max(0.0f, mirrored.z()));
  for (const AreaLight& lamp : lights_) {
    const float towards = -mirrored.dot(lamp.normal);
    if (towards <= 0.01f) continue;
    const float distance = (point - lamp.center).dot(lamp.normal) / towards;
    if (distance <= 0) continue;
    const Vector3f at = point + distance * mirrored - lamp.center;
    const float u = std::abs(at.dot(lamp.half_u)) / lamp.half_u.squaredNorm();
    const float v = std::abs(at.dot(lamp.half_v)) / lamp.half_v.squaredNorm();
    // Radiance from irradiance at one metre: divided by the lamp's area; its cloth fades towards the rim.
    const float area = 4 * lamp.half_u.norm() * lamp.half_v.norm();
    const float rim = std::clamp((1.05f - std::max(u, v)) / 0.1f, 0.0f, 1.0f);
    light += rim * (1 - 0.3f * std::max(u, v)) * lamp.power / area;
  }
  const float radiance = fresnel * light;
  return F4{radiance, radiance, radiance, 0};
}

}  // namespace ulf::acquisition
