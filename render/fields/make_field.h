// Makes the blending field that options ask for.
#pragma once

#include <memory>

#include "core/base/error.h"
#include "render/fields/blending_field.h"
#include "render/fields/field_options.h"
#include "render/fields/lumigraph_field.h"
#include "render/fields/mesh_field.h"

namespace ulf::render {

// The field keeps the scene alive. Throws Error for kSoft.
inline std::unique_ptr<BlendingField> MakeField(std::shared_ptr<const RenderScene> scene,
                                                const FieldOptions& options) {
  const FieldOptions serves = FieldThatServes(options, scene->mesh);
  switch (serves.kind) {
    case FieldKind::kLinear:
    case FieldKind::kSubdivision:
      return std::make_unique<MeshField>(std::move(scene), serves.level, serves.rules);
    case FieldKind::kLumigraph:
    case FieldKind::kLumigraphPerPixel:
      return std::make_unique<LumigraphField>(std::move(scene), serves);
    case FieldKind::kNearest:
      return std::make_unique<NearestField>(std::move(scene));
    case FieldKind::kSoft:
      break;
  }
  throw Error("the soft field has no weights of a point alone");
}

}  // namespace ulf::render
