// The texts of the viewer, as values.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "render/display/plain_panels.h"
#include "render/fields/field_options.h"
#include "render/viewer/viewer_state.h"

namespace ulf::render {

struct ViewerFigures {
  std::size_t views = 0;
  FieldOptions field;  // in use, which may differ from the selected one
  std::string proxy;
  double focus_depth = 0;               // of the focal plane, along the optical axis, world units
  std::optional<double> f_number = {};  // of the aperture, where world units are metres
  bool loading = false;                 // photographs of this picture are still being read
  cv::Size drawn_size = {};             // of the light field where it differs from the window's, else empty
  double frame_ms = 0;                  // time of the last frame; 0: none yet
  double picture_ms = 0;                // the light field's part of it
};

std::vector<StatusItem> StatusLine(const ViewerState& state, const ViewerFigures& figures);

}  // namespace ulf::render
