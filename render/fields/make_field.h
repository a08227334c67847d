// Makes the blending field that options ask for.
#pragma once

#include <memory>

#include "render/fields/blending_field.h"
#include "render/fields/field_options.h"

namespace ulf::render {

// The field keeps the scene alive. Throws Error for kSoft.
std::unique_ptr<BlendingField> MakeField(std::shared_ptr<const RenderScene> scene,
                                         const FieldOptions& options);

// Where the weights sum to less before they are normalised, the field has no view. Guessed.
inline constexpr double kLeastWeightOfField = 1e-4;

}  // namespace ulf::render
