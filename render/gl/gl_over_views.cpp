#include <epoxy/gl.h>

#include <algorithm>
#include <iterator>
#include <numeric>
#include <optional>

#include "core/base/at.h"
#include "core/base/parallel_for.h"
#include "render/fields/field_options.h"
#include "render/fields/lumigraph_field.h"
#include "render/gl/gl_renderer_state.h"
#include "render/renderer/soft_pixel.h"

namespace ulf::render {
namespace {

constexpr unsigned kNearestFirstUnit = 10, kDrawnUnit = 11, kConfidenceUnit = 14, kBeforeUnit = 15;
constexpr unsigned kDepthMapsUnit = 14;  // before the confidence is read

// Returns whether a level of half floats has pixels without light.
bool HasGaps(const cv::Mat& halves) {
  for (int y = 0; y < halves.rows; ++y)
    for (int x = 0; x < halves.cols; ++x)
      if (!(static_cast<float>(halves.at<cv::Vec<cv::float16_t, 4>>(y, x)[3]) > 0)) return true;
  return false;
}

// Returns the listed views, each once, in the order of `in_order`.
std::vector<int> Among(const std::vector<int>& in_order, const std::vector<std::int32_t>& listed,
                       std::size_t view_count) {
  std::vector<bool> is_listed(view_count, false);
  for (const std::int32_t view : listed) is_listed[At(view)] = true;
  std::vector<int> among;
  std::ranges::copy_if(in_order, std::back_inserter(among), [&](int view) { return is_listed[At(view)]; });
  return among;
}

// Sets the constants of LumigraphPenalty() and LumigraphWeights().
void SetPenalties(const GlProgram& program, double resolution) {
  program.Set("resolution_penalty", static_cast<float>(resolution));
  program.Set("zero_penalty", static_cast<float>(kLumigraphZeroPenalty));
  program.Set("above_tie", static_cast<float>(kThresholdAboveTie));
  program.Set("above_largest", static_cast<float>(kThresholdAboveLargest));
}

void DrawTiles(std::size_t count) {
  if (count > 0) glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(6 * count));
}

}  // namespace

// Calls draw(first, end, arrays) for ranges of the views whose photographs are resident and bound at the same
// time, until all views are drawn; once for no views.
void GlRendererState::ForResidentViews(const std::vector<int>& of_views, const DrawSome& draw) {
  std::vector<unsigned> arrays;
  std::size_t done = 0;
  do {
    const std::size_t resident = done + MakeResident(std::span(of_views).subspan(done));
    do {
      const std::size_t end =
          done + views.SetPlaces(std::span(of_views).subspan(done, resident - done), photographs, arrays);
      for (std::size_t n = 0; n < arrays.size(); ++n) glBindTextureUnit(static_cast<GLuint>(n), arrays[n]);
      draw(done, end, std::max(1, static_cast<int>(arrays.size())));
      done = end;
    } while (done < resident);
  } while (done < of_views.size());
}

// Returns whether the views' photographs and shadow maps are resident.
bool GlRendererState::AreResident(const std::vector<int>& of_views) const {
  return (options.show_field || photographs.HasAll(views.LevelRequests(of_views))) &&
         shadow_maps.HasAll(of_views);
}

// Returns the candidates that the shader marks over the bound target, in their order.
std::vector<int> GlRendererState::MarkedViews(const GlProgram& mark, const std::vector<int>& candidates,
                                              const std::function<void()>& draw) {
  needed.Upload(std::vector<std::int32_t>(scene->views.size(), 0));
  needed.BindStorage(3);
  mark.Use();
  no_vertices.Bind();
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  draw();
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  const std::vector<std::int32_t> marks = needed.Read(scene->views.size());
  std::vector<int> marked;
  std::ranges::copy_if(candidates, std::back_inserter(marked),
                       [&](int view) { return marks[At(view)] != 0; });
  return marked;
}

void GlRendererState::SetLumigraph(const GlProgram& program) const {
  SetCommon(program);
  program.Set("depth", 0.0f);
  program.Set("view_count", static_cast<int>(scene->views.size()));
  program.Set("k_best", options.field.lumigraph_k);
  SetPenalties(program, options.field.lumigraph_resolution);
}

