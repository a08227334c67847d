// Says which blending field is drawn (blending_field.h): its kind, its name on the command line, its details,
// and the field that the viewpoints allow instead.
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

// The two values of FieldOptions::soft_width between which evidence chooses (render/quality/choice.h).
inline constexpr double kNarrowSoft = 0.5, kWideSoft = 0.8;
// The largest FieldOptions::lumigraph_k: the shaders have arrays of this size.
inline constexpr int kMostLumigraphViews = 8;

bool UsesMesh(FieldKind kind);          // whether the weights come from the viewpoint mesh
std::string FieldName(FieldKind kind);  // as on the command line
// Throws Refusal for an unknown name; it names `parameter` and lists the names.
FieldKind FieldFromName(const std::string& name, std::string_view parameter = "field");

struct FieldOptions {
  FieldKind kind = FieldKind::kSubdivision;
  // Subdivision level, 0 to kFinestLevel; 0 equals kLinear. Measured (docs/measured/speed_and_accuracy.md:
  // further levels bring 0.01 to 0.04 dB).
  int level = 1;
  SubdivisionRules rules = SubdivisionRules::kDelaunay;
  int lumigraph_k = 0;  // number of weighted views at a point; 0: FieldThatServes() chooses it
  // Radians: the penalty of a view that is twice as far from the point as the virtual camera.
  double lumigraph_resolution = 0.1;
  int lumigraph_triangles = 2000;  // approximate number of image triangles of kLumigraph
  // The soft field's weight of a view is a Gaussian of its penalty; this times the fourth smallest penalty at
  // a point is its standard deviation. Narrow keeps highlights in place; wide averages errors of poses and
  // depth out. Settled on the data sets fern (0.8) and fox_half (0.5).
  double soft_width = kNarrowSoft;
  bool operator==(const FieldOptions&) const = default;
};

// Returns the kind with its details: "subdivision 1", "subdivision 1 (Loop)", "soft 0.5", "lumigraph".
std::string FieldText(const FieldOptions& field);

// Returns the field that these viewpoints allow: lumigraph weights instead of a mesh if they span no surface,
// the nearest view if they are all in one place (ViewpointMesh::Description() explains it). A lumigraph_k of
// 0 becomes four on a surface and three on a line: the corners of a simplex of viewpoints, and one more
// (measured: docs/rendering.md, temple_ring).
FieldOptions FieldThatServes(const FieldOptions& asked, const ViewpointMesh& mesh);

// With fewer views, none is left out to choose a field by evidence (render/quality/choice.h). Guessed.
inline constexpr int kFewestViewsCompared = 10;
// Returns the field that every command, the viewer, the review of a capture and a page draw unless another is
// chosen, with these details: lumigraph weights for fewer than kFewestViewsCompared views, because they
// smooth the least, otherwise subdivision; or what the viewpoints allow.
FieldOptions DefaultField(const RenderScene& scene, const FieldOptions& details = {});

}  // namespace ulf::render
