// What the viewer says, as values.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "render/display/plain_panels.h"
#include "render/viewer/viewer_state.h"

namespace ulf::render {

struct ViewerFigures {
  std::size_t views = 0;
  FieldOptions field;  // that is used, which may not be what was asked
  std::string proxy;
  double focus_depth = 0;               // of the focal plane, along the optical axis
  std::optional<double> f_number = {};  // of the aperture, where that has a size in metres
  bool loading = false;                 // of this picture some photographs are still being read
  cv::Size drawn_size = {};             // of the light field where that is not the window's, else empty
  double frame_ms = 0;                  // the last frame, all of it; 0: none yet
  double picture_ms = 0;                // of that the light field
};

std::vector<StatusItem> StatusLine(const ViewerState& state, const ViewerFigures& figures);

}  // namespace ulf::render
