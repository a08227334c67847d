// How far two renderers agree on a picture: outside the band of a pixel where what is visible changes.
#pragma once

#include <opencv2/core.hpp>

#include "render/renderer/renderer.h"
#include "tests/support/floors.h"

namespace ulf::test {

struct Agreement {
  double within_share = 0;  // of pixels outside the band that differ by no more than 2/255
  double band_share = 0;
  double within_share_of_all = 0;  // band included
  double mean_abs = 0;             // over all pixels, in 1/255
  // Outside the band: whose confidence differs by no more than 0.02, and both are drawn or neither.
  double confidence_share = 0;
};

// Pixels where some weighted view begins or ceases to see the proxy between a pixel and its neighbours, where
// another view fills, or where the proxy's depth jumps. Of the options what the renderer says it uses.
cv::Mat VisibilityBand(const RenderScene& scene, const RenderOptions& options, const CameraModel& camera,
                       const Rigid3& cam_from_world);

Agreement Compare(const Rendering& a, const Rendering& b, const cv::Mat& band);

}  // namespace ulf::test
