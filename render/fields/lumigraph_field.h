// Unstructured lumigraph weights (Buehler et al. 2001), for comparison and for few views or views on a line;
// and the nearest-view field, the last resort.
//
// V is the virtual camera's centre. The penalty of view i at the point P is the angle between P->V and
// P->C_i, plus r max(0, |P - C_i| / |P - V| - 1) for resolution. Views that do not see P have no weight. The
// threshold T is the (k+1)-th smallest penalty; the k best views get (1 - penalty / T) / penalty, normalised.
// If no more than k views see P, T is 1.1 times the largest penalty.
#pragma once

#include <memory>

#include "render/fields/blending_field.h"
#include "render/fields/field_options.h"
#include "render/scene/scene.h"

namespace ulf::render {

class LumigraphField : public BlendingField {
 public:
  // `options` are the result of FieldThatServes().
  LumigraphField(std::shared_ptr<const RenderScene> scene, const FieldOptions& options)
      : scene_(std::move(scene)), options_(options) {}
  std::unique_ptr<PlacedField> From(const Eigen::Vector3d& virtual_center_in_world) const override;

 private:
  std::shared_ptr<const RenderScene> scene_;
  FieldOptions options_;
};

class NearestField : public BlendingField {
 public:
  explicit NearestField(std::shared_ptr<const RenderScene> scene) : scene_(std::move(scene)) {}
  std::unique_ptr<PlacedField> From(const Eigen::Vector3d& virtual_center_in_world) const override;

 private:
  std::shared_ptr<const RenderScene> scene_;
};

// Returns all views, nearest to V first; equally near ones in order of index.
std::vector<int> ViewsByDistance(const RenderScene& scene, const Eigen::Vector3d& virtual_center_in_world);

double LumigraphPenalty(const Eigen::Vector3d& point, const Eigen::Vector3d& virtual_center,
                        const Eigen::Vector3d& view_center, double resolution);

// Weights the k best views. `penalties` are those of the views that see the point, as ViewWeight::weight.
std::vector<ViewWeight> LumigraphWeights(std::vector<ViewWeight> penalties, std::size_t k);

// A view with a penalty up to this gets all weight: 1 / penalty would overflow. Radians.
inline constexpr double kLumigraphZeroPenalty = 1e-6;
// The threshold is at least this many times the k-th penalty: with an equal (k+1)-th all weights would be 0.
inline constexpr double kThresholdAboveTie = 1.001;
// The threshold is this multiple of the largest penalty if there is no (k+1)-th view. Guessed.
inline constexpr double kThresholdAboveLargest = 1.1;

}  // namespace ulf::render
