// Scenes in each of which one assumption of a method fails: surfaces that look the same from everywhere,
// edges wider than a pixel, texture to match, nearby space that is empty, depth, rest.
#include "acquisition/simulator/scene/built_scenes.h"
#include "acquisition/simulator/scene/materials.h"
#include "acquisition/simulator/scene/noise.h"
#include "acquisition/simulator/scene/scene_builder.h"
#include "core/geometry/angles.h"
#include "core/geometry/small_matrices.h"

namespace ulf::acquisition {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr int kTowardsHand = 3, kTop = 4;  // a box's faces
constexpr double kPlinth = 0.02;           // height

Vector3d Towards(double elevation_deg) {
  return {0, -std::cos(Radians(elevation_deg)), std::sin(Radians(elevation_deg))};
}

void AddPlinth(SceneBuilder& builder, float radius) {
  builder.Add(Matte(Shape::kFrustum, {radius, radius - 0.006f, static_cast<float>(kPlinth)}, {0, 0, 0},
                    material::kMosaic));
}

// Numbers from -1 to 1 that a place in a list of parts determines.
class Scatter {
 public:
  explicit Scatter(std::uint32_t seed) : seed_(seed) {}
  double Next() { return 2.0 * UnitFloat(HashLattice(static_cast<std::int32_t>(++count_), 0, 0, seed_)) - 1; }

 private:
  std::uint32_t seed_, count_ = 0;
};

// Adds a round leaf of a stalk's length beside `at`, turned away from the stem.
void AddLeaf(SceneBuilder& builder, const Vector3d& at, const Vector3d& outward, double radius, bool moves,
             Scatter& scatter) {
  const Vector3d normal = (Vector3d(0, 0, 1) + 0.7 * outward +
                           0.5 * Vector3d(scatter.Next(), scatter.Next(), 0.4 * scatter.Next()))
                              .normalized();
  builder.Add({.shape = Shape::kFrustum,
               .size = {static_cast<float>(radius), static_cast<float>(radius), 0.0008f},
               .position = at + 0.95 * radius * outward,
               .material = material::kLeaf,
               .texel_m = 0.0007f,
               .thin = true,
               .moves = moves,
               .world_from_local = TurnBetween(Vector3d::UnitZ(), normal)});
}

}  // namespace

std::shared_ptr<const Scene> BuildGloss() {
  SceneBuilder builder;
  builder.AddStudio();
  AddPlinth(builder, 0.14f);
  // A vase: belly, neck and lip.
  builder.Add({.shape = Shape::kSphere,
               .size = {0.06f, 0, 0},
               .position = {-0.045, 0.02, kPlinth + 0.054},
               .material = material::kPorcelain,
               .finish = Finish::kPolished,
               .mirrored = 0.12f});
  builder.Add({.shape = Shape::kFrustum,
               .size = {0.03f, 0.019f, 0.07f},
               .position = {-0.045, 0.02, kPlinth + 0.1},
               .material = material::kPorcelain,
               .finish = Finish::kPolished,
               .mirrored = 0.12f});
  builder.Add(Matte(Shape::kTorus, {0.0195f, 0.0045f, 0}, {-0.045, 0.02, kPlinth + 0.17}, material::kBanded));
  // A beaker like polished metal, and a lacquered ball.
  builder.Add({.shape = Shape::kFrustum,
               .size = {0.03f, 0.038f, 0.095f},
               .position = {0.07, 0.03, kPlinth},
               .material = material::kPorcelain,
               .finish = Finish::kPolished,
               .mirrored = 0.5f});
  builder.Add({.shape = Shape::kSphere,
               .size = {0.04f, 0, 0},
               .position = {0.028, -0.065, kPlinth + 0.04},
               .material = material::kGlaze,
               .finish = Finish::kPolished,
               .mirrored = 0.2f});
  // What they mirror.
  builder.Add(
      Matte(Shape::kSphere, {0.022f, 0, 0}, {-0.06, -0.075, kPlinth + 0.022}, material::kRedTerrazzo));
  builder.Add(
      Matte(Shape::kBox, {0.028f, 0.02f, 0.035f}, {0.01, 0.095, kPlinth + 0.035}, material::kPrinted, 30));
  builder.EncloseSubject({0, 0, 0.075});
  builder.AddStudioLamps();
  return builder.Finish(Towards(30));
}

