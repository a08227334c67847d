// The camera blending field gives, for every ray of the virtual camera, the weight of each recorded view.
//
// All fields have one contract. Given the virtual camera's centre V, and for a pixel the ray through V and
// the point P where that ray meets the proxy, a field returns a list of (view, weight). Weights are not
// negative and sum to one; the list is empty without a view. The renderer checks which views see P.
//
//   kLinear, kSubdivision  by where the line through V crosses the mesh of viewpoints (thesis, 5.1 and 5.3)
//   kLumigraph             the k best views by angle and resolution at P (Buehler et al. 2001)
//   kNearest               the view nearest to V that sees P
//
// The soft field (kSoft) is the exception: it weighs surfaces as well as views, and is no BlendingField.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

namespace ulf::render {

struct ViewWeight {
  int view = 0;  // index into RenderScene::views
  double weight = 0;
};

// A field's result for one ray.
struct FieldSample {
  std::vector<ViewWeight> weights;  // each view once
  // 1 between views that stand close together, less in wide triangles and outside the hull, 0 without any.
  double confidence = 0;
  bool extrapolated = false;  // the ray crosses the viewpoint mesh outside the hull
  // Adds to the view's weight; weights of 0 or less are ignored.
  void Add(int view, double weight) {
    if (weight <= 0) return;
    for (ViewWeight& entry : weights)
      if (entry.view == view) {
        entry.weight += weight;
        return;
      }
    weights.push_back({view, weight});
  }
};

struct RayQuery {
  Eigen::Vector3d ray_in_world;    // unit, from V through the pixel
  Eigen::Vector3d point_in_world;  // where it meets the proxy
  // The triangles to search: CandidatesInCone() for a cone that contains the ray. Null: all.
  const std::vector<int>* candidates = nullptr;
};

// The field for one virtual camera's centre. It may outlive the BlendingField that made it.
class PlacedField {
 public:
  virtual ~PlacedField() = default;
  // Returns the indices of the field's triangles that rays within `half_angle` (radians, less than a right
  // angle) of the axis can meet, so that all these rays search only them. Empty for a field without
  // triangles, which ignores RayQuery::candidates.
  virtual std::vector<int> CandidatesInCone(const Eigen::Vector3d& /*axis_in_world*/,
                                            double /*half_angle*/) const {
    return {};
  }
  virtual void Weights(const RayQuery& query, FieldSample& sample) const = 0;  // replaces `sample`
};

class BlendingField {
 public:
  virtual ~BlendingField() = default;
  virtual std::unique_ptr<PlacedField> From(const Eigen::Vector3d& virtual_center_in_world) const = 0;
};

// The field of a wide aperture has no view where its weights before normalisation sum to less. Guessed.
inline constexpr double kLeastWeightOfField = 1e-4;

// The confidence outside the hull of the viewpoints. Guessed.
inline constexpr double kExtrapolatedConfidence = 0.25;

}  // namespace ulf::render