void GlRendererState::DrawLumigraphPixels() {
  confidence.Clear(1);
  drawn.Bind();
  no_vertices.Bind();
  std::vector<int> of_views(scene->views.size());
  std::iota(of_views.begin(), of_views.end(), 0);
  // Finding the views that a picture needs takes as long as drawing it. From the second picture on all views
  // are used instead, unless they need shadow maps, which take longer.
  const bool takes_all = std::exchange(drew_lumigraph_pixels, true) && !scene->proxy->Occluder() &&
                         photographs.HasRoomFor(views.LevelRequests(of_views));
  if (!takes_all && !AreResident(of_views)) {
    const std::vector<int> all = of_views;
    SetLumigraph(programs.mark_lumigraph());
    do of_views = MarkedViews(programs.mark_lumigraph(), all, [] { glDrawArrays(GL_TRIANGLES, 0, 3); });
    while (ProvideShadowMaps(of_views));
  }
  ForResidentViews(of_views, [&](std::size_t first, std::size_t /*end*/, int arrays) {
    const GlProgram& program = programs.Lumigraph(arrays);
    SetLumigraph(program);
    program.Set("goes_on", first > 0 ? 1 : 0);
    if (first > 0) {
      glTextureBarrier();
      drawn.BindTexture(kBeforeUnit);
    }
    glDrawArrays(GL_TRIANGLES, 0, 3);
  });
}

void GlRendererState::DrawSoftPixels() {
  drawn.Clear(0);
  confidence.Clear(1);
  drawn.Bind();
  no_vertices.Bind();
  const ViewTiles of_tiles = SoftViewsOfTiles(tiler, *scene, camera, cam_from_world);
  const std::vector<int> of_views =
      Among(ViewsByDistance(*scene, virtual_center), of_tiles.views, scene->views.size());
  if (scene->views.front().depth_map) {
    depth_maps.Provide(of_views);
    views.SetDepthMaps(*scene, depth_maps);
    depth_maps.Bind(kDepthMapsUnit);
    // While photographs are being read, the nearest resident ones fill what is not yet covered.
    constexpr std::size_t kFillers = 6;
    if (!options.complete) ProvideShadowMaps(std::span(of_views).first(std::min(kFillers, of_views.size())));
  } else {
    ProvideShadowMaps(of_views);
  }
  const std::size_t count = SetTiles(of_tiles);
  ForResidentViews(of_views, [&](std::size_t first, std::size_t end, int arrays) {
    const GlProgram& program = programs.Soft(arrays);
    SetCommon(program);
    program.Set("depth", 0.0f);
    program.Set("resolution_penalty", static_cast<float>(FieldOptions{}.lumigraph_resolution));
    program.Set("zero_penalty", static_cast<float>(kLumigraphZeroPenalty));
    program.Set("width_of_fourth", static_cast<float>(options.field.soft_width));
    program.Set("goes_on", first > 0 ? 1 : 0);
    program.Set("in_passes", first > 0 || end < of_views.size() ? 1 : 0);
    if (first > 0) {
      glTextureBarrier();
      drawn.BindTexture(kBeforeUnit);
    }
    DrawTiles(count);
  });
}

// Searches the photographs of these views for pixels without light; returns whether it found new ones.
bool GlRendererState::FindGaps(const std::vector<int>& of_views) {
  std::vector<int> unknown;
  std::ranges::copy_if(of_views, std::back_inserter(unknown),
                       [&](int view) { return !gaps_known[At(view)]; });
  const std::vector<GlPhotographs::LevelRequest> level_requests = views.LevelRequests(unknown);
  std::vector<char> has_gaps(unknown.size(), 0);
  ParallelFor(unknown.size(), [&](std::size_t i) {
    has_gaps[i] = HasGaps(scene->views[At(unknown[i])].photograph->Level(level_requests[i].level));
  });
  bool found = false;
  for (std::size_t i = 0; i < unknown.size(); ++i) {
    gaps_known[At(unknown[i])] = true;
    if (has_gaps[i]) views.SetGaps(unknown[i]);
    found = found || has_gaps[i];
  }
  return found;
}

Filling GlRendererState::filling() const { return FillingOf(options); }

// Returns the number of views that a filled pixel needs: one more than get weight, because its penalty is the
// threshold.
int GlRendererState::FillingViewCount() const { return filling().views > 1 ? filling().views + 1 : 1; }

void GlRendererState::SetFill(const GlProgram& program) const {
  SetCommon(program);
  program.Set("depth", 0.0f);
  program.Set("asked", FillingViewCount());
  SetPenalties(program, FieldOptions{}.lumigraph_resolution);
}

// Returns the views that the fill's shaders examine in each part of the picture.
ViewTiles GlRendererState::TilesFor(const std::vector<int>& in_order, bool marks) {
  // A view ends the search if the proxy hides nothing and photographs have light everywhere.
  const bool sees_all = !scene->proxy->Occluder() && !scene->views.front().photograph->linear();
  return tiler.Tile(
      scene->views, in_order, {camera, cam_from_world, plane, proxy_triangles},
      [&](int view) {
        return sees_all && (marks || options.complete || options.show_field || photographs.PlaceOf(view));
      },
      FillingViewCount());
}

