// A capture of many views one after the other, as fast as they are taken: what grows with the number of views.
#pragma once

#include "tests/support/growth/capture_growth.h"

namespace ulf::test {

struct LongCapture {
  CameraModel camera;
  coverage::CaptureSummary summary;
  std::vector<GrowthRow> rows;
};
// `views` viewpoints of a textured plane over a cap of a hundred degrees, at 320x240, poses known: each becomes a view.
// No tracking, no geometry, no display.
LongCapture CaptureManyViews(const std::filesystem::path& light_field, int views, int rows);

}  // namespace ulf::test
