// Options of the blending field that is drawn (blending_field.h): kinds, their names, and the field that
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

// The values of FieldOptions::soft_width between which evidence chooses.
inline constexpr double kNarrowSoft = 0.5, kWideSoft = 0.8;
// The largest FieldOptions::lumigraph_k: the shaders have arrays of this size.
inline constexpr int kMostLumigraphViews = 8;

bool UsesMesh(FieldKind kind);          // whether the weights come from the viewpoint mesh
std::string FieldName(FieldKind kind);  // as on the command line
// Throws Refusal that names `parameter` and lists the names.
FieldKind FieldFromName(const std::string& name, std::string_view parameter = "field");

struct FieldOptions {
  FieldKind kind = FieldKind::kSubdivision;
  // Subdivision level, 0 to kFinestLevel; 0 equals kLinear. Measured (docs/measured/speed_and_accuracy.md:
  // further levels bring 0.01 to 0.04 dB).
  int level = 1;
  SubdivisionRules rules = SubdivisionRules::kDelaunay;
  int lumigraph_k = 0;                // number of weighted views at a point; 0: chosen by FieldThatServes()
  double lumigraph_resolution = 0.1;  // radians, penalty for a view twice as far away as V
  int lumigraph_triangles = 2000;     // number of image triangles, for weights at vertices
  // Standard deviation of the soft field's view weights, as a factor of the fourth smallest penalty. Narrow
  // keeps highlights in place; wide averages errors of poses and depth out. Settled on fern (0.8) and
  // fox_half (0.5).
  double soft_width = kNarrowSoft;
  bool operator==(const FieldOptions&) const = default;
};

// Returns the kind with its details: "subdivision 1", "subdivision 1 (Loop)", "soft 0.5", "lumigraph".
std::string FieldText(const FieldOptions& field);

// Returns the field that these viewpoints allow: lumigraph weights instead of a mesh if they span no surface,
// the nearest view if they are all in one place (ViewpointMesh::Description() explains it). A lumigraph_k of
// 0 becomes the number of corners of a simplex of the viewpoints plus one, whose penalty is the threshold of
// the others: four on a surface, three on a line (measured: docs/rendering.md, temple_ring).
FieldOptions FieldThatServes(const FieldOptions& asked, const ViewpointMesh& mesh);

// With fewer views, none are left out and compared. Guessed.
inline constexpr int kFewestViewsCompared = 10;
// Returns the default field, with these details, of every command, the viewer, the review of a capture and a
// page, unless evidence chooses: lumigraph weights of few views, because they smooth the least, otherwise
// subdivision, as far as the viewpoints allow.
FieldOptions DefaultField(const RenderScene& scene, const FieldOptions& details = {});

}  // namespace ulf::render
