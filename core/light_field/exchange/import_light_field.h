// Imports photographs with poses that another program estimated as a light field.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>

#include "core/light_field/formats/set_format.h"
#include "core/light_field/light_field.h"

namespace ulf {

struct ImportOptions {
  std::optional<Subject> subject = {};     // none: the set's, or else found (subject_of_set.h)
  bool without_subject = false;            // whatever the set says: for cameras that look outwards
  std::optional<SetFormat> format = {};    // none: recognised from the files
  std::filesystem::path images = {};       // the photographs' folder; empty: searched for
  std::filesystem::path model = {};        // COLMAP's, of the photographs in `source` (colmap_posing.h)
  std::optional<CameraModel> camera = {};  // for a format without intrinsics (read_posed_set.h)
  // The colour (B, G, R, 0 to 1) over which pictures with alpha are blended. None: alpha becomes a mask,
  // except that NeRF's synthetic sets are blended over white, as in the papers.
  std::optional<cv::Vec3d> background = {};
};

struct Imported {
  LightField light_field;
  std::string format;           // for people, as PosedSet::format
  std::string subject_told_by;  // for people, as SubjectOfSet::told_by; empty: the user or the set gave it
};

// Copies `source`, a folder or a file in one of the formats of set_format.h, into the new light field `dir`.
// Photographs are checked (they must decode and have their camera's size) and kept byte for byte; more than 8
// bits go to masters/ with an 8-bit sRGB copy in images/. Masks, and alpha that hides something, go to
// masks/; points to points.ulf and points.ply. White space in names becomes '_'. `dir` is complete at the
// end, or does not exist after a failure. Warnings tell what of the source is not used. Throws Error for an
// invalid source, DiskFullError, and Refusal if the subject or the camera must be given; photographs with
// `model`, and a light field that has no subject, may stay without one.
Imported Import(const std::filesystem::path& source, const std::filesystem::path& dir,
                const ImportOptions& options);

}  // namespace ulf
