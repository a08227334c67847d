// Finds out in which format a set of posed photographs is, and reads it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/light_field/formats/posed_set.h"

namespace ulf {

// In the order in which they are looked for: what knows more comes first.
enum class SetFormat {
  kUlf,            // a light field: journal.jsonl
  kTransforms,     // nerfstudio, instant-ngp: transforms.json
  kNerfSynthetic,  // transforms_train.json
  kColmap,         // cameras and images, .bin or .txt, here or in sparse/0
  kLlff,           // poses_bounds.npy
  kBundler,        // bundle.out
  kMetashape,      // cameras .xml
  kRealityScan,    // .xmp beside the photographs
  kTum             // rgb.txt and groundtruth.txt
};
// As on the command line: "nerfstudio", "nerf-synthetic", "colmap", ...
const char* Name(SetFormat format);
// "auto" is none. Throws UsageError that lists the names.
std::optional<SetFormat> SetFormatFromName(const std::string& name);

// The formats in which `source`, a folder or a file, holds a set.
std::vector<SetFormat> FormatsIn(const std::filesystem::path& source);

// `format`: none: the first of FormatsIn(), with a doubt that names the others. `images`: the folder of the photographs
// where the format names them without it; empty: found by itself. `camera`: of the photographs, for a format that has no
// intrinsics, and for none else: UsageError. Throws Error for a source that holds no such set, with the way in which
// videos and plain photographs can be used, and what the readers throw.
PosedSet ReadPosedSet(const std::filesystem::path& source, const std::optional<SetFormat>& format,
                      const std::filesystem::path& images, const std::optional<CameraModel>& camera = {});

}  // namespace ulf
