#include "render/gl_programs.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "render/embedded_shaders.h"
#include "render/gl_sights.h"

namespace ulf {

void GlPrograms::Build(const RenderScene& scene, bool show_field, bool has_triangles) {
  Release();
  const auto some_view_is = [&](Distortion distortion) {
    return std::any_of(scene.views.begin(), scene.views.end(),
                       [&](const SceneView& view) { return view.camera.distortion == distortion; });
  };
  defines_.clear();
  if (has_triangles) defines_ += "#define TRIANGLES\n";
  if (scene.proxy->Occluder())
    defines_ += fmt::format("#define HIDES\n#define SIGHT_SCALE {:.9e}\n", kSightScale);
  if (show_field) defines_ += "#define SHOW_FIELD\n";
  if (scene.views.front().photograph->linear()) defines_ += "#define GAPS\n";
  if (some_view_is(Distortion::kFisheye)) defines_ += "#define FISHEYE\n";
  if (some_view_is(Distortion::kRadialTangential)) defines_ += "#define RADIAL_TANGENTIAL\n";

  const std::string head = Head(1), view = head + shaders::k_view_glsl;
  const std::string triangle_buffers = view + shaders::k_views_glsl + shaders::k_triangle_buffers_glsl;
  cover_.Build("cover", triangle_buffers + shaders::k_cover_vert, head + shaders::k_cover_frag);
  fan_.Build("fan", triangle_buffers + shaders::k_fan_vert,
             view + shaders::k_common_glsl + shaders::k_fan_frag);
  normalise_.Build("normalise", head + shaders::k_fullscreen_vert, head + shaders::k_normalise_frag);
  const std::string marking =
      head + "#define MARK\n" + shaders::k_view_glsl + shaders::k_common_glsl + shaders::k_views_glsl;
  mark_lumigraph_.Build("mark lumigraph", head + shaders::k_fullscreen_vert,
                        marking + shaders::k_lumigraph_frag);
  mark_fill_.Build("mark fill", head + shaders::k_fill_vert, marking + shaders::k_fill_frag);
}

std::string GlPrograms::Head(int arrays) const {
  return "#version 450 core\n#define ARRAYS " + std::to_string(arrays) + "\n" + defines_;
}

const GlProgram& GlPrograms::RingWeight() {
  if (std::exchange(has_ring_weight_, true)) return ring_weight_;
  const std::string view = Head(1) + shaders::k_view_glsl;
  ring_weight_.Build("ring weight",
                     view + shaders::k_views_glsl + shaders::k_triangle_buffers_glsl + shaders::k_fan_vert,
                     view + shaders::k_common_glsl + shaders::k_ring_weight_frag);
  return ring_weight_;
}

const GlPrograms::OverViews& GlPrograms::Over(int arrays) {
  const auto found = over_views_.find(arrays);
  if (found != over_views_.end()) return found->second;
  OverViews& made = over_views_[arrays];
  const std::string vertices = Head(arrays) + shaders::k_fullscreen_vert;
  const std::string with_views =
      Head(arrays) + shaders::k_view_glsl + shaders::k_common_glsl + shaders::k_views_glsl;
  made.lumigraph.Build("lumigraph", vertices, with_views + shaders::k_lumigraph_frag);
  made.fill.Build("fill", Head(arrays) + shaders::k_fill_vert, with_views + shaders::k_fill_frag);
  return made;
}

void GlPrograms::Release() {
  for (GlProgram* program : {&cover_, &fan_, &ring_weight_, &normalise_, &mark_lumigraph_, &mark_fill_})
    program->Release();
  has_ring_weight_ = false;
  for (auto& [arrays, programs] : over_views_) {
    programs.lumigraph.Release();
    programs.fill.Release();
  }
  over_views_.clear();
}

}  // namespace ulf
