#include "render/gl/gl_renderer.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <utility>

#include "core/base/at.h"
#include "core/base/error.h"
#include "render/fields/lumigraph_field.h"
#include "render/gl/embedded_shaders.h"
#include "render/gl/gl_renderer_state.h"
#include "render/renderer/cut_out_renderer.h"
#include "render/renderer/reference_renderer.h"

namespace ulf::render {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr unsigned kProxyDepthUnit = 12, kShadowMapsUnit = 13;  // photographs use the units before
constexpr unsigned kShownMasksUnit = 14, kShownUnit = 15;       // of Show()

void GlRendererState::SetCommon(const GlProgram& program) const {
  program.Use();
  program.Set("camera", MakeVec4(camera.fx, camera.fy, camera.cx, camera.cy));
  program.Set("plane", MakeVec4(plane.normal.x(), plane.normal.y(), plane.normal.z(), plane.offset));
  program.Set("far_depth", static_cast<float>(plane.far_depth));
  if (programs.one_camera()) views.SetOneCamera(program);
}

void GlRendererState::Build() {
  std::vector<std::shared_ptr<const Photograph>> of_views;
  for (const SceneView& view : scene->views) of_views.push_back(view.photograph);
  photographs.Build(std::move(of_views), GlPhotographs::LimitBytes(options.gpu_memory_mb));
  views.Build(*scene);
  gaps_known.assign(scene->views.size(), !scene->views.front().photograph->linear());
  proxy.Build();
  const std::string version = "#version 450 core\n";
  show.Build("show", version + shaders::k_fullscreen_vert, version + shaders::k_show_frag);
}

// Returns whether there are new maps.
bool GlRendererState::ProvideShadowMaps(std::span<const int> of_views) {
  if (!shadow_maps.Provide(of_views)) return false;
  views.SetShadowMaps(shadow_maps);
  shadow_maps.Bind(kShadowMapsUnit);
  return true;
}

cv::Mat GlRendererState::Depth() const {
  cv::Mat depth = has_triangles ? proxy.ReadDepth() : cv::Mat::zeros(camera.height, camera.width, CV_32F);
  FillWithPlane(plane, camera, depth);
  return depth;
}

GlRenderer::GlRenderer(std::shared_ptr<const RenderScene> scene, const RenderOptions& options,
                       GlContextKind kind)
    : state_(std::make_unique<GlRendererState>(std::move(scene), options, kind)) {
  const GlContext::Current current(state_->context);
  state_->Build();
  state_->shadow_maps.Reset(state_->scene->views);
  state_->depth_maps.Reset(state_->scene->views);
  state_->programs.Build(*state_->scene, options.show_field, false);
  SetField(options.field);
}

GlRenderer::~GlRenderer() {
  if (!state_) return;
  const GlContext::Current current(state_->context);
  GlRendererState& s = *state_;
  s.programs.Release();
  s.show.Release();
  s.photographs.Release();
  s.views.Release();
  for (GlBuffer* buffer : {&s.triangles, &s.fans, &s.batches, &s.tiles, &s.needed}) buffer->Release();
  s.nearest_first.Release();
  s.open_px.Release();
  for (GlTarget* target : {&s.drawn, &s.confidence, &s.resolved, &s.shown}) target->Release();
  s.no_vertices.Release();
  s.depth.Release();
  s.proxy.Release();
  s.shadow_maps.Release();
  s.depth_maps.Release();
}

void GlRenderer::SetField(const FieldOptions& field) {
  GlRendererState& s = *state_;
  s.options.field = FieldThatServes(field, s.scene->mesh);
  s.options.field.lumigraph_k = std::clamp(s.options.field.lumigraph_k, 1, kMostLumigraphViews);
  const GlContext::Current current(s.context);
  s.MakeMeshField();
}

void GlRendererState::MakeMeshField() {
  mesh_field.reset();
  aperture_field.reset();
  if (!UsesMesh(options.field.kind)) return;
  mesh_field = std::make_shared<MeshField>(plain, options.field.level, options.field.rules);
  if (options.aperture) aperture_field = std::make_unique<ApertureField>(mesh_field);
  const FieldMesh& mesh = mesh_field->field_mesh();
  mesh_entries = MakeEntries(mesh.triangles, [&](int vertex, auto&& add) {
    for (const auto& [of_vertex, weight] : mesh.weights[At(vertex)]) add(of_vertex, weight);
  });
}

void GlRenderer::SetProxy(std::shared_ptr<const Proxy> proxy) {
  GlRendererState& s = *state_;
  const GlContext::Current current(s.context);
  s.plain = WithProxy(*s.plain, std::move(proxy));
  s.scene = s.options.aperture ? WithFocalPlane(*s.plain, *s.options.aperture) : s.plain;
  s.shadow_maps.Reset(s.scene->views);
  s.depth_maps.Reset(s.scene->views);
  s.programs_stale = true;
  SetField(s.options.field);
}

void GlRenderer::SetAperture(const std::optional<Aperture>& aperture) {
  GlRendererState& s = *state_;
  if (aperture == s.options.aperture) return;
  const GlContext::Current current(s.context);
  const bool begins_or_ends = aperture.has_value() != s.options.aperture.has_value();
  if (begins_or_ends) s.programs_stale = true;
  s.options.aperture = aperture;
  s.scene = aperture ? WithFocalPlane(*s.plain, *aperture) : s.plain;
  s.shadow_maps.Reset(s.scene->views);
  s.depth_maps.Reset(s.scene->views);
  if (begins_or_ends && s.options.field.level > kFinestLevel) return s.MakeMeshField();
  if (!aperture) s.aperture_field.reset();
  if (aperture && s.mesh_field && !s.aperture_field)
    s.aperture_field = std::make_unique<ApertureField>(s.mesh_field);
}

void GlRenderer::Prefetch(const CameraModel& camera, const Rigid3& cam_from_world) {
  GlRendererState& s = *state_;
  const Vector3d virtual_center = cam_from_world.OriginInSource();
  std::vector<int> of_views;
  if (s.mesh_field) {
    const PlacedMesh placed = s.mesh_field->Place(virtual_center);
    TriangleBatch rings = s.RingTriangles(placed, camera, cam_from_world);
    TriangleBatch batch = rings.fans.empty() ? s.MeshTriangles(placed, camera, cam_from_world) : rings;
    of_views = ViewsOf(batch.fans);
  } else {
    constexpr std::size_t kNearest = 12;  // that a lumigraph picture mostly needs. Guessed.
    of_views = ViewsByDistance(*s.scene, virtual_center);
    of_views.resize(std::min(of_views.size(), kNearest));
  }
  std::vector<GlPhotographs::LevelRequest> level_requests;
  for (const int view : of_views)
    level_requests.push_back(
        {view, PyramidLevel(s.scene->views[At(view)], *s.scene, virtual_center, camera.MeanFocalPx())});
  s.photographs.Expect(std::move(level_requests));
}

bool GlRenderer::loading() const { return state_->lacks || state_->outdated; }
GlPhotographs::Counts GlRenderer::photograph_counts() const { return state_->photographs.counts(); }
bool GlRenderer::drew_at_once() const { return state_->is_resolved; }

void GlRenderer::ShowField(bool show) {
  if (show == state_->options.show_field) return;
  state_->options.show_field = show;
  state_->programs_stale = true;
}

FieldOptions GlRenderer::field() const { return state_->options.field; }
std::string GlRenderer::Name() const { return "gl (" + state_->context.device() + ")"; }
const RenderScene& GlRenderer::scene() const { return *state_->plain; }

double GlRenderer::Draw(const CameraModel& camera, const Rigid3& cam_from_world) {
  RequireUndistorted(camera);
  GlRendererState& s = *state_;
  const GlContext::Current current(s.context);
  const auto start = std::chrono::steady_clock::now();
  s.camera = camera;
  s.cam_from_world = cam_from_world;
  s.plane = s.scene->proxy->Background(cam_from_world);
  const auto triangles = s.scene->proxy->Triangles(camera, cam_from_world);
  if (std::exchange(s.programs_stale, false) || (triangles != nullptr) != s.has_triangles) {
    s.has_triangles = triangles != nullptr;
    s.programs.Build(*s.scene, s.options.show_field, s.has_triangles);
  }
  s.proxy_triangles = triangles;
  if (triangles) {
    s.proxy.Draw(triangles, camera, cam_from_world, s.plane.offset);
    s.proxy.BindDepth(kProxyDepthUnit);
  }
  try {
    s.depth.Resize(camera.width, camera.height);
    s.drawn.Resize(camera.width, camera.height, &s.depth);
    s.confidence.Resize(camera.width, camera.height, &s.depth);
    s.resolved.Resize(camera.width, camera.height, &s.depth);
  } catch (const Error&) {  // the other depths must not remain when one is missing
    s.depth.Release();
    for (GlTarget* target : {&s.drawn, &s.confidence, &s.resolved}) target->Release();
    throw;
  }
  s.views.Place(*s.scene, camera, cam_from_world);
  s.views.SetShadowMaps(s.shadow_maps);
  s.shadow_maps.Bind(kShadowMapsUnit);
  s.virtual_center = cam_from_world.OriginInSource();
  s.offered.clear();
  s.lacks = s.outdated = s.is_resolved = false;
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_CULL_FACE);
  glDisable(GL_BLEND);
  switch (s.options.field.kind) {
    case FieldKind::kLinear:
    case FieldKind::kSubdivision:
      s.DrawMesh();
      break;
    case FieldKind::kLumigraph:
      s.DrawBatch(s.LumigraphTriangles(), false);
      break;
    case FieldKind::kLumigraphPerPixel:
      s.DrawLumigraphPixels();
      break;
    case FieldKind::kSoft:
      s.DrawSoftPixels();
      break;
    case FieldKind::kNearest:
      break;  // Resolve() draws the nearest view
  }
  s.Resolve();
  if (!s.options.complete) s.photographs.RequestMissing();
  glFinish();
  CheckGl("drawing");
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

void GlRenderer::Show(const DisplayTransform& transform) const {
  GlRendererState& s = *state_;
  std::array<GLint, 4> viewport{};
  glGetIntegerv(GL_VIEWPORT, viewport.data());
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_BLEND);
  s.show.Use();
  s.show.Set("size", MakeVec4(s.camera.width, s.camera.height, viewport[2], viewport[3]));
  s.show.Set("brighter", static_cast<float>(std::exp2(transform.exposure_stops)));
  s.show.Set("hatches_doubt", transform.hatches_doubt ? 1 : 0);
  s.show.Set("depth", 0.0f);
  s.show.Set("is_cut_out", transform.of_masks ? 1 : 0);
  s.show.Set("shares", MakeVec4(kOutsideShare, kInsideShare, 0, 0));
  s.resolved.BindTexture(kShownUnit);
  if (transform.of_masks) transform.of_masks->state_->resolved.BindTexture(kShownMasksUnit);
  s.no_vertices.Bind();
  const cv::Size drawn(s.camera.width, s.camera.height);
  if (drawn == cv::Size(viewport[2], viewport[3])) {
    glDrawArrays(GL_TRIANGLES, 0, 3);
  } else {  // converts the drawn pixels, which are fewer, and stretches them over the screen
    GLint screen = 0;
    glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &screen);
    s.shown.Resize(drawn.width, drawn.height);
    s.shown.Bind();
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, static_cast<GLuint>(screen));
    glBlitFramebuffer(0, 0, drawn.width, drawn.height, viewport[0], viewport[1], viewport[0] + viewport[2],
                      viewport[1] + viewport[3], GL_COLOR_BUFFER_BIT, GL_LINEAR);
    glBindFramebuffer(GL_FRAMEBUFFER, static_cast<GLuint>(screen));
    glViewport(viewport[0], viewport[1], viewport[2], viewport[3]);
  }
  CheckGl("showing the picture");
}

