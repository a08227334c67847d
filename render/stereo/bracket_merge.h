// Merges the exposures of a recorded view (a bracket) to one picture of linear light, in the view's pixels.
//
// The camera moved from one exposure to the next: each is resampled as the view's camera would have seen it,
// by its pose and the geometry's depth (core/image/exposure_alignment.h), then merged by noise
// (core/image/exposure_merge.h). How the exposures' light relates is told by their times, gains and
// apertures; where the pictures say something else by more than two per cent (shutters are not exact) it is
// measured; by more than half a stop, the exposure is left out.
//
// A long exposure in a moving hand is blurred. How much is told by the poses around it and its time; such an
// exposure counts less where the light changes.
//
// Light is in shares of the full scale of the view's own exposure, above black; flat field and colour profile
// are not applied, as in masters.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/image/exposure_merge.h"
#include "core/light_field/light_field.h"
#include "render/proxy/proxy.h"

namespace ulf::render {

struct BracketMergeOptions {
  bool align = true;  // false: as if the camera had stood still, for comparison
};

struct MergedView {
  MergedLight merged;
  int exposures = 1;                  // that went into it
  double shortest = 1, longest = 1;   // of them, over the view's own
  double most_blur_px = 0;            // of them, by how the camera moved
  std::vector<std::string> left_out;  // a sentence each
};

// The best geometry that the light field has of its own, else the plane through its subject. Throws Refusal
// where it has neither geometry nor subject, and the optical axes meet nowhere.
std::shared_ptr<const Proxy> ProxyForBrackets(const LightField& light_field);

// Depth of what the view shows, along the optical axis of its picture's pixels: CV_32FC1, world units.
cv::Mat DepthOfView(const LightField& light_field, const View& view, const Proxy& proxy);

// Throws Error for files that cannot be read, Refusal where the view's own exposure time is not known.
MergedView MergeExposuresOf(const LightField& light_field, const View& view, const Proxy& proxy,
                            const BracketMergeOptions& options = {});

// The file merged/NNNNNN.exr: R, G, B, and the channels `clipped` and `ghosts`
// (core/light_field/light_field.h).
std::string MergedExr(const View& view, const MergedView& merged);

// Of all views that were merged.
struct BracketReport {
  std::size_t views = 0;      // merged now
  std::size_t exposures = 0;  // that went into them
  std::size_t left_out = 0;   // exposures whose light is not what their time tells
  double stops = 0;           // the longest over the shortest exposure, most
  std::string geometry;       // by which exposures were aligned: a proxy's name
  // Of the merged views: shares of their pixels.
  double ghosts_median = 0, ghosts_most = 0;
  int ghosts_most_view = 0;
  double clipped_most = 0;
  // Of any exposure, by how the camera moved during it.
  double blur_most_px = 0;
  int blur_most_view = 0;
};

// Merges the exposures of all views of a light field, with a progress line, and writes them. Nothing where no
// view has other exposures. Throws Error.
BracketReport MergeBrackets(const std::filesystem::path& light_field);

}  // namespace ulf::render