std::shared_ptr<const Scene> BuildGlass() {
  SceneBuilder builder;
  builder.AddStudio();
  AddPlinth(builder, 0.14f);
  builder.Add({.shape = Shape::kSphere,
               .size = {0.05f, 0, 0},
               .position = {-0.045, -0.035, kPlinth + 0.05},
               .material = material::kStucco,
               .finish = Finish::kGlass,
               .mirrored = 0.04f});
  builder.Add({.shape = Shape::kFrustum,
               .size = {0.03f, 0.036f, 0.105f},
               .position = {0.062, -0.02, kPlinth},
               .material = material::kStucco,
               .finish = Finish::kGlass,
               .mirrored = 0.04f});
  builder.Add(
      Matte(Shape::kBox, {0.04f, 0.028f, 0.055f}, {-0.05, 0.075, kPlinth + 0.055}, material::kPrinted, 12));
  builder.Add(Matte(Shape::kFrustum, {0.026f, 0.026f, 0.13f}, {0.035, 0.085, kPlinth}, material::kLabel));
  builder.Add(Matte(Shape::kFrustum, {0.024f, 0.004f, 0.07f}, {0.01, -0.09, kPlinth}, material::kPatchwork));
  builder.EncloseSubject({0, 0, 0.07});
  builder.AddStudioLamps();
  return builder.Finish(Towards(28));
}

std::shared_ptr<const Scene> BuildPlant() {
  SceneBuilder builder;
  builder.AddStudio();
  constexpr double kPot = 0.075;
  builder.Add(
      Matte(Shape::kFrustum, {0.042f, 0.055f, static_cast<float>(kPot)}, {0, 0, 0}, material::kPatchwork));
  Scatter scatter(201);
  const Primitive stem{.material = material::kBark, .texel_m = 0.0007f, .thin = true};
  constexpr int kStems = 9, kLeavesOfStem = 4;
  for (int i = 0; i < kStems; ++i) {
    const double turn = 2 * M_PI * i / kStems + 0.3 * scatter.Next();
    const Vector3d outward(std::cos(turn), std::sin(turn), 0);
    const Vector3d foot = Vector3d(0, 0, kPot - 0.005) + 0.015 * outward;
    const Vector3d knee = foot + 0.025 * outward + Vector3d(0, 0, 0.07 + 0.015 * scatter.Next());
    const Vector3d tip =
        knee + (0.035 + 0.02 * scatter.Next()) * outward +
        Vector3d(0.01 * scatter.Next(), 0.01 * scatter.Next(), 0.05 + 0.025 * scatter.Next());
    builder.AddRod(foot, knee, 0.0018, stem);
    builder.AddRod(knee, tip, 0.0012, stem);
    for (int leaf = 0; leaf < kLeavesOfStem; ++leaf) {
      const double share = (leaf + 1.0) / kLeavesOfStem;
      const double aside = turn + (leaf % 2 == 0 ? 0.9 : -0.9) + 0.4 * scatter.Next();
      AddLeaf(builder, knee + share * (tip - knee), {std::cos(aside), std::sin(aside), 0},
              0.013 + 0.005 * scatter.Next(), false, scatter);
    }
  }
  // Blades of grass, and a trellis of wire: about a pixel wide at a metre.
  for (int i = 0; i < 7; ++i) {
    const double turn = 2 * M_PI * (i + 0.5) / 7;
    builder.Add({.shape = Shape::kBox,
                 .size = {0.0022f, 0.0004f, 0.055f},
                 .position = {0.03 * std::cos(turn), 0.03 * std::sin(turn), kPot + 0.05},
                 .material = material::kLeaf,
                 .texel_m = 0.0007f,
                 .thin = true,
                 .world_from_local = TurnedAbout(Vector3d::UnitZ(), 40 * i) *
                                     TurnedAbout(Vector3d::UnitX(), 18 * scatter.Next())});
  }
  constexpr double kRing = 0.085, kWire = 0.0009;
  const Primitive wire{.material = material::kStucco, .texel_m = 0.0007f, .thin = true};
  for (const double height : {0.1, 0.16, 0.22})
    builder.Add({.shape = Shape::kTorus,
                 .size = {static_cast<float>(kRing), static_cast<float>(kWire), 0},
                 .position = {0, 0, height},
                 .material = material::kStucco,
                 .thin = true});
  for (int i = 0; i < 6; ++i) {
    const double turn = 2 * M_PI * (i + 0.25) / 6;
    const Vector3d at(kRing * std::cos(turn), kRing * std::sin(turn), 0);
    builder.AddRod(at, at + Vector3d(0, 0, 0.235), kWire, wire);
  }
  builder.EncloseSubject({0, 0, 0.115});
  builder.AddStudioLamps();
  return builder.Finish(Towards(22));
}

