#include "acquisition/simulator/scene/built_scenes.h"
#include "acquisition/simulator/scene/materials.h"
#include "acquisition/simulator/scene/scene_builder.h"
#include "core/geometry/angles.h"

namespace ulf::acquisition {
namespace {

using Eigen::Vector3d;

std::shared_ptr<const Scene> BuildStudioWith(bool easel) {
  SceneBuilder builder;
  constexpr double kPlinth = 0.026;
  builder.AddStudio();
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
               .finish = Finish::kGlazed});
  // The ring leans against the carton.
  builder.Add({.shape = Shape::kTorus,
               .size = {0.039f, 0.0125f, 0},
               .position = {-0.08, -0.04, kPlinth + 0.046},
               .material = material::kBanded,
               .world_from_local = TurnedAbout(z, -28) * TurnedAbout(Vector3d::UnitX(), 68)});
  if (easel)
    builder.AddBoard({TurnedAbout(z, 18) * TurnedAbout(Vector3d::UnitX(), -22), {-0.3, 0.12, 0.125}});
  builder.EncloseSubject({0, 0, 0.07});
  builder.AddStudioLamps();
  constexpr double kElevation = Radians(33);
  return builder.Finish({0, -std::cos(kElevation), std::sin(kElevation)});
}

}  // namespace

std::shared_ptr<const Scene> BuildStudio() { return BuildStudioWith(false); }
std::shared_ptr<const Scene> BuildEasel() { return BuildStudioWith(true); }

std::shared_ptr<const Scene> BuildWall() {
  SceneBuilder builder;
  builder.AddRoom(0.1);
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

}  // namespace ulf::acquisition
