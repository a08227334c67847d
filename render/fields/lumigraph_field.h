// Computes unstructured lumigraph weights (Buehler et al. 2001), for few views, for views on a line and for
// comparison with other fields; and the nearest-view field, for views that are all in one place.
//
// V is the virtual camera's centre, C_i that of view i, P a point of the proxy. The penalty of view i at P,
// in radians, is the angle between P->V and P->C_i, plus r max(0, |P - C_i| / |P - V| - 1) for its lower
// resolution. Views that do not see P have no weight. The threshold T is the (k+1)-th smallest penalty; the k
// best views get (1 - penalty / T) / penalty, normalised. If no more than k views see P, T is 1.1 times the
// largest penalty. FieldOptions has r (lumigraph_resolution) and k (lumigraph_k).
#pragma once

#include <memory>

#include "render/fields/blending_field.h"
#include "render/fields/field_options.h"
#include "render/scene/scene.h"

namespace ulf::render {

class LumigraphField : public BlendingField {
 public:
  // `options.lumigraph_k` is at least 1: pass the result of FieldThatServes(), which replaces 0.
  LumigraphField(std::shared_ptr<const RenderScene> scene, const FieldOptions& options)
      : scene_(std::move(scene)), options_(options) {}
  std::unique_ptr<PlacedField> From(const Eigen::Vector3d& virtual_center_in_world) const override;

 private:
  std::shared_ptr<const RenderScene> scene_;
  FieldOptions options_;
};

// Gives all the weight to the view nearest to V that sees the point.
class NearestField : public BlendingField {
 public:
  explicit NearestField(std::shared_ptr<const RenderScene> scene) : scene_(std::move(scene)) {}
  std::unique_ptr<PlacedField> From(const Eigen::Vector3d& virtual_center_in_world) const override;

 private:
  std::shared_ptr<const RenderScene> scene_;
};

// Returns the indices of all views, nearest to V first; equally near views in order of index.
std::vector<int> ViewsByDistance(const RenderScene& scene, const Eigen::Vector3d& virtual_center_in_world);

// Returns the penalty of a view in radians. `resolution` is r; the points are in one frame, and V is not P.
double LumigraphPenalty(const Eigen::Vector3d& point, const Eigen::Vector3d& virtual_center,
                        const Eigen::Vector3d& view_center, double resolution);

// Returns the normalised weights of the k best views, the best first, without weights of 0. `penalties` are
// those of the views that see the point, in ViewWeight::weight. k is at least 1.
std::vector<ViewWeight> LumigraphWeights(std::vector<ViewWeight> penalties, std::size_t k);

// If the smallest penalty is at most this, in radians, its view gets all the weight: 1 / 0 is infinite.
inline constexpr double kLumigraphZeroPenalty = 1e-6;
// The threshold T is at least this many times the k-th penalty, because all weights would be 0 if the k+1
// smallest penalties were equal.
inline constexpr double kThresholdAboveTie = 1.001;
// T is this multiple of the largest penalty if there is no (k+1)-th view. Guessed.
inline constexpr double kThresholdAboveLargest = 1.1;

}  // namespace ulf::render
