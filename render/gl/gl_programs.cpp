#include "render/gl/gl_programs.h"

#include <epoxy/gl.h>
#include <fmt/format.h>

#include <algorithm>

#include "render/gl/embedded_shaders.h"
#include "render/gl/gl_shadow_maps.h"
#include "render/renderer/soft_pixel.h"

namespace ulf::render {
namespace {

// In a triangle that was subdivided once, one more view has weight than a vertex has edges; this suffices for
// eight.
constexpr int kMostViewsOfFanBatch = 9;

int MostVaryingVectors() {
  GLint most = 15;  // the minimum of OpenGL 4.5
  glGetIntegerv(GL_MAX_VARYING_VECTORS, &most);
  return most;
}

std::string OfViews(int views) { return "#define VIEWS " + std::to_string(views) + "\n"; }

// Defines the constants of the soft field.
std::string SoftDefines() {
  const SoftConstants constants;
  std::string defines;
  const auto define = [&](const char* name, double value) {
    defines += fmt::format("#define {} {:.9e}\n", name, value);
  };
  const auto define_count = [&](const char* name, int value) {
    defines += fmt::format("#define {} {}\n", name, value);
  };
  define_count("SOFT_VIEWS", kSoftViews);
  define_count("SOFT_PROPOSERS", kSoftProposers);
  define_count("SEARCH_STEPS", constants.search_steps);
  define_count("ROBUST_STEPS", constants.robust_steps);
  define("LEAST_WEIGHT", constants.least_weight);
  define("MOST_TAKEN", constants.most_taken);
  define("OWN_SHARE", constants.own_share);
  define("SEARCH_END", constants.search_end);
  define("MERGED", constants.merged);
  define("VOTE", constants.vote);
  define("OCCLUDED", constants.occluded);
  define("LEAST_SEEN", constants.least_seen);
  define("BALANCED", constants.balanced);
  define("AGREEING", constants.agreeing);
  define("ROBUST", constants.robust);
  return defines;
}

}  // namespace

void GlPrograms::Build(const RenderScene& scene, bool show_field, bool has_triangles) {
  Release();
  const auto some_view_is = [&](Distortion distortion) {
    return std::ranges::any_of(scene.views,
                               [&](const SceneView& view) { return view.camera.distortion == distortion; });
  };
  defines_.clear();
  if (has_triangles) defines_ += "#define TRIANGLES\n";
  if (scene.proxy->Occluder())
    defines_ += fmt::format("#define HIDES\n#define SHADOW_MAP_SCALE {:.9e}\n", kShadowMapScale);
  if (scene.views.front().depth_map) defines_ += "#define MAPS\n";
  if (show_field) defines_ += "#define SHOW_FIELD\n";
  if (scene.views.front().photograph->linear()) defines_ += "#define GAPS\n";
  if (some_view_is(Distortion::kFisheye)) defines_ += "#define FISHEYE\n";
  if (some_view_is(Distortion::kRadialTangential)) defines_ += "#define RADIAL_TANGENTIAL\n";
  const auto is_as_the_first = [&](auto&& same) {
    return std::ranges::all_of(scene.views,
                               [&](const SceneView& view) { return same(view, scene.views.front()); });
  };
  one_camera_ = is_as_the_first([](const SceneView& a, const SceneView& b) { return a.camera == b.camera; });
  const bool corrected = std::ranges::any_of(
      scene.views, [](const SceneView& view) { return view.correction != LightCorrection{}; });
  const bool one_exposure =
      one_camera_ && !corrected && is_as_the_first([](const SceneView& a, const SceneView& b) {
        return a.black == b.black && a.scale == b.scale;
      });
  if (one_camera_) defines_ += "#define ONE_CAMERA\n";
  if (one_exposure) defines_ += "#define ONE_EXPOSURE\n";
  if (corrected) defines_ += "#define CORRECTED\n";
  // Counts vectors that the vertex shader passes to the fragments: `vectors` for each view, one for each four
  // views, and one for all.
  int vectors = 3;
  if (!one_camera_) vectors += 5;
  if (!one_exposure) ++vectors;
  if (corrected) ++vectors;
  if (show_field) ++vectors;
  int& most = most_views_of_fan_batch_ = kMostViewsOfFanBatch;
  while (most > 1 && most * vectors + (most + 3) / 4 + 1 > MostVaryingVectors()) --most;

  const std::string head = Head(1), view = head + shaders::k_view_glsl;
  const std::string triangle_buffers = view + shaders::k_views_glsl + shaders::k_triangle_buffers_glsl;
  cover_.Build("cover", triangle_buffers + shaders::k_cover_vert, head + shaders::k_cover_frag);
  open_.Build("open", head + shaders::k_fullscreen_vert, head + shaders::k_open_frag);
  normalise_.Build("normalise", head + shaders::k_fullscreen_vert,
                   head + shaders::k_resolve_glsl + shaders::k_normalise_frag);
  const std::string marking =
      head + "#define MARK\n" + shaders::k_view_glsl + shaders::k_common_glsl + shaders::k_views_glsl;
  mark_lumigraph_.Build("mark lumigraph", head + shaders::k_fullscreen_vert,
                        marking + shaders::k_lumigraph_frag);
  mark_fill_.Build("mark fill", head + shaders::k_fill_vert,
                   marking + shaders::k_resolve_glsl + shaders::k_fill_frag);
}

std::string GlPrograms::Head(int arrays) const {
  return "#version 450 core\n#define ARRAYS " + std::to_string(arrays) + "\n" + defines_;
}

const GlProgram& GlPrograms::FanBatch(int views, bool direct) {
  const auto [found, is_new] = batches_.try_emplace({views, direct});
  if (is_new)
    found->second.Build("batch", FanBatchVertices(views),
                        Head(1) + OfViews(views) + (direct ? "#define DIRECT\n" : "") + shaders::k_view_glsl +
                            shaders::k_common_glsl + shaders::k_resolve_glsl + shaders::k_fan_batch_frag);
  return found->second;
}

const GlProgram& GlPrograms::RingWeight() {
  if (!std::exchange(has_ring_weight_, true))
    ring_weight_.Build("ring weight", FanBatchVertices(1),
                       Head(1) + OfViews(1) + shaders::k_ring_weight_frag);
  return ring_weight_;
}

std::string GlPrograms::FanBatchVertices(int views) const {
  return Head(1) + OfViews(views) + shaders::k_view_glsl + shaders::k_views_glsl +
         shaders::k_triangle_buffers_glsl + shaders::k_fan_batch_vert;
}

const GlPrograms::OverViews& GlPrograms::Over(int arrays) {
  const auto found = over_views_.find(arrays);
  if (found != over_views_.end()) return found->second;
  OverViews& made = over_views_[arrays];
  const std::string vertices = Head(arrays) + shaders::k_fullscreen_vert;
  const std::string with_views =
      Head(arrays) + shaders::k_view_glsl + shaders::k_common_glsl + shaders::k_views_glsl;
  made.lumigraph.Build("lumigraph", vertices, with_views + shaders::k_lumigraph_frag);
  made.fill.Build("fill", Head(arrays) + shaders::k_fill_vert,
                  with_views + shaders::k_resolve_glsl + shaders::k_fill_frag);
  return made;
}

const GlProgram& GlPrograms::Soft(int arrays) {
  const auto [found, is_new] = soft_.try_emplace(arrays);
  if (is_new)
    found->second.Build("soft", Head(arrays) + shaders::k_fill_vert,
                        Head(arrays) + SoftDefines() + shaders::k_view_glsl + shaders::k_common_glsl +
                            shaders::k_views_glsl + shaders::k_soft_frag);
  return found->second;
}

void GlPrograms::Release() {
  for (GlProgram* program : {&cover_, &open_, &ring_weight_, &normalise_, &mark_lumigraph_, &mark_fill_})
    program->Release();
  has_ring_weight_ = false;
  for (auto& [arrays, programs] : over_views_) {
    programs.lumigraph.Release();
    programs.fill.Release();
  }
  over_views_.clear();
  for (auto& [arrays, program] : soft_) program.Release();
  soft_.clear();
  for (auto& [kind, program] : batches_) program.Release();
  batches_.clear();
}

}  // namespace ulf::render