std::shared_ptr<const Scene> BuildBust() {
  SceneBuilder builder;
  builder.AddStudio();
  constexpr double kSocket = 0.035, kHeight = 0.34;
  builder.Add(
      Matte(Shape::kFrustum, {0.065f, 0.06f, static_cast<float>(kSocket)}, {0, 0, 0}, material::kStucco));
  builder.Add({.shape = Shape::kBust,
               .size = {static_cast<float>(kHeight), 0, 0},
               .position = {0, 0, kSocket + 0.28 * kHeight},
               .material = material::kStucco,
               .texel_m = 0.002f,
               .light_m = 0.004f,
               .world_from_local = TurnedAbout(Vector3d::UnitZ(), 22)});
  builder.EncloseSubject({0, 0, kSocket + 0.29 * kHeight});
  builder.AddStudioLamps();
  return builder.Finish(Towards(18));
}

std::shared_ptr<const Scene> BuildRoom() {
  SceneBuilder builder;
  constexpr double kFloor = -0.75;
  builder.Add({.shape = Shape::kRoom,
               .size = {2.4f, 4.3f, 1.4f},
               .position = {0, 1.0, 0.65},
               .material = material::kPlaster,
               .texel_m = 0.01f,
               .light_m = 0.1f,
               .of_subject = false});
  const auto add_box = [&](const Vector3d& half, const Vector3d& position, int material, double turned_deg,
                           bool of_subject, float texel_m) {
    builder.Add(
        {.shape = Shape::kBox,
         .size = {static_cast<float>(half.x()), static_cast<float>(half.y()), static_cast<float>(half.z())},
         .position = position,
         .material = material,
         .texel_m = texel_m,
         .light_m = 0.02f,
         .of_subject = of_subject,
         .world_from_local = TurnedAbout(Vector3d::UnitZ(), turned_deg)});
  };
  builder.Add({.shape = Shape::kBox,
               .size = {2.4f, 4.3f, 0.02f},
               .position = {0, 1.0, kFloor - 0.018},
               .material = material::kWood,
               .texel_m = 0.004f,
               .light_m = 0.05f,
               .of_subject = false,
               .main_chart = kTop});
  // The dresser and what stands on it.
  add_box({0.42, 0.2, 0.3}, {0, 0, kFloor + 0.3}, material::kPrinted, 4, true, 0.003f);
  add_box({0.05, 0.08, 0.13}, {-0.26, 0.02, kFloor + 0.73}, material::kPatchwork, 15, true, 0.002f);
  add_box({0.04, 0.07, 0.1}, {-0.14, 0.04, kFloor + 0.7}, material::kLabel, -8, true, 0.002f);
  builder.Add({.shape = Shape::kSphere,
               .size = {0.1f, 0, 0},
               .position = {0.06, 0, kFloor + 0.7},
               .material = material::kMarbled,
               .texel_m = 0.002f});
  builder.Add({.shape = Shape::kFrustum,
               .size = {0.07f, 0.02f, 0.26f},
               .position = {0.27, -0.02, kFloor + 0.6},
               .material = material::kBanded,
               .texel_m = 0.002f});
  builder.EncloseSubject({0, 0, -0.35});
  // Near the camera: a chair's back and a stool with a ball.
  const Primitive post{.material = material::kBark, .texel_m = 0.002f, .of_subject = false};
  for (const double x : {-0.82, -0.5}) builder.AddRod({x, -1.1, kFloor}, {x, -1.06, 0.15}, 0.018, post);
  for (const double z : {-0.25, -0.05, 0.12})
    builder.AddRod({-0.82, -1.08, z}, {-0.5, -1.08, z}, 0.012, post);
  add_box({0.2, 0.2, 0.22}, {0.72, -0.95, kFloor + 0.22}, material::kMosaic, 20, false, 0.002f);
  builder.Add({.shape = Shape::kSphere,
               .size = {0.09f, 0, 0},
               .position = {0.72, -0.95, kFloor + 0.53},
               .material = material::kRedTerrazzo,
               .texel_m = 0.002f,
               .of_subject = false});
  // Shelves at the left wall, a partition with a doorway, and a passage behind it.
  Scatter scatter(301);
  for (int shelf = 0; shelf < 3; ++shelf) {
    const double z = kFloor + 0.35 + 0.5 * shelf;
    add_box({0.17, 1.0, 0.015}, {-2.2, 0.6, z}, material::kWood, 0, false, 0.004f);
    for (int i = 0; i < 7; ++i) {
      const double half = 0.1 + 0.04 * scatter.Next();
      const int materials[] = {material::kPrinted, material::kPatchwork, material::kLabel,
                               material::kMarbled};
      add_box({0.1 + 0.02 * scatter.Next(), 0.06 + 0.02 * scatter.Next(), half},
              {-2.18, -0.25 + 0.29 * i, z + 0.015 + half}, materials[i % 4], 8 * scatter.Next(), false,
              0.004f);
    }
  }
  add_box({1.55, 0.04, 1.4}, {-0.85, 1.6, 0.65}, material::kFieldstone, 0, false, 0.004f);
  add_box({0.55, 0.04, 1.4}, {1.85, 1.6, 0.65}, material::kFieldstone, 0, false, 0.004f);
  add_box({0.3, 0.04, 0.3}, {1.0, 1.6, 1.75}, material::kFieldstone, 0, false, 0.006f);
  add_box({2.3, 0.03, 1.38}, {0, 5.2, 0.65}, material::kPosters, 0, false, 0.006f);
  add_box({0.3, 0.3, 0.4}, {0.7, 4.0, kFloor + 0.4}, material::kPrinted, 30, false, 0.006f);
  builder.AddLight({-0.4f, -0.9f, 1.98f}, {0, 0, -0.3f}, 0.5f, 0.5f, 6.0f);
  builder.AddLight({0.8f, 3.4f, 1.98f}, {0.8f, 3.6f, -0.7f}, 0.4f, 0.4f, 5.0f);
  constexpr double kDistance = 2.2;
  return builder.Finish(Towards(22), kDistance);
}

