// A light field as other programs want it: COLMAP's folder or nerfstudio's, with its photographs as they are
// or undistorted, masks beside them, and what views show of the points.
//
//   OUT/images/NAME  OUT/masks/NAME.png  and  OUT/sparse/0/{cameras,images,points3D}.{txt,bin}
//                                        or   OUT/transforms.json  OUT/points.ply
//
// Poses stay exactly as they are. Photographs that need not change are copied byte for byte; names lose what
// readers stumble over (folders, spaces). All of it is there at the end, or nothing.
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
  std::function<bool()> stop = {};  // asked now and then; then Error, and nothing is left
};

struct ExportSummary {
  std::size_t copied = 0, made = 0;  // photographs
  std::size_t masks = 0;
  std::vector<Undistortion> cameras;  // where photographs are undistorted, one for each camera
  PointStatistics points;
};

// What can be found out before any work: throws Error where OUT is not free, UsageError where the form cannot
// say what the light field holds.
void RequireExportable(const LightField& light_field, const std::filesystem::path& out,
                       const ExportOptions& options);

// Throws Error where OUT is not free, a photograph cannot be read or the disk is full; UsageError where the
// form cannot say what the light field holds.
ExportSummary ExportLightField(const LightField& light_field, const std::filesystem::path& out,
                               const ExportOptions& options);

// Views and points as they will be in the export, paths relative to it: what the model is written from.
LightField AsExported(const LightField& light_field, bool undistort, std::vector<Undistortion>* cameras);

}  // namespace ulf