Rendering GlRenderer::Render(const CameraModel& camera, const Rigid3& cam_from_world) {
  const GlContext::Current current(state_->context);
  Rendering picture;
  picture.ms = Draw(camera, cam_from_world);
  const cv::Mat bgra = state_->resolved.Read();
  picture.linear.create(bgra.size(), CV_32FC3);
  picture.confidence.create(bgra.size(), CV_32F);
  picture.drawn.create(bgra.size(), CV_8U);
  for (int y = 0; y < bgra.rows; ++y)
    for (int x = 0; x < bgra.cols; ++x) {
      const cv::Vec4f& p = bgra.at<cv::Vec4f>(y, x);
      picture.linear.at<cv::Vec3f>(y, x) = {p[0], p[1], p[2]};
      picture.confidence.at<float>(y, x) = std::max(0.0f, p[3]);
      picture.drawn.at<std::uint8_t>(y, x) = p[3] == -2.0f ? 0 : 255;
      picture.filled_px += p[3] == -1.0f;
      picture.empty_px += p[3] == -2.0f;
    }
  const RenderOptions& options = state_->options;
  if (!options.depth && !options.weights) return picture;
  const cv::Mat depth = state_->Depth();
  if (options.depth) picture.depth = depth;
  if (options.weights)
    picture.weights =
        WeightsOfViews(*state_->scene, state_->FieldFrom().get(), camera, cam_from_world, depth, options);
  return picture;
}

std::unique_ptr<Renderer> MakeRenderer(std::shared_ptr<const RenderScene> scene,
                                       const RenderOptions& options) {
  if (scene->views.empty()) throw Error("there are no views to render from; leave fewer of them out");
  if (options.renderer == RendererKind::kReference)
    return std::make_unique<ReferenceRenderer>(std::move(scene), options);
  return std::make_unique<GlRenderer>(std::move(scene), options);
}

}  // namespace ulf::render
