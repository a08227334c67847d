// What the curves of viewpoints and blending share: draws of directions, scenes without photographs, weights
// of views, and whether these jump.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <queue>
#include <random>
#include <vector>

#include "core/base/at.h"
#include "render/fields/blending_field.h"
#include "render/fields/field_options.h"
#include "render/fields/make_field.h"
#include "tests/support/floors.h"

namespace ulf::test {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;

inline constexpr double kLeastShown = 1e-16;

class SceneDraw {
 public:
  explicit SceneDraw(unsigned seed) : random_(seed) {}
  double Uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  double Normal() { return std::normal_distribution<double>()(random_); }
  int Whole(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random_); }
  Vector3d Normals() { return {Normal(), Normal(), Normal()}; }
  Vector3d Direction() { return Normals().normalized(); }
  // Evenly within an angle of a direction.
  Vector3d Within(const Vector3d& axis, double angle) {
    const double z = Uniform(std::cos(angle), 1), turn = Uniform(0, 2 * M_PI);
    const Vector3d x = axis.unitOrthogonal(), y = axis.cross(x);
    return z * axis + std::sqrt(1 - z * z) * (std::cos(turn) * x + std::sin(turn) * y);
  }
  Quaterniond Rotation() { return Quaterniond(Normal(), Normal(), Normal(), Normal()).normalized(); }

 private:
  std::mt19937 random_;
};

// Without photographs: for weights alone.
inline std::shared_ptr<const RenderScene> SceneOf(const std::vector<Vector3d>& viewpoints,
                                                  const Subject& subject) {
  auto scene = std::make_shared<RenderScene>();
  scene->subject = subject;
  for (const Vector3d& center : viewpoints) {
    SceneView& view = scene->views.emplace_back();
    view.id = static_cast<int>(scene->views.size()) - 1;
    view.center_in_world = center;
  }
  scene->MakeMesh();
  return scene;
}

// All views' weights.
inline VectorXd WeightsOf(const PlacedField& here, const Vector3d& ray, std::size_t views) {
  FieldSample sample;
  here.Weights({.ray_in_world = ray, .point_in_world = Vector3d::Zero()}, sample);
  VectorXd weights = VectorXd::Zero(static_cast<Eigen::Index>(views));
  for (const ViewWeight& entry : sample.weights) weights(entry.view) += entry.weight;
  return weights;
}

// How far weights are from being finite, none negative, one in all.
inline double OffWhole(const VectorXd& weights) {
  const double off = std::max(std::abs(weights.sum() - 1), -weights.minCoeff());
  return std::isfinite(off) ? off : 1;
}

// The most that weights change at once on a way from 0 to 1. What changes the most is cut in two until it no
// longer matters, or until it does not go away however short the step.
template <typename Weights>
double LargestJump(const Weights& weights_at, int steps) {
  constexpr double kUnseen = 0.005, kShortest = 1e-10;
  constexpr int kMostCuts = 4000;
  struct Step {
    double change, from, to;
    VectorXd before, behind;
    bool operator<(const Step& other) const { return change < other.change; }
  };
  std::priority_queue<Step> by_change;
  const auto add = [&](double from, const VectorXd& before, double to, const VectorXd& behind) {
    by_change.push({(behind - before).template lpNorm<Eigen::Infinity>(), from, to, before, behind});
  };
  VectorXd before = weights_at(0.0);
  for (int i = 1; i <= steps; ++i) {
    const VectorXd behind = weights_at(static_cast<double>(i) / steps);
    add(static_cast<double>(i - 1) / steps, before, static_cast<double>(i) / steps, behind);
    before = behind;
  }
  for (int cuts = 0; cuts < kMostCuts; ++cuts) {
    const Step step = by_change.top();
    if (step.change <= kUnseen || step.to - step.from < kShortest) break;
    by_change.pop();
    const double middle = 0.5 * (step.from + step.to);
    const VectorXd between = weights_at(middle);
    add(step.from, step.before, middle, between);
    add(middle, between, step.to, step.behind);
  }
  return by_change.top().change;
}

inline FieldOptions FieldOf(unsigned seed) {
  return seed % 2 == 0 ? FieldOptions{.kind = FieldKind::kLinear, .level = 0} : FieldOptions{};
}

// Jumps that nobody sees: less than a grey level where two photographs differ by fifty.
inline constexpr double kNoticed = 0.02;

}  // namespace ulf::test
