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

#include <filesystem>
#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/geometry/rigid3.h"
#include "core/image/undistortion.h"
#include "core/light_field/light_field.h"
#include "core/light_field/points/point_tracks.h"

namespace ulf {

enum class ExportForm {
  kColmapText,
  kColmapBinary,
  kNerfstudio,
  kInstantNgp,
  kNerfSynthetic,  // always undistorted
  kRealityScan,
  kMetashape
};
// Returns whether the form has points; if not, none need be measured.
bool HasPoints(ExportForm form);
// Returns whether the form's programs read depth maps.
bool HasDepths(ExportForm form);

// The depth of an exported photograph's pixels, of its size.
struct PhotographDepth {
  cv::Mat depth;       // CV_32F, along the optical axis, world units; 0: unknown
  cv::Mat confidence;  // CV_32F, 0 to 1; empty: nothing judges the depths
};
struct DepthSource {
  // Is called by several threads with a view of the light field and its camera in the export.
  std::function<PhotographDepth(const View& view, const CameraModel& exported)> of;
  double png_unit = 1e-3;  // world units that 1 in a PNG stands for
};

// How photographs are written. kAsTheyAre: copied where nothing changes them, otherwise PNG of 8 bits. The
// others take the view's light of highest dynamic range (ReadRecordedLight()); kExr is linear light above
// black, 32-bit float, with chromaticities where the colours are known.
enum class PhotographFormat { kAsTheyAre, kJpeg, kPng16, kExr };

// Photographs that are resampled otherwise than their lens demands, such as those of a rolling shutter to one
// instant.
struct Resampling {
  std::set<int> views;  // ids
  // Is called by several threads with a view of the light field and its camera in the export.
  std::function<UndistortionMap(const View& view, const CameraModel& exported)> map_of;
};
// The poses of the exported picture's upper and lower edge, of a rolling shutter; none: it moved not.
struct EdgePoses {
  Rigid3 upper_from_world, lower_from_world;
};
using EdgePosesOf = std::function<std::optional<EdgePoses>(const View& view, const CameraModel& exported)>;

struct ExportOptions {
  ExportForm form = ExportForm::kColmapText;
  bool undistort = false;
  PhotographFormat format = PhotographFormat::kAsTheyAre;
  int jpeg_quality = 95;
  // Writes exposure time, f-number, ISO, focal length, lens and camera into photographs, as far as they are
  // known: Exif in JPEG and PNG, attributes in EXR.
  bool with_exposures = false;
  // Returns the photograph in even light (CV_32FC3, linear), called by several threads; empty: as recorded.
  std::function<cv::Mat(const View& view)> even_light = {};
  std::optional<DepthSource> depths = {};  // none: no depth maps
  std::optional<Resampling> resampling = {};
  EdgePosesOf edge_poses = {};  // for transforms.json of nerfstudio and instant-ngp; empty: none
  std::function<void(double share, const std::string& what)> progress = {};
  std::function<bool()> stop = {};  // polled; if true, the export throws Error and leaves nothing
};

struct DepthSummary {
  std::size_t maps = 0;
  // Numbers of pixels: all, those with a depth, and those too deep for the PNG, where it has 0.
  std::size_t pixels = 0, known = 0, beyond = 0;
};

struct ExportSummary {
  std::size_t copied = 0, made = 0;  // numbers of photographs copied unchanged, and written anew
  std::size_t masks = 0;
  std::size_t with_exposures = 0;  // photographs that say their exposure, of those that were to
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

// Runs both checks, then exports. Throws also if a photograph cannot be read, the disk is full, or `stop()`.
ExportSummary ExportLightField(const LightField& light_field, const std::filesystem::path& out,
                               const ExportOptions& options);

}  // namespace ulf
