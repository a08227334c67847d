// Makes masks of what was before the lens in single views: a hand, somebody who walked through.
//
// Each view is compared with what its neighbours show of the mesh's surface. Their pictures, drawn from the
// view's place, must agree with each other (else the surface is wrong there, or it shines, and nothing is
// judged); their median is the prediction. Where it has structure, the view must have the same one
// (normalised correlation, a few pixels of error allowed); where it is plain, the view must be plain and
// have its colour. Brightness is free, so shadows and exposures do not matter. Large coherent parts that
// differ are masked, if the view agrees elsewhere: one that nowhere agrees is blurred or has a wrong pose.
//
// Limits: where the mesh has holes or fewer than three neighbours see it, nothing is masked; what stood still
// over several neighbouring views is taken for the scene; a blob of the scene's own colour before a plain
// surface is not told from a shadow.
#pragma once

#include <filesystem>
#include <map>
#include <opencv2/core.hpp>

#include "core/base/progress.h"
#include "core/light_field/light_field.h"
#include "render/proxy/triangle_mesh.h"

namespace ulf::render {

struct MovedMaskOptions {
  int size_px = 480;  // px, longer side of the compared pictures; masks have the photographs' size
};

struct MovedMasks {
  // By View::id, of views with such a part: CV_8UC1 of the photograph's size, 0: hidden, or excluded by the
  // view's own mask; 255: used.
  std::map<int, cv::Mat> masks;
  std::map<int, double> shares;  // by View::id: share of the photograph that is hidden
  double judged_share = 0;       // of all pixels: where the view could be compared
};

// Throws Error if a photograph cannot be read.
MovedMasks MakeMovedMasks(const LightField& light_field, const TriangleMesh& mesh,
                          const MovedMaskOptions& options = {}, Progress* progress = nullptr);

// Makes the masks by the light field's own mesh (kMeshProxyFile) and writes them into it, with a progress
// line. Throws Error without a mesh, and as LightFieldWriter does; then the light field is as it was.
MovedMasks WriteMovedMasks(const std::filesystem::path& dir, const MovedMaskOptions& options = {});

}  // namespace ulf::render
