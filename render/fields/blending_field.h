// The camera blending field: for every ray of the virtual camera, the weight of each recorded view.
//
// One contract for all: given the virtual camera's centre V, and for a pixel the ray through V and the point
// P where that ray meets the proxy, a list of (view, weight), non-negative and summing to one; empty where
// the field has nothing to say. Which of these views really see P is the renderer's business.
//   kLinear, kSubdivision  where the line through V crosses the mesh of viewpoints (thesis, 5.1 and 5.3)
//   kLumigraph             the k best views by angle and resolution at P (Buehler et al. 2001)
//   kNearest               the view nearest to V that sees P
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "render/fields/loop_subdivision.h"
#include "render/scene/scene.h"

namespace ulf::render {

enum class FieldKind {
  kLinear,
  kSubdivision,
  kLumigraph,  // weights at the vertices of an image triangulation (render/fields/image_triangulation.h)
  kLumigraphPerPixel,  // weights over all views at every pixel
  kNearest,
};

inline constexpr int kMostLumigraphViews = 8;

bool UsesMesh(FieldKind kind);          // of viewpoints
std::string FieldName(FieldKind kind);  // as on the command line
// UsageError that lists the names; `option`: which asked.
FieldKind FieldFromName(const std::string& name, const std::string& option = "--field");
std::string LevelName(int level);            // "0" to "3", "limit"
int LevelFromName(const std::string& name);  // UsageError that lists the names

struct FieldOptions {
  FieldKind kind = FieldKind::kSubdivision;
  int level = 1;                      // of subdivision, 0 to kFinestLevel, or kLimitLevel; 0 is kLinear
  int lumigraph_k = 0;                // views that may have weight; 0: as many as suits the viewpoints
  double lumigraph_resolution = 0.1;  // of the penalty, in radians for a view twice as far away as V
  int lumigraph_triangles = 2000;     // that the image is cut into where weights are at vertices
  bool operator==(const FieldOptions&) const = default;
};

// The field that these viewpoints allow: lumigraph weights instead of a mesh where they span no surface, the
// nearest view where they all stand in one place. ViewpointMesh::Description() tells people. Lumigraph
// weights that leave their number open get one view more than a simplex of the viewpoints has, which is the
// threshold of the others: four on a surface, three on a line.
FieldOptions FieldThatServes(const FieldOptions& asked, const ViewpointMesh& mesh);

struct ViewWeight {
  int view = 0;  // index into RenderScene::views
  double weight = 0;
};

struct FieldSample {
  std::vector<ViewWeight> weights;
  double confidence = 0;      // 1 where views stand all around; less in wide triangles and outside the hull
  bool extrapolated = false;  // outside the hull
  void Add(int view, double weight);  // to what the view has; nothing of nothing
};

struct RayQuery {
  Eigen::Vector3d ray_in_world;    // unit, from V through the pixel
  Eigen::Vector3d point_in_world;  // where it meets the proxy
  const std::vector<int>* candidates =
      nullptr;  // from CandidatesInCone for a cone that holds the ray; or all
};

// The field as seen from one place; stands on its own.
class FieldFromHere {
 public:
  virtual ~FieldFromHere() = default;
  // What need be looked at for rays within `half_angle` (less than a right angle) of `axis`; empty where the
  // field does not use it.
  virtual std::vector<int> CandidatesInCone(const Eigen::Vector3d& axis_in_world, double half_angle) const;
  virtual void Weights(const RayQuery& query, FieldSample& sample) const = 0;
};

class BlendingField {
 public:
  virtual ~BlendingField() = default;
  virtual std::unique_ptr<FieldFromHere> From(const Eigen::Vector3d& virtual_center_in_world) const = 0;
};

// Keeps the scene alive.
std::unique_ptr<BlendingField> MakeField(std::shared_ptr<const RenderScene> scene,
                                         const FieldOptions& options);

// Weights that sum to less before they are normalised count as none.
inline constexpr double kLeastWeightOfField = 1e-4;
// Confidence of what is extrapolated past the hull.
inline constexpr double kExtrapolatedConfidence = 0.25;

}  // namespace ulf::render
