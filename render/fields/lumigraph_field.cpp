#include "render/fields/lumigraph_field.h"

#include <algorithm>

#include "core/base/at.h"
#include "core/geometry/angles.h"

namespace ulf::render {
namespace {

using Eigen::Vector3d;

class LumigraphFromHere : public PlacedField {
 public:
  LumigraphFromHere(std::shared_ptr<const RenderScene> scene, const FieldOptions& options,
                    const Vector3d& virtual_center)
      : scene_(std::move(scene)),
        k_(static_cast<std::size_t>(options.lumigraph_k)),
        resolution_(options.lumigraph_resolution),
        virtual_center_(virtual_center) {}

  void Weights(const RayQuery& query, FieldSample& sample) const override {
    sample.weights.clear();
    sample.extrapolated = false;
    std::vector<ViewWeight> best;  // with penalties as weights
    for (std::size_t i = 0; i < scene_->views.size(); ++i) {
      const SceneView& view = scene_->views[i];
      if (!view.ProjectVisible(query.point_in_world)) continue;
      best.push_back({static_cast<int>(i), LumigraphPenalty(query.point_in_world, virtual_center_,
                                                            view.center_in_world, resolution_)});
    }
    sample.weights = LumigraphWeights(std::move(best), k_);
    sample.confidence = sample.weights.empty() ? 0 : 1;
  }

 private:
  std::shared_ptr<const RenderScene> scene_;
  std::size_t k_;
  double resolution_;
  Vector3d virtual_center_;
};

class NearestFromHere : public PlacedField {
 public:
  NearestFromHere(std::shared_ptr<const RenderScene> scene, const Vector3d& virtual_center)
      : scene_(std::move(scene)), order_(ViewsByDistance(*scene_, virtual_center)) {}

  void Weights(const RayQuery& query, FieldSample& sample) const override {
    sample = {};
    for (const int view : order_) {
      if (!scene_->views[At(view)].ProjectVisible(query.point_in_world)) continue;
      sample.weights.push_back({view, 1.0});
      sample.confidence = 1;
      return;
    }
  }

 private:
  std::shared_ptr<const RenderScene> scene_;
  std::vector<int> order_;
};

}  // namespace

std::vector<ViewWeight> LumigraphWeights(std::vector<ViewWeight> penalties, std::size_t k) {
  if (penalties.empty()) return {};
  const std::size_t kept = std::min(penalties.size(), k + 1);
  std::partial_sort(penalties.begin(), penalties.begin() + static_cast<std::ptrdiff_t>(kept), penalties.end(),
                    [](const ViewWeight& a, const ViewWeight& b) { return a.weight < b.weight; });
  penalties.resize(kept);
  double threshold = kThresholdAboveLargest * penalties.back().weight;
  if (kept > k) {
    threshold = std::max(penalties[k].weight, kThresholdAboveTie * penalties[k - 1].weight);
    penalties.resize(k);
  }
  if (penalties.front().weight <= kLumigraphZeroPenalty) return {{penalties.front().view, 1.0}};
  double sum = 0;
  for (ViewWeight& entry : penalties) {
    entry.weight = std::max(0.0, 1 - entry.weight / threshold) / entry.weight;
    sum += entry.weight;
  }
  std::erase_if(penalties, [](const ViewWeight& entry) { return entry.weight <= 0; });
  for (ViewWeight& entry : penalties) entry.weight /= sum;
  return penalties;
}

double LumigraphPenalty(const Vector3d& point, const Vector3d& virtual_center, const Vector3d& view_center,
                        double resolution) {
  const Vector3d to_virtual = virtual_center - point, to_view = view_center - point;
  return AngleBetween(to_virtual, to_view) +
         resolution * std::max(0.0, to_view.norm() / to_virtual.norm() - 1);
}

std::vector<int> ViewsByDistance(const RenderScene& scene, const Vector3d& virtual_center) {
  // Computed before the comparison: a compiler may round the two sides differently, and then each of two
  // views with one centre would come before the other.
  std::vector<std::pair<double, int>> distances;
  for (std::size_t i = 0; i < scene.views.size(); ++i)
    distances.emplace_back((scene.views[i].center_in_world - virtual_center).squaredNorm(),
                           static_cast<int>(i));
  std::ranges::sort(distances);
  std::vector<int> order;
  for (const auto& [distance, view] : distances) order.push_back(view);
  return order;
}

std::unique_ptr<PlacedField> LumigraphField::From(const Vector3d& virtual_center) const {
  return std::make_unique<LumigraphFromHere>(scene_, options_, virtual_center);
}

std::unique_ptr<PlacedField> NearestField::From(const Vector3d& virtual_center) const {
  return std::make_unique<NearestFromHere>(scene_, virtual_center);
}

}  // namespace ulf::render
