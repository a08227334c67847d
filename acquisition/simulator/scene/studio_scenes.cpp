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
  builder.Add(Matte(Shape::kFrustum, {0.146f, 0.14f, kPlinth}, {0, 0, 0}, material::kMosaic));
  builder.Add(
      Matte(Shape::kBox, {0.042f, 0.034f, 0.06f}, {-0.056, 0.046, kPlinth + 0.06}, material::kPrinted, 24));
  builder.Add(
      Matte(Shape::kSphere, {0.029f, 0, 0}, {-0.056, 0.046, kPlinth + 0.12 + 0.029}, material::kRedTerrazzo));
  builder.Add({.shape = Shape::kSphere,
               .size = {0.056f, 0, 0},
               .position = {0.058, 0.03, kPlinth + 0.056},
               .material = material::kMarbled,
               .world_from_local = TurnedAbout({1, 2, 0.5}, 40)});
  builder.Add(Matte(Shape::kFrustum, {0.028f, 0.028f, 0.13f}, {0.018, 0.104, kPlinth}, material::kLabel, 70));
  builder.Add(
      Matte(Shape::kFrustum, {0.031f, 0.005f, 0.104f}, {0.09, -0.056, kPlinth}, material::kPatchwork));
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
    builder.AddBoard({TurnedAbout(z, 18) * TurnedAbout(Vector3d::UnitX(), -22), {-0.3, 0.12, 0.125}},
                     material::kMarkerSheet);
  builder.EncloseSubject({0, 0, 0.07});
  builder.AddStudioLamps();
  constexpr double kElevation = Radians(33);
  return builder.Finish({0, -std::cos(kElevation), std::sin(kElevation)});
}

}  // namespace

std::shared_ptr<const Scene> BuildStudio() { return BuildStudioWith(false); }
std::shared_ptr<const Scene> BuildEasel() { return BuildStudioWith(true); }

// What turns is a plate, a printed board on it and the things that stand on the board.
std::shared_ptr<const Scene> BuildTurntable() {
  SceneBuilder builder;
  builder.AddStudio();
  const Vector3d z = Vector3d::UnitZ();
  constexpr double kPlate = 0.02, kSheet = 0.006, kTop = kPlate + kSheet;
  const auto add = [&](Primitive solid) {
    solid.moves = true;
    builder.Add(solid);
  };
  add({.shape = Shape::kFrustum,
       .size = {0.222f, 0.222f, kPlate},
       .material = material::kWood,
       .texel_m = 0.002f,
       .of_subject = false});
  // The sheet's front, -y of its own frame, looks up.
  builder.AddBoard({TurnedAbout(Vector3d::UnitX(), -90), {0, 0, kPlate + 0.5 * kSheet}},
                   material::kTurntableSheet, true);
  add(Matte(Shape::kBox, {0.036f, 0.03f, 0.055f}, {-0.035, 0.03, kTop + 0.055}, material::kPrinted, 24));
  add(Matte(Shape::kSphere, {0.027f, 0, 0}, {-0.035, 0.03, kTop + 0.11 + 0.027}, material::kRedTerrazzo));
  add({.shape = Shape::kSphere,
       .size = {0.042f, 0, 0},
       .position = {0.05, 0.022, kTop + 0.042},
       .material = material::kMarbled,
       .world_from_local = TurnedAbout({1, 2, 0.5}, 40)});
  add(Matte(Shape::kFrustum, {0.026f, 0.006f, 0.09f}, {0.04, -0.055, kTop}, material::kPatchwork));
  add({.shape = Shape::kTorus,
       .size = {0.033f, 0.011f, 0},
       .position = {-0.04, -0.05, kTop + 0.043},
       .material = material::kBanded,
       .world_from_local = TurnedAbout(z, -28) * TurnedAbout(Vector3d::UnitX(), 84)});
  builder.SetSway({.pivot = Vector3d::Zero(), .axis = z, .goes_round = true});
  builder.EncloseSubject({0, 0, 0.075});
  builder.AddStudioLamps();
  constexpr double kElevation = Radians(33), kDistance = 0.7;
  return builder.Finish({0, -std::cos(kElevation), std::sin(kElevation)}, kDistance);
}

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
