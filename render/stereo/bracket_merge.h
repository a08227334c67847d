// Merges the exposures of a recorded view (a bracket) to one picture of linear light, in the view's pixels.
//
// The camera moved between exposures: each is resampled as the view's camera would have seen it, by its pose
// and the geometry's depth (core/image/exposure_alignment.h). Then they are merged with weights by noise
// (core/image/exposure_merge.h). Times, gains and apertures give the ratio of the exposures' light; if the
// pictures differ from it by more than two per cent (shutters are not exact), the measured ratio is used; by
// more than half a stop, the exposure is left out.
//
// A long exposure with a moving camera is blurred. The poses around it and its time tell how much; such an
// exposure counts less at edges.
//
// Light is a share of the full scale of the view's own exposure, above black; flat field and colour profile
// are not applied, as in masters.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/image/exposure_merge.h"
#include "core/light_field/light_field.h"
#include "render/proxy/proxy.h"

namespace ulf::render {

struct BracketMergeOptions {
  bool align = true;  // false: assume that the camera stood still, for comparison
};

struct MergedView {
  MergedLight merged;
  int exposures = 1;                  // number of merged exposures, the view's own included
  double shortest = 1, longest = 1;   // of these, in light relative to the view's own
  double most_blur_px = 0;            // largest blur of these by the camera's motion
  std::vector<std::string> left_out;  // a sentence each
};

// Returns the light field's most detailed own geometry, or else the plane through its subject. Throws Refusal
// if it has no subject and the optical axes meet nowhere.
std::shared_ptr<const Proxy> ProxyForBrackets(const LightField& light_field);

// Returns the depth of the photograph's pixels along the optical axis: CV_32FC1, world units.
cv::Mat DepthOfView(const LightField& light_field, const View& view, const Proxy& proxy);

// Throws Error for files that cannot be read, Refusal if the view's own exposure time is unknown.
MergedView MergeExposuresOf(const LightField& light_field, const View& view, const Proxy& proxy,
                            const BracketMergeOptions& options = {});

// Returns the content of merged/NNNNNN.exr: R, G, B, and the channels `clipped` and `ghosts`
// (core/light_field/light_field.h).
std::string MergedExr(const View& view, const MergedView& merged);

// The summary of all merged views.
struct BracketReport {
  std::size_t views = 0;      // merged now
  std::size_t exposures = 0;  // number of merged exposures
  std::size_t left_out = 0;   // number of exposures whose light contradicts their time
  double stops = 0;           // largest ratio of a view's longest to its shortest exposure, in stops
  std::string geometry;       // name of the proxy for alignment
  // Shares of the merged views' pixels.
  double ghosts_median = 0, ghosts_most = 0;
  int ghosts_most_view = 0;
  double clipped_most = 0;
  // The largest blur of an exposure by the camera's motion.
  double blur_most_px = 0;
  int blur_most_view = 0;
};

// Merges the exposures of all views of a light field, with a progress line, and writes them. Does nothing if
// no view has other exposures. Throws as MergeExposuresOf() and LightFieldWriter do.
BracketReport MergeBrackets(const std::filesystem::path& light_field);

}  // namespace ulf::render