// Uploads the tiles to the shaders; returns their number.
std::size_t GlRendererState::SetTiles(const ViewTiles& of_views) {
  struct GpuTile {
    Vec4 clip;
    std::array<std::int32_t, 4> views;
  };
  std::vector<GpuTile> gpu_tiles;
  for (const ViewTiles::Tile& tile : of_views.tiles) {
    const auto clip = [](int px, int size) { return 2.0 * px / size - 1; };
    gpu_tiles.push_back({MakeVec4(clip(tile.px.x, camera.width), clip(tile.px.y, camera.height),
                                  clip(tile.px.br().x, camera.width), clip(tile.px.br().y, camera.height)),
                         {tile.first, tile.end, 0, 0}});
  }
  tiles.Upload(gpu_tiles);
  tiles.BindStorage(1);
  nearest_first.Upload(of_views.views);
  nearest_first.Bind(kNearestFirstUnit);
  return gpu_tiles.size();
}

// Returns the views that uncovered pixels may need, nearest first. The target must be bound, with its depth
// set.
std::vector<int> GlRendererState::FillingViews() {
  if (filling().views == 0) return {};
  std::vector<int> order = ViewsByDistance(*scene, cam_from_world.OriginInSource());
  const bool looks_for_gaps = options.complete && !options.show_field;
  if (AreResident(order)) {
    if (looks_for_gaps && photographs.array_count() > GlViews::kMostArrays) FindGaps(order);
    return order;
  }
  if (!options.complete && lacks) {  // the field's own views are loaded first
    std::erase_if(order,
                  [&](int view) { return !photographs.PlaceOf(view) || shadow_maps.LayerOf(view) < 0; });
    return order;
  }
  const ViewTiles of_tiles = TilesFor(order, true);
  const std::vector<int> candidates = Among(order, of_tiles.views, scene->views.size());
  if (AreResident(candidates)) return candidates;
  const GlProgram& mark = programs.mark_fill();
  SetFill(mark);
  const std::size_t count = SetTiles(of_tiles);
  const auto draw = [&] { DrawTiles(count); };
  std::vector<int> marked = MarkedViews(mark, order, draw);
  while (ProvideShadowMaps(marked) || (looks_for_gaps && FindGaps(marked))) {
    views.SetShadowMaps(shadow_maps);
    marked = MarkedViews(mark, order, draw);
  }
  return marked;
}

void GlRendererState::SetResolve(const GlProgram& program) const {
  program.Set("least_weight", static_cast<float>(kLeastWeight));
  program.Set("whole_weight", static_cast<float>(filling().whole));
}

// Sets depth 1 where a pixel's own views cover it, so that the depth test skips it when others are filled.
void GlRendererState::Normalise() {
  SetDepthTest(GL_ALWAYS, true);
  confidence.BindTexture(kConfidenceUnit);
  drawn.BindTexture(kDrawnUnit);
  const GlProgram& normalise = programs.normalise();
  normalise.Use();
  SetResolve(normalise);
  normalise.Set("depth", 0.0f);
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

void GlRendererState::FillOpenPixels() {
  const std::vector<int> of_views = FillingViews();
  std::optional<std::size_t> count;
  ForResidentViews(of_views, [&](std::size_t first, std::size_t end, int arrays) {
    if (!count)  // the resident photographs are known only now
      count = SetTiles(TilesFor(of_views, false));
    const GlProgram& program = programs.Fill(arrays);
    SetFill(program);
    program.Set("nearest_is_the_field", options.field.kind == FieldKind::kNearest ? 1 : 0);
    program.Set("waits", options.complete ? 1 : 0);
    SetResolve(program);
    program.Set("goes_on", first > 0 ? 1 : 0);
    program.Set("last", end == of_views.size() ? 1 : 0);
    if (first == 0 && end < of_views.size()) resolved.CopyTo(drawn);  // the passes overwrite it
    (end < of_views.size() || first > 0 ? drawn : resolved).BindTexture(kDrawnUnit);
    resolved.BindTexture(kBeforeUnit);
    glTextureBarrier();
    DrawTiles(*count);
  });
}

// Makes every pixel empty, with depth 0.
void GlRendererState::ClearResolved() {
  resolved.Clear({0, 0, 0, -2});  // alpha of an empty pixel (resolve.glsl)
  resolved.ClearDepth(0);
}

// Returns whether there are uncovered pixels; waits for the drawing.
bool GlRendererState::HasOpenPixels() {
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  programs.open().Use();
  programs.open().Set("depth", 0.0f);
  open_px.Begin();
  glDrawArrays(GL_TRIANGLES, 0, 3);
  open_px.End();
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  return open_px.Count() > 0;
}

void GlRendererState::Resolve() {
  if (!is_resolved) ClearResolved();
  resolved.Bind();
  no_vertices.Bind();
  const bool is_all_open = options.field.kind == FieldKind::kNearest;
  if (!is_resolved && !is_all_open) Normalise();
  SetDepthTest(GL_GREATER, false);
  if (is_all_open || HasOpenPixels()) FillOpenPixels();
  glDepthMask(GL_TRUE);
  glDisable(GL_DEPTH_TEST);
}

}  // namespace ulf::render
