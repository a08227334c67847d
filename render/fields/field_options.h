// Which blending field is drawn (blending_field.h), with its details: kinds, their names, and the field that
// viewpoints allow.
#pragma once

#include <string>
#include <string_view>

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
// Throws Refusal that names `parameter` and lists the names.
FieldKind FieldFromName(const std::string& name, std::string_view parameter = "field");

struct FieldOptions {
  FieldKind kind = FieldKind::kSubdivision;
  // Of subdivision: 0 to kFinestLevel; 0 equals kLinear. Measured
  // (docs/measured/speed_and_accuracy.md: further levels bring 0.01 to 0.04 dB).
  int level = 1;
  SubdivisionRules rules = SubdivisionRules::kDelaunay;
  int lumigraph_k = 0;                // views that get weight at a point; 0: chosen by FieldThatServes()
  double lumigraph_resolution = 0.1;  // penalty in radians for a view twice as far away as V
  int lumigraph_triangles = 2000;     // of the image, for weights at vertices
  // Of the soft field: the standard deviation of the views' weights, in the fourth smallest penalty. Narrow:
  // what shines keeps its place; wide: errors of poses and depth average out. Settled on fern (0.8) and
  // fox_half (0.5).
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
// The field, with these details, that every command, the viewer, the review of a capture and a page draw
// where nothing is compared: lumigraph weights of few views, because they smooth the least, else subdivision;
// of both what the viewpoints allow.
FieldOptions DefaultField(const RenderScene& scene, const FieldOptions& details = {});

}  // namespace ulf::render
