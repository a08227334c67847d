// Imports the transforms.json of nerfstudio and instant-ngp as a light field.
#pragma once

#include <filesystem>
#include <optional>

#include "core/light_field/light_field.h"

namespace ulf {

struct ImportOptions {
  std::optional<Subject> subject;  // none: the point nearest to the optical axes, if well conditioned
};

// Copies SOURCE (a folder with transforms.json, or such a file) into the new light field DIR. Photographs are
// checked (they must decode and have their camera's size) and kept byte for byte; more than 8 bits go to
// masters/ with an 8-bit sRGB copy in images/. Masks, and alpha that hides something, go to masks/; points to
// points.ply. White space in names becomes '_'. DIR is complete at the end, or does not exist after a
// failure. Keys of the source that ulf does not support are listed in LightField::doubts. Throws Error for an
// invalid source, DiskFullError, UsageError when the subject must be given.
LightField Import(const std::filesystem::path& source, const std::filesystem::path& dir,
                  const ImportOptions& options);

}  // namespace ulf