std::shared_ptr<const Scene> BuildPicture() {
  SceneBuilder builder;
  builder.AddRoom(0.1);
  builder.Add({.shape = Shape::kBox,
               .size = {2.0f, 0.02f, 1.45f},
               .position = {0, 0.02, 0.78},
               .material = material::kStucco,
               .texel_m = 0.004f,
               .light_m = 0.05f,
               .of_subject = false,
               .main_chart = kTowardsHand});
  constexpr float kHalfWidth = 0.2f, kHalfHeight = 0.145f, kRail = 0.014f;
  constexpr double kHeight = 0.85;
  builder.Add({.shape = Shape::kBox,
               .size = {kHalfWidth, 0.004f, kHalfHeight},
               .position = {0, -0.003, kHeight},
               .material = material::kPainting,
               .texel_m = 0.0008f,
               .light_m = 0.02f,
               .main_chart = kTowardsHand});
  for (const double side : {-1.0, 1.0}) {
    builder.Add({.shape = Shape::kBox,
                 .size = {kHalfWidth + 2 * kRail, 0.008f, kRail},
                 .position = {0, -0.006, kHeight + side * (kHalfHeight + kRail)},
                 .material = material::kWood,
                 .light_m = 0.02f});
    builder.Add({.shape = Shape::kBox,
                 .size = {kRail, 0.008f, kHalfHeight},
                 .position = {side * (kHalfWidth + kRail), -0.006, kHeight},
                 .material = material::kWood,
                 .light_m = 0.02f});
  }
  builder.EncloseSubject({0, -0.004, kHeight});
  builder.AddLight({-1.6f, -2.6f, 2.1f}, {0, 0, 0.8f}, 0.4f, 0.4f, 7.0f);
  return builder.Finish({0, -1, 0});
}

