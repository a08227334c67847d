// The light field on disk: a folder with the files that nerfstudio, instant-ngp and COLMAP's readers open.
// The append-only journal is authoritative; LightFieldWriter's Close() and Resume() and the repair derive
// transforms.json and sparse/0 from it. Reading never writes.
//
//   journal.jsonl  transforms.json  sparse/0/  images/  masters/  masks/  points.ulf  points.ply  unposed/
//   kept/  cache/
//
// docs/light_field.md describes every file and key, and what is promised about them.
#pragma once

#include <filesystem>

#include "core/light_field/light_field.h"

namespace ulf {

// Reads a folder from its journal, or else from transforms.json (keys of nerfstudio and instant-ngp), which
// `dir` may also name itself. Throws an Error that names file, frame and key for a value that is missing, of
// the wrong type, not finite, not a rotation, or a path outside the folder; and Error if photographs are
// missing or links are refused (followed_links.h). Damaged journal lines are ignored. These and all
// differences between the files (folder_check.h) are reported in LightField::doubts and as warnings.
LightField ReadLightField(const std::filesystem::path& dir);

// Writes a closed light field at light_field.root, whose pictures exist already: journal and derived files.
// Throws DiskFullError, Error.
void WriteLightField(const LightField& light_field);

}  // namespace ulf
