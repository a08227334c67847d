// The camera blending field: for every ray of the virtual camera, the weight of each recorded view.
//
// All fields have one contract. Given the virtual camera's centre V, and for a pixel the ray through V and
// the point P where that ray meets the proxy, a field returns a list of (view, weight). Weights are not
// negative and sum to one; the list is empty where the field has no view. The renderer checks which of the
// views really see P.
//
//   kLinear, kSubdivision  by where the line through V crosses the mesh of viewpoints (thesis, 5.1 and 5.3)
//   kLumigraph             the k best views by angle and resolution at P (Buehler et al. 2001)
//   kNearest               the view nearest to V that sees P
//
// The soft field (kSoft) is the exception: it weighs surfaces as well as views, and is no BlendingField.
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
  kSoft,               // by the views' depth maps and agreement (render/renderer/soft_pixel.h)
  kNearest,
};

// Of FieldOptions::soft_width: those between which evidence chooses.
inline constexpr double kNarrowSoft = 0.5, kWideSoft = 0.8;
// Of FieldOptions::lumigraph_k: the shaders have arrays of this size.
inline constexpr int kMostLumigraphViews = 8;

bool UsesMesh(FieldKind kind);          // whether the weights come from the mesh of viewpoints
std::string FieldName(FieldKind kind);  // as on the command line
// Throws UsageError that names `option` and lists the names.
FieldKind FieldFromName(const std::string& name, const std::string& option = "--field");

struct FieldOptions {
  FieldKind kind = FieldKind::kSubdivision;
  // Of subdivision: 0 to kFinestLevel; 0 equals kLinear. Measured
  // (docs/speed_and_accuracy.md: further levels bring 0.01 to 0.04 dB).
  int level = 1;
  SubdivisionRules rules = SubdivisionRules::kDelaunay;
  int lumigraph_k = 0;                // views that get weight at a point; 0: chosen by FieldThatServes()
  double lumigraph_resolution = 0.1;  // penalty in radians for a view twice as far away as V
  int lumigraph_triangles = 2000;     // of the image, for weights at vertices
  // Of the soft field: the standard deviation of the views' weights, in the fourth smallest penalty. Narrow: what shines
  // keeps its place; wide: errors of poses and depth average out. Settled on fern (0.8) and fox_half (0.5).
  double soft_width = kNarrowSoft;
  bool operator==(const FieldOptions&) const = default;
};

// "subdivision 1", "subdivision 1 (Loop)", "soft 0.5", "lumigraph": the kind, and what it has in details.
std::string FieldText(const FieldOptions& field);

// The field that these viewpoints allow: lumigraph weights instead of a mesh where they span no surface, the
// nearest view where they all stand in one place (ViewpointMesh::Description() tells people). Where
// lumigraph_k is 0 it becomes the number of corners of a simplex of the viewpoints plus one, whose penalty is
// the threshold of the others: four on a surface, three on a line (measured: docs/rendering.md, temple_ring).
FieldOptions FieldThatServes(const FieldOptions& asked, const ViewpointMesh& mesh);

// With fewer views none are left out and compared. Guessed.
inline constexpr int kFewestViewsCompared = 10;
// The field, with these details, that every command, the viewer, the review of a capture and a page draw where nothing is
// compared: lumigraph weights of few views, because they smooth the least, else subdivision; of both what the viewpoints
// allow.
FieldOptions DefaultField(const RenderScene& scene, const FieldOptions& details = {});

struct ViewWeight {
  int view = 0;  // index into RenderScene::views
  double weight = 0;
};

struct FieldSample {
  std::vector<ViewWeight> weights;
  // 1 between views that stand close together; less in wide triangles and outside the hull.
  double confidence = 0;
  bool extrapolated = false;          // outside the hull
  void Add(int view, double weight);  // to the view's weight; weights of 0 or less are ignored
};

struct RayQuery {
  Eigen::Vector3d ray_in_world;    // unit, from V through the pixel
  Eigen::Vector3d point_in_world;  // where it meets the proxy
  // From CandidatesInCone() for a cone that contains the ray; null: all.
  const std::vector<int>* candidates = nullptr;
};

// The field for one virtual camera's centre. It may outlive the BlendingField.
class FieldFromHere {
 public:
  virtual ~FieldFromHere() = default;
  // The field's triangles that rays within `half_angle` (radians, less than a right angle) of `axis` can
  // meet; empty for fields that do not use candidates.
  virtual std::vector<int> CandidatesInCone(const Eigen::Vector3d& /*axis_in_world*/,
                                            double /*half_angle*/) const {
    return {};
  }
  virtual void Weights(const RayQuery& query, FieldSample& sample) const = 0;
};

class BlendingField {
 public:
  virtual ~BlendingField() = default;
  virtual std::unique_ptr<FieldFromHere> From(const Eigen::Vector3d& virtual_center_in_world) const = 0;
};

// The field keeps the scene alive. Throws Error for kSoft.
std::unique_ptr<BlendingField> MakeField(std::shared_ptr<const RenderScene> scene,
                                         const FieldOptions& options);

// Where the weights sum to less before they are normalised, the field has no view. Guessed.
inline constexpr double kLeastWeightOfField = 1e-4;
// Confidence outside the hull of the viewpoints. Guessed.
inline constexpr double kExtrapolatedConfidence = 0.25;

}  // namespace ulf::render
