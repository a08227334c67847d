// Light fields by others, taken in: nerfstudio's and instant-ngp's transforms.json.
#pragma once

#include <filesystem>
#include <optional>

#include "core/light_field/light_field.h"

namespace ulf {

struct ImportOptions {
  std::optional<Subject> subject;  // none: the point nearest the optical axes, where that is well conditioned
};

// Copies SOURCE (a folder with transforms.json, or such a file) into the new light field DIR. Photographs are
// checked (they must decode and have their camera's size) and kept byte for byte; more than 8 bits go to
// masters/ with an 8-bit sRGB copy in images/. Masks, and alpha that hides something, go to masks/; points to
// points.ply. White space in names becomes '_'. DIR is whole in the end or, whatever fails, not there. What
// of the source is not understood stands in LightField::doubts. Throws Error for a bad source, DiskFullError,
// UsageError when the subject must be given.
LightField Import(const std::filesystem::path& source, const std::filesystem::path& dir,
                  const ImportOptions& options);

}  // namespace ulf
