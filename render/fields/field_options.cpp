#include "render/fields/field_options.h"

#include <fmt/core.h>

#include <fmt/format.h>
#include <array>

#include "core/base/error.h"

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

FieldKind FieldFromName(const std::string& name, std::string_view parameter) {
  std::vector<std::string_view> known;
  if (parameter == "field") known.emplace_back("auto");
  for (const NamedField& entry : kNames) {
    if (name == entry.name) return entry.kind;
    known.emplace_back(entry.name);
  }
  throw Refusal(Parameter(parameter), name, "no such blending field",
                fmt::format("there are {}", fmt::join(known, ", ")));
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

}  // namespace ulf::render
