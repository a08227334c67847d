#include "render/fields/blending_field.h"

#include <fmt/core.h>

#include <fmt/format.h>
#include <array>

#include "core/base/error.h"
#include "render/fields/lumigraph_field.h"
#include "render/fields/mesh_field.h"

namespace ulf::render {
namespace {

struct NamedField {
  FieldKind kind;
  const char* name;
};
constexpr std::array kNames{NamedField{FieldKind::kLinear, "linear"},
                            NamedField{FieldKind::kSubdivision, "subdivision"},
                            NamedField{FieldKind::kLumigraph, "lumigraph"},
                            NamedField{FieldKind::kLumigraphPerPixel, "lumigraph-per-pixel"},
                            NamedField{FieldKind::kSoft, "soft"},
                            NamedField{FieldKind::kNearest, "nearest"}};

}  // namespace

bool UsesMesh(FieldKind kind) { return kind == FieldKind::kLinear || kind == FieldKind::kSubdivision; }

std::string FieldName(FieldKind kind) {
  for (const NamedField& entry : kNames)
    if (entry.kind == kind) return entry.name;
  throw Error("blending field {}: no such kind", static_cast<int>(kind));
}

FieldKind FieldFromName(const std::string& name, const std::string& option) {
  std::vector<std::string_view> known;
  if (option == "--field") known.emplace_back("auto");
  for (const NamedField& entry : kNames) {
    if (name == entry.name) return entry.kind;
    known.emplace_back(entry.name);
  }
  throw UsageError("{} {}: no such blending field; there are {}", option, name, fmt::join(known, ", "));
}

std::string FieldText(const FieldOptions& field) {
  if (field.kind == FieldKind::kSoft) return fmt::format("{} {:g}", FieldName(field.kind), field.soft_width);
  if (field.kind != FieldKind::kSubdivision) return FieldName(field.kind);
  return fmt::format("{} {}{}", FieldName(field.kind), field.level,
                     field.rules == SubdivisionRules::kLoop ? " (Loop)" : "");
}

FieldOptions FieldThatServes(const FieldOptions& asked, const ViewpointMesh& mesh) {
  FieldOptions serves = asked;
  if (mesh.span == Span::kPlace) serves.kind = FieldKind::kNearest;
  if (mesh.span == Span::kLine && UsesMesh(asked.kind)) serves.kind = FieldKind::kLumigraph;
  if (serves.kind == FieldKind::kLinear) serves.level = 0;
  if (serves.lumigraph_k == 0) serves.lumigraph_k = mesh.span == Span::kSurface ? 4 : 3;
  return serves;
}

FieldOptions DefaultField(const RenderScene& scene, const FieldOptions& details) {
  FieldOptions field = details;
  const bool few = static_cast<int>(scene.views.size()) < kFewestViewsCompared;
  field.kind = few ? FieldKind::kLumigraph : FieldKind::kSubdivision;
  return FieldThatServes(field, scene.mesh);
}

void FieldSample::Add(int view, double weight) {
  if (weight <= 0) return;
  for (ViewWeight& entry : weights)
    if (entry.view == view) {
      entry.weight += weight;
      return;
    }
  weights.push_back({view, weight});
}

std::unique_ptr<BlendingField> MakeField(std::shared_ptr<const RenderScene> scene,
                                         const FieldOptions& options) {
  const FieldOptions serves = FieldThatServes(options, scene->mesh);
  if (serves.kind == FieldKind::kSoft) throw Error("the soft field has no weights of a point alone");
  if (UsesMesh(serves.kind)) return std::make_unique<MeshField>(std::move(scene), serves.level, serves.rules);
  if (serves.kind == FieldKind::kNearest) return std::make_unique<NearestField>(std::move(scene));
  return std::make_unique<LumigraphField>(std::move(scene), serves);
}

}  // namespace ulf::render
