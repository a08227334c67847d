// Light fields by others, taken in: nerfstudio's and instant-ngp's transforms.json.
#pragma once

#include <filesystem>
#include <optional>

#include "acquisition/light_field.h"

namespace ulf {

struct ImportOptions {
  std::optional<Subject> subject;  // none: the point nearest the optical axes, where that is well conditioned
};

// Copies SOURCE (a folder with transforms.json, or such a file) into the new light field DIR. Photographs are
// checked (they must decode and have their camera's size) and kept byte for byte; more than 8 bits go to
// masters/ with an 8-bit sRGB copy in images/. Throws Error for a bad source, UsageError when the subject
// must be given.
LightField Import(const std::filesystem::path& source, const std::filesystem::path& dir,
                  const ImportOptions& options);

// "x,y,z,r" in world units; throws UsageError.
Subject ParseSubject(const std::string& text);

}  // namespace ulf