std::shared_ptr<const Scene> BuildBranch() {
  SceneBuilder builder;
  builder.AddStudio();
  AddPlinth(builder, 0.13f);
  constexpr double kPot = 0.07, kFork = 0.11;
  builder.Add(Matte(Shape::kFrustum, {0.034f, 0.045f, static_cast<float>(kPot)}, {-0.02, 0.02, kPlinth},
                    material::kPatchwork));
  const Vector3d fork(-0.02, 0.02, kPlinth + kFork);
  builder.AddRod({-0.02, 0.02, kPlinth + kPot - 0.01}, fork, 0.0065,
                 {.material = material::kBark, .texel_m = 0.0007f});
  Scatter scatter(401);
  const Primitive twig{.material = material::kBark, .texel_m = 0.0007f, .thin = true, .moves = true};
  constexpr int kTwigs = 5, kLeavesOfTwig = 5;
  for (int i = 0; i < kTwigs; ++i) {
    const double turn = 2 * M_PI * i / kTwigs + 0.4;
    const Vector3d outward(std::cos(turn), std::sin(turn), 0);
    const Vector3d tip = fork + 0.075 * outward + Vector3d(0, 0, 0.075 + 0.025 * scatter.Next());
    builder.AddRod(fork, tip, 0.0025, twig);
    for (int leaf = 0; leaf < kLeavesOfTwig; ++leaf) {
      const double share = (leaf + 1.5) / (kLeavesOfTwig + 0.5);
      const double aside = turn + (leaf % 2 == 0 ? 1.0 : -1.0) + 0.3 * scatter.Next();
      AddLeaf(builder, fork + share * (tip - fork), {std::cos(aside), std::sin(aside), 0},
              0.017 + 0.005 * scatter.Next(), true, scatter);
    }
  }
  builder.Add(Matte(Shape::kSphere, {0.028f, 0, 0}, {0.07, -0.05, kPlinth + 0.028}, material::kRedTerrazzo));
  builder.Add(
      Matte(Shape::kBox, {0.03f, 0.022f, 0.04f}, {-0.07, -0.055, kPlinth + 0.04}, material::kPrinted, -20));
  builder.EncloseSubject({0, 0, 0.1});
  builder.SetSway({.pivot = fork, .axis = Vector3d::UnitY(), .amplitude = Radians(11), .period_s = 1.6});
  builder.AddStudioLamps();
  return builder.Finish(Towards(26));
}

// What shines or is dark stands beside ordinary things, so that every part of the picture has something to
// track.
std::shared_ptr<const Scene> BuildLightbox() {
  SceneBuilder builder;
  builder.AddStudio();
  AddPlinth(builder, 0.15f);
  struct Thing {
    Primitive solid;
    double stops;  // of its glow
  };
  const auto box = [](double x, double y, double half_height, int material, double turned_deg) {
    return Matte(Shape::kBox, {0.03f, 0.012f, static_cast<float>(half_height)}, {x, y, kPlinth + half_height},
                 material, turned_deg);
  };
  const auto ball = [](double x, double y, float radius, int material) {
    return Matte(Shape::kSphere, {radius, 0, 0}, {x, y, kPlinth + radius}, material);
  };
  const std::array things{Thing{box(-0.095, 0.05, 0.06, material::kPainting, 20), 7},
                          Thing{box(-0.028, 0.085, 0.075, material::kPosters, 4), 5},
                          Thing{box(0.042, 0.085, 0.06, material::kPrinted, -6), -5},
                          Thing{box(0.103, 0.045, 0.07, material::kPatchwork, -25), -7},
                          Thing{ball(-0.065, -0.02, 0.027f, material::kMarbled), 3},
                          Thing{ball(-0.005, 0.01, 0.034f, material::kRedTerrazzo), 0},
                          Thing{ball(0.058, -0.005, 0.028f, material::kBanded), -3},
                          Thing{ball(-0.035, -0.085, 0.02f, material::kMosaic), 6},
                          Thing{ball(0.028, -0.08, 0.024f, material::kMosaic), -6}};
  for (const Thing& thing : things) {
    Primitive solid = thing.solid;
    solid.glow = static_cast<float>(std::exp2(thing.stops));
    builder.Add(solid);
  }
  builder.EncloseSubject({0, 0, 0.075});
  builder.AddStudioLamps();
  return builder.Finish(Towards(28));
}

}  // namespace ulf::acquisition
