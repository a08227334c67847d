// Exports a light field for other programs: COLMAP's or nerfstudio's folder, with the photographs unchanged
// or undistorted, masks, and points with their observations.
//
//   OUT/images/NAME  OUT/masks/NAME.png  and  OUT/sparse/0/{cameras,images,points3D}.{txt,bin}
//                                        or   OUT/transforms.json  OUT/points.ply
//
// Poses are unchanged. Photographs that need no change are copied byte for byte. Names lose folders and
// spaces, which some readers do not accept. The export is complete, or OUT does not exist.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "core/image/undistortion.h"
#include "core/light_field/light_field.h"
#include "core/light_field/points/point_tracks.h"

namespace ulf {

enum class ExportForm { kColmapText, kColmapBinary, kNerfstudio };

struct ExportOptions {
  ExportForm form = ExportForm::kColmapText;
  bool undistort = false;
  std::function<void(double share, const std::string& what)> progress = {};
  std::function<bool()> stop = {};  // polled; true: throws Error and leaves nothing
};

struct ExportSummary {
  std::size_t copied = 0, made = 0;  // photographs
  std::size_t masks = 0;
  std::vector<Undistortion> cameras;  // of undistorted photographs, one per camera
  PointStatistics points;
};

// Checks before any work: throws Error when OUT exists and is not empty, UsageError when the form cannot
// represent the light field.
void RequireExportable(const LightField& light_field, const std::filesystem::path& out,
                       const ExportOptions& options);

// Throws Error when OUT exists and is not empty, a photograph cannot be read or the disk is full; UsageError
// when the form cannot represent the light field.
ExportSummary ExportLightField(const LightField& light_field, const std::filesystem::path& out,
                               const ExportOptions& options);

// The views and points of the export, with paths relative to it.
LightField AsExported(const LightField& light_field, bool undistort, std::vector<Undistortion>* cameras);

}  // namespace ulf
