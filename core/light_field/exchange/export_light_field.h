// Exports a light field to the folder layouts of other programs, with the photographs unchanged or
// undistorted, masks, and points with their observations.
//
//   COLMAP          images/NAME  masks/NAME.png  sparse/0/{cameras,images,points3D,rigs,frames}.{txt,bin}
//   nerfstudio      images/NAME  masks/NAME.png  transforms.json  points.ply
//   instant-ngp     images/NAME  images/dynamic_mask_STEM.png  transforms.json
//   NeRF synthetic  {train,test}/STEM.png (RGBA)  transforms_{train,val,test}.json
//   RealityScan     images/NAME  images/STEM.xmp  images/NAME.mask.png
//   Metashape       images/NAME  masks/STEM_mask.png  cameras.xml  points.ply
//
// On request COLMAP's, nerfstudio's and instant-ngp's folders get depths/STEM.exr and depths/STEM.png, too.
//
// Poses are unchanged (NeRF's synthetic sets have a world of their own). Photographs that need no change are
// copied byte for byte. Names lose folders and spaces, which some readers do not accept. The export is
// complete, or the folder `out` does not exist.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/image/undistortion.h"
#include "core/light_field/exchange/export_options.h"
#include "core/light_field/light_field.h"
#include "core/light_field/points/point_tracks.h"

namespace ulf {

// Returns whether the form has points; if not, none need be measured.
bool HasPoints(ExportForm form);
// Returns whether the form's programs read depth maps.
bool HasDepths(ExportForm form);

// Numbers of photographs that say something of their exposure, and of those what.
struct ExposureCounts {
  std::size_t photographs = 0, times = 0, f_numbers = 0, isos = 0;
};

struct ExportSummary {
  std::size_t copied = 0, made = 0;  // numbers of photographs copied unchanged, and written anew
  std::size_t masks = 0;
  ExposureCounts exposures;  // of photographs that were to say theirs
  DepthSummary depths;
  std::vector<Undistortion> cameras;  // by index into LightField::cameras; empty if nothing was undistorted
  PointStatistics points;
  std::vector<std::string> doubts;    // sentences on what the form's programs will not read as it is
  std::vector<std::string> commands;  // of a shell, by which the form's program goes on with the folder
};

// Throws Refusal naming Parameter(`parameter`) if `out` lies in the light field's folder.
void RequireOutside(const std::filesystem::path& light_field, const std::filesystem::path& out,
                    std::string_view parameter = "output");

// Checks before any work: throws Error when there is no view or `out` exists and is not empty, Refusal when
// the form cannot represent the light field or `out` lies in it.
void RequireExportable(const LightField& light_field, const std::filesystem::path& out,
                       const ExportOptions& options);
// Throws DiskFullError if the photographs that are copied unchanged do not fit on the disk of `out`.
void RequireRoomFor(const LightField& light_field, const std::filesystem::path& out,
                    const ExportOptions& options);

// Returns how many photographs are made at a time: a few for each processor, but no more than fit into half
// of the `available` bytes, and at least one.
std::size_t PicturesAtOnce(const LightField& light_field, std::uint64_t available);

// Runs both checks, then exports. Throws also if a photograph cannot be read, the disk is full, or `stop()`.
ExportSummary ExportLightField(const LightField& light_field, const std::filesystem::path& out,
                               const ExportOptions& options);

}  // namespace ulf
