// What an export of a light field (export_light_field.h) is to hold.
#pragma once

#include <cstddef>
#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <set>
#include <string>

#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "core/image/undistortion.h"
#include "core/light_field/exchange/writers/colmap_program.h"
#include "core/light_field/light_field.h"

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
// The poses of the upper and lower edge of the exported picture of a rolling shutter; none: the camera
// stood still.
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
  ColmapVersion colmap = {};    // that the commands beside its folder are for
  EdgePosesOf edge_poses = {};  // for transforms.json of nerfstudio and instant-ngp; empty: none
  std::function<void(double share, const std::string& what)> progress = {};
  std::function<bool()> stop = {};  // polled; if true, the export throws Error and leaves nothing
};

struct DepthSummary {
  std::size_t maps = 0;
  // Numbers of pixels: all, those with a depth, and those too deep for the PNG, where it has 0.
  std::size_t pixels = 0, known = 0, beyond = 0;
};

}  // namespace ulf
