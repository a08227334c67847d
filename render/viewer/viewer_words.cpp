#include "render/viewer/viewer_words.h"

#include <fmt/format.h>

#include "core/base/counted.h"
#include "render/fields/field_options.h"

namespace ulf::render {

std::vector<StatusItem> StatusLine(const ViewerState& state, const ViewerFigures& figures) {
  std::vector<StatusItem> items;
  const bool as_asked = figures.field.kind == state.field.kind;
  items.push_back(
      {FieldText(figures.field) +
           (as_asked ? "" : fmt::format(" ({} is not possible here)", FieldName(state.field.kind))),
       as_asked ? ink::kText : ink::kCareful});
  if (state.aperture > 0) {
    const bool widens = UsesMesh(figures.field.kind);
    items.push_back({fmt::format("aperture {:.3g}{}, focus {:.3g}{}", state.aperture,
                                 figures.f_number ? fmt::format(" (f/{:.2g})", *figures.f_number) : "",
                                 figures.focus_depth, widens ? "" : ": this field has no rings to widen"),
                     widens ? ink::kText : ink::kCareful});
  } else {
    items.push_back({"proxy " + figures.proxy});
  }
  items.push_back({Counted(figures.views, "view")});
  if (state.camera.zoom != 1) items.push_back({fmt::format("zoom {:.2f}", state.camera.zoom)});
  if (state.exposure_stops != 0) items.push_back({fmt::format("{:+.2f} stops", state.exposure_stops)});
  if (figures.loading) items.push_back({"reading photographs", ink::kCareful});
  if (!figures.drawn_size.empty())
    items.push_back(
        {fmt::format("drawn at {}x{} while it moves", figures.drawn_size.width, figures.drawn_size.height)});
  if (figures.frame_ms > 0)
    items.push_back(
        {fmt::format("{:.1f} ms a frame, {:.1f} the light field; {:.{}f} frames/s", figures.frame_ms,
                     figures.picture_ms, 1000 / figures.frame_ms, figures.frame_ms > 100 ? 1 : 0)});
  return items;
}

}  // namespace ulf::render
