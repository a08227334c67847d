// Unstructured lumigraph weights (Buehler et al. 2001), the yardstick and the renderer of sparse and 1-D
// sets; and the nearest view, the fallback of all.
//
// Penalty of view i at the point P: the angle between P->V and P->C_i, plus r max(0, |P - C_i| / |P - V| - 1)
// for resolution; views that do not see P are out. With the (k+1)-th smallest penalty as threshold T, the
// k best weigh (1 - penalty / T) / penalty, normalised. With no more than k views that see P, T is 1.1 times
// the largest penalty.
#pragma once

#include <memory>

#include "render/fields/blending_field.h"

namespace ulf::render {

class LumigraphField : public BlendingField {
 public:
  // As FieldThatServes() gives them.
  LumigraphField(std::shared_ptr<const RenderScene> scene, const FieldOptions& options)
      : scene_(std::move(scene)), options_(options) {}
  std::unique_ptr<FieldFromHere> From(const Eigen::Vector3d& virtual_center_in_world) const override;

 private:
  std::shared_ptr<const RenderScene> scene_;
  FieldOptions options_;
};

class NearestField : public BlendingField {
 public:
  explicit NearestField(std::shared_ptr<const RenderScene> scene) : scene_(std::move(scene)) {}
  std::unique_ptr<FieldFromHere> From(const Eigen::Vector3d& virtual_center_in_world) const override;

 private:
  std::shared_ptr<const RenderScene> scene_;
};

// All views, nearest to V first; equally near ones in order of index.
std::vector<int> ViewsByDistance(const RenderScene& scene, const Eigen::Vector3d& virtual_center_in_world);

double LumigraphPenalty(const Eigen::Vector3d& point, const Eigen::Vector3d& virtual_center,
                        const Eigen::Vector3d& view_center, double resolution);

// Weights of the k best; `penalties` holds penalties in place of weights, of the views that see the point.
std::vector<ViewWeight> LumigraphWeights(std::vector<ViewWeight> penalties, std::size_t k);

inline constexpr double kLumigraphZeroPenalty = 1e-6;  // takes all
inline constexpr double kThresholdAboveTie = 1.001;    // over the k-th, where the next is as good
inline constexpr double kThresholdAboveLargest = 1.1;  // with no next view

}  // namespace ulf::render
