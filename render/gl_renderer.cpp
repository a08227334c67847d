#include "render/gl_renderer.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <optional>

#include "acquisition/error.h"
#include "render/at.h"
#include "render/embedded_shaders.h"
#include "render/gl_context.h"
#include "render/gl_objects.h"
#include "render/gl_proxy.h"
#include "render/gl_triangles.h"
#include "render/image_triangulation.h"
#include "render/lumigraph_field.h"
#include "render/mesh_field.h"
#include "render/reference_renderer.h"

namespace ulf {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// As the shaders know it (std430).
struct GpuView {
  Vec4 row0, row1, row2, intrinsics, size, k, more, color, center, sight;
  std::array<std::int32_t, 4> place;
};
constexpr int kMostLumigraphViews = 8;
constexpr unsigned kProxyDepthUnit = 12, kSightsUnit = 13;  // photographs come before

// How far out a distortion polynomial still grows: r squared, or the fisheye's angle.
// (CameraModel::ImgFromCam refuses points beyond.)
double TrustedExtent(const CameraModel& camera) {
  const auto& c = camera.coefficients;
  const bool fisheye = camera.distortion == Distortion::kFisheye;
  const auto slope = [&](double s) {
    if (!fisheye) return 1 + s * (3 * c[0] + s * (5 * c[1] + s * 7 * c[4]));
    const double t2 = s * s;
    return 1 + t2 * (3 * c[0] + t2 * (5 * c[1] + t2 * (7 * c[2] + t2 * 9 * c[3])));
  };
  const double most = fisheye ? M_PI : 100.0;
  constexpr int kSteps = 10000;
  for (int i = 1; i <= kSteps; ++i)
    if (slope(most * i / kSteps) <= 0) return most * (i - 1) / kSteps;
  return fisheye ? M_PI : 1e30;
}

}  // namespace

struct GlRenderer::State {
  std::shared_ptr<const RenderScene> scene;
  RenderOptions options;
  GlContext context;

  PhotographTextures photographs;
  GlProxy proxy;
  GlProgram cover, fan, lumigraph, normalise, fill;
  GlBuffer views, centers, triangles, fans, view_of_vertex, nearest_first;
  GlEmptyVertexArray no_vertices;
  GlDepth depth;
  GlTarget drawn{GL_RGBA32F}, confidence{GL_R32F}, resolved{GL_RGBA32F};
  std::vector<double> trusted_extent;
  bool has_triangles = false;  // of the proxy

  std::unique_ptr<MeshField> mesh_field;
  EntryTable mesh_entries;

  State(std::shared_ptr<const RenderScene> the_scene, const RenderOptions& the_options)
      : scene(std::move(the_scene)), options(the_options) {}

  void Build();
  void BuildPrograms();
  void UploadViews(const CameraModel& camera, const Rigid3& cam_from_world);
  void SetCommon(const GlProgram& program, const CameraModel& camera, const PlaneInCamera& plane) const;
  void DrawMesh(const CameraModel& camera, const Rigid3& cam_from_world, const PlaneInCamera& plane);
  void DrawLumigraphTriangles(const CameraModel& camera, const Rigid3& cam_from_world,
                              const PlaneInCamera& plane);
  void DrawLumigraphPixels(const CameraModel& camera, const PlaneInCamera& plane);
  void DrawBatch(const TriangleBatch& batch, const CameraModel& camera, const PlaneInCamera& plane);
  void Resolve(const CameraModel& camera, const Rigid3& cam_from_world, const PlaneInCamera& plane);
  cv::Mat Depth(const CameraModel& camera, const Rigid3& cam_from_world) const;  // of the last frame
};

void GlRenderer::State::Build() {
  std::vector<const ViewPyramid*> pyramids;
  for (const SceneView& view : scene->views) {
    pyramids.push_back(&view.pyramid);
    trusted_extent.push_back(TrustedExtent(view.camera));
  }
  photographs.Upload(pyramids);
  proxy.Build();
}

// For the photographs and the proxy that there are: what they do not need is left out.
void GlRenderer::State::BuildPrograms() {
  for (GlProgram* program : {&cover, &fan, &lumigraph, &normalise, &fill}) program->Release();
  std::string head = "#version 450 core\n#define ARRAYS " + std::to_string(photographs.ArrayCount()) + "\n";
  const auto some_view_is = [&](Distortion distortion) {
    return std::any_of(scene->views.begin(), scene->views.end(),
                       [&](const SceneView& view) { return view.camera.distortion == distortion; });
  };
  if (has_triangles) head += "#define TRIANGLES\n";
  if (scene->proxy->Occluder()) head += "#define HIDES\n";
  if (options.show_field) head += "#define SHOW_FIELD\n";
  if (std::any_of(scene->views.begin(), scene->views.end(),
                  [](const SceneView& each) { return each.has_gaps; }))
    head += "#define GAPS\n";
  if (some_view_is(Distortion::kFisheye)) head += "#define FISHEYE\n";
  if (some_view_is(Distortion::kRadialTangential)) head += "#define RADIAL_TANGENTIAL\n";
  const std::string view = head + shaders::k_view_glsl;
  const std::string triangle_buffers = view + shaders::k_views_glsl + shaders::k_triangle_buffers_glsl;
  const std::string common = view + shaders::k_common_glsl;
  const std::string with_views = common + shaders::k_views_glsl;
  cover.Build("cover", triangle_buffers + shaders::k_cover_vert, head + shaders::k_cover_frag);
  fan.Build("fan", triangle_buffers + shaders::k_fan_vert, common + shaders::k_fan_frag);
  lumigraph.Build("lumigraph", head + shaders::k_fullscreen_vert, with_views + shaders::k_lumigraph_frag);
  normalise.Build("normalise", head + shaders::k_fullscreen_vert, head + shaders::k_normalise_frag);
  fill.Build("fill", head + shaders::k_fullscreen_vert, with_views + shaders::k_fill_frag);
}

void GlRenderer::State::UploadViews(const CameraModel& camera, const Rigid3& cam_from_world) {
  const Rigid3 world_from_cam = cam_from_world.Inverse();
  const Vector3d virtual_center = cam_from_world.OriginInSource();
  std::vector<GpuView> gpu_views;
  std::vector<Vec4> gpu_centers;
  gpu_views.reserve(scene->views.size());
  for (std::size_t i = 0; i < scene->views.size(); ++i) {
    const SceneView& view = scene->views[i];
    const Rigid3 view_from_cam = view.cam_from_world * world_from_cam;
    const Matrix3d r = view_from_cam.RotationMatrix();
    const Vector3d& t = view_from_cam.translation;
    const auto& c = view.camera.coefficients;
    const bool fisheye = view.camera.distortion == Distortion::kFisheye;
    const double kind = view.camera.distortion == Distortion::kNone ? 0 : fisheye ? 2 : 1;
    const cv::Vec3f bgr = ViewColor(view.id);
    const Vector3d center = cam_from_world * view.center_in_world;
    const auto [array, layer] = photographs.PlaceOf(i);
    GpuView& out = gpu_views.emplace_back();
    out.row0 = MakeVec4(r(0, 0), r(0, 1), r(0, 2), t.x());
    out.row1 = MakeVec4(r(1, 0), r(1, 1), r(1, 2), t.y());
    out.row2 = MakeVec4(r(2, 0), r(2, 1), r(2, 2), t.z());
    out.intrinsics = MakeVec4(view.camera.fx, view.camera.fy, view.camera.cx, view.camera.cy);
    out.size = MakeVec4(view.camera.width, view.camera.height,
                        kFeatherShare * std::min(view.camera.width, view.camera.height), trusted_extent[i]);
    out.k = MakeVec4(c[0], c[1], c[2], c[3]);
    out.more = MakeVec4(c[4], view.black, view.scale, kind);
    out.color = MakeVec4(bgr[2], bgr[1], bgr[0], 1);
    out.center = MakeVec4(center.x(), center.y(), center.z(), 1);
    if (view.sight) {
      const CameraModel& map = view.sight->camera;
      out.sight = MakeVec4(map.fx / map.width, map.fy / map.height, map.cx / map.width, map.cy / map.height);
    }
    out.place = {array, layer, PyramidLevel(view, scene->subject, virtual_center, camera.MeanFocalPx()),
                 static_cast<std::int32_t>(i)};
  }
  for (const GpuView& view : gpu_views) gpu_centers.push_back(view.center);
  views.Upload(gpu_views);
  views.BindStorage(0);
  centers.Upload(gpu_centers);
  centers.BindStorage(5);
}

void GlRenderer::State::SetCommon(const GlProgram& program, const CameraModel& camera,
                                  const PlaneInCamera& plane) const {
  program.Use();
  program.Set("camera", MakeVec4(camera.fx, camera.fy, camera.cx, camera.cy));
  program.Set("plane", MakeVec4(plane.normal.x(), plane.normal.y(), plane.normal.z(), plane.offset));
  program.Set("far_depth", static_cast<float>(plane.far_depth));
}

void GlRenderer::State::DrawBatch(const TriangleBatch& batch, const CameraModel& camera,
                                  const PlaneInCamera& plane) {
  if (batch.triangles.empty()) return;
  triangles.Upload(batch.triangles);
  triangles.BindStorage(1);
  fans.Upload(batch.fans);
  fans.BindStorage(2);
  view_of_vertex.BindStorage(3);
  no_vertices.Bind();

  glEnable(GL_DEPTH_TEST);
  glDepthMask(GL_TRUE);
  glDepthFunc(GL_ALWAYS);
  confidence.Bind();
  cover.Use();
  glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(3 * batch.triangles.size()));

  glDepthMask(GL_FALSE);
  glDepthFunc(GL_EQUAL);
  glEnable(GL_BLEND);
  glBlendFunc(GL_ONE, GL_ONE);
  drawn.Bind();
  SetCommon(fan, camera, plane);
  glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(3 * batch.fans.size()));
  glDisable(GL_BLEND);
  glDisable(GL_DEPTH_TEST);
}

void GlRenderer::State::DrawMesh(const CameraModel& camera, const Rigid3& cam_from_world,
                                 const PlaneInCamera& plane) {
  const PlacedMesh placed = mesh_field->Place(cam_from_world.OriginInSource());
  const FieldMesh& mesh = mesh_field->field_mesh();
  const Matrix3d cam_from_world_r = cam_from_world.RotationMatrix();
  const double count = static_cast<double>(mesh.triangles.size());
  TriangleBatch batch;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (placed.cone_from_ray[t].isZero(0)) continue;
    AddTriangle(cam_from_world_r * placed.corners[t], placed.cone_from_ray[t] * cam_from_world_r.transpose(),
                camera, mesh.confidence[t], static_cast<double>(t) / count, mesh_entries, t, batch);
  }
  view_of_vertex.Upload(placed.view_of_vertex);
  DrawBatch(batch, camera, plane);
}

void GlRenderer::State::DrawLumigraphTriangles(const CameraModel& camera, const Rigid3& cam_from_world,
                                               const PlaneInCamera& plane) {
  const cv::Mat drawn_depth = has_triangles ? proxy.ReadDepth() : cv::Mat();
  const auto depth_at = [&](const Eigen::Vector2d& img) -> double {
    if (has_triangles) {
      const float depth =
          drawn_depth.at<float>(std::clamp(static_cast<int>(img.y()), 0, drawn_depth.rows - 1),
                                std::clamp(static_cast<int>(img.x()), 0, drawn_depth.cols - 1));
      if (depth > 0) return depth;
    }
    return plane.DepthOf({(img.x() - camera.cx) / camera.fx, (img.y() - camera.cy) / camera.fy, 1.0});
  };
  const auto image =
      TriangulateLumigraph(*scene, camera, cam_from_world, depth_at, options.field.lumigraph_k);
  const EntryTable table = MakeEntries(image.triangles, [&](int vertex, auto&& add) {
    for (const ViewWeight& entry : image.weights[At(vertex)]) add(entry.view, entry.weight);
  });
  const double count = static_cast<double>(image.triangles.size());
  TriangleBatch batch;
  for (std::size_t t = 0; t < image.triangles.size(); ++t) {
    // Rays with unit z as corners: what the shader normalises is then linear in the image.
    Matrix3d corners;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector2d& img = image.img[At(image.triangles[t][At(k)])];
      corners.col(k) = Vector3d((img.x() - camera.cx) / camera.fx, (img.y() - camera.cy) / camera.fy, 1.0);
    }
    AddTriangle(corners, corners.inverse(), camera, 1.0, static_cast<double>(t) / count, table, t, batch);
  }
  std::vector<std::int32_t> identity(scene->views.size());
  for (std::size_t i = 0; i < identity.size(); ++i) identity[i] = static_cast<std::int32_t>(i);
  view_of_vertex.Upload(identity);
  DrawBatch(batch, camera, plane);
}

void GlRenderer::State::DrawLumigraphPixels(const CameraModel& camera, const PlaneInCamera& plane) {
  SetCommon(lumigraph, camera, plane);
  confidence.Clear(1);
  drawn.Bind();
  no_vertices.Bind();
  lumigraph.Set("depth", 0.0f);
  lumigraph.Set("view_count", static_cast<int>(scene->views.size()));
  lumigraph.Set("k_best", options.field.lumigraph_k);
  lumigraph.Set("resolution_penalty", static_cast<float>(kResolutionPenalty));
  lumigraph.Set("zero_penalty", static_cast<float>(kLumigraphZeroPenalty));
  lumigraph.Set("above_tie", static_cast<float>(kThresholdAboveTie));
  lumigraph.Set("above_largest", static_cast<float>(kThresholdAboveLargest));
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

// Covered pixels get depth 1, so that filling does not even start on them.
void GlRenderer::State::Resolve(const CameraModel& camera, const Rigid3& cam_from_world,
                                const PlaneInCamera& plane) {
  const bool nearest_is_the_field = options.field.kind == FieldKind::kNearest;
  resolved.Bind();
  resolved.ClearDepth(0);
  no_vertices.Bind();
  glEnable(GL_DEPTH_TEST);
  glDepthMask(GL_TRUE);
  if (!nearest_is_the_field) {
    glDepthFunc(GL_ALWAYS);
    confidence.BindTexture(14);
    drawn.BindTexture(15);
    normalise.Use();
    normalise.Set("least_weight", static_cast<float>(kLeastWeight));
    normalise.Set("depth", 1.0f);
    glDrawArrays(GL_TRIANGLES, 0, 3);
  }
  glDepthMask(GL_FALSE);
  glDepthFunc(GL_GREATER);
  SetCommon(fill, camera, plane);
  fill.Set("depth", 0.0f);
  fill.Set("view_count", options.fill || nearest_is_the_field ? static_cast<int>(scene->views.size()) : 0);
  fill.Set("nearest_is_the_field", nearest_is_the_field ? 1 : 0);
  nearest_first.Upload(ViewsByDistance(*scene, cam_from_world.OriginInSource()));
  nearest_first.BindStorage(4);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glDepthMask(GL_TRUE);
  glDisable(GL_DEPTH_TEST);
}

cv::Mat GlRenderer::State::Depth(const CameraModel& camera, const Rigid3& cam_from_world) const {
  cv::Mat depth = has_triangles ? proxy.ReadDepth() : cv::Mat::zeros(camera.height, camera.width, CV_32F);
  FillWithPlane(scene->proxy->Background(cam_from_world), camera, depth);
  return depth;
}

GlRenderer::GlRenderer(std::shared_ptr<const RenderScene> scene, const RenderOptions& options)
    : state_(std::make_unique<State>(std::move(scene), options)) {
  const GlContext::Current current(state_->context);
  state_->Build();
  state_->proxy.UploadSights(state_->scene->views);
  state_->BuildPrograms();
  SetField(options.field);
}

GlRenderer::~GlRenderer() {
  if (!state_) return;
  const GlContext::Current current(state_->context);
  state_->photographs.Release();
  State& s = *state_;
  for (GlProgram* program : {&s.cover, &s.fan, &s.lumigraph, &s.normalise, &s.fill}) program->Release();
  for (GlBuffer* buffer : {&s.views, &s.centers, &s.triangles, &s.fans, &s.view_of_vertex, &s.nearest_first})
    buffer->Release();
  for (GlTarget* target : {&s.drawn, &s.confidence, &s.resolved}) target->Release();
  s.no_vertices.Release();
  s.depth.Release();
  s.proxy.Release();
}

void GlRenderer::SetField(const FieldOptions& field) {
  State& s = *state_;
  s.options.field = FieldThatServes(field, s.scene->mesh);
  s.options.field.lumigraph_k = std::clamp(s.options.field.lumigraph_k, 1, kMostLumigraphViews);
  s.mesh_field.reset();
  const FieldKind kind = s.options.field.kind;
  if (kind != FieldKind::kLinear && kind != FieldKind::kSubdivision) return;
  s.mesh_field = std::make_unique<MeshField>(s.scene, s.options.field.level);
  const FieldMesh& mesh = s.mesh_field->field_mesh();
  s.mesh_entries = MakeEntries(mesh.triangles, [&](int vertex, auto&& add) {
    for (const auto& [of_vertex, weight] : mesh.weights[At(vertex)]) add(of_vertex, weight);
  });
}

void GlRenderer::SetProxy(std::shared_ptr<const Proxy> proxy) {
  State& s = *state_;
  const GlContext::Current current(s.context);
  s.scene = WithProxy(*s.scene, std::move(proxy));
  s.proxy.UploadSights(s.scene->views);
  s.BuildPrograms();
  SetField(s.options.field);
}

FieldOptions GlRenderer::field() const { return state_->options.field; }
std::string GlRenderer::Name() const { return "gl (" + state_->context.device() + ")"; }
const RenderScene& GlRenderer::scene() const { return *state_->scene; }

double GlRenderer::Draw(const CameraModel& camera, const Rigid3& cam_from_world) {
  RequireUndistorted(camera);
  State& s = *state_;
  const GlContext::Current current(s.context);
  const auto start = std::chrono::steady_clock::now();
  const PlaneInCamera plane = s.scene->proxy->Background(cam_from_world);
  const auto triangles = s.scene->proxy->Triangles(camera, cam_from_world);
  if ((triangles != nullptr) != s.has_triangles) {
    s.has_triangles = triangles != nullptr;
    s.BuildPrograms();
  }
  if (triangles) {
    s.proxy.Draw(triangles, camera, cam_from_world, plane.offset);
    s.proxy.BindDepth(kProxyDepthUnit);
  }
  s.proxy.BindSights(kSightsUnit);
  s.depth.Resize(camera.width, camera.height);
  s.drawn.Resize(camera.width, camera.height, &s.depth);
  s.confidence.Resize(camera.width, camera.height, &s.depth);
  s.resolved.Resize(camera.width, camera.height, &s.depth);
  s.photographs.Bind();
  s.UploadViews(camera, cam_from_world);
  s.drawn.Clear(0);
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_CULL_FACE);
  glDisable(GL_BLEND);
  switch (s.options.field.kind) {
    case FieldKind::kLinear:
    case FieldKind::kSubdivision:
      s.DrawMesh(camera, cam_from_world, plane);
      break;
    case FieldKind::kLumigraph:
      s.DrawLumigraphTriangles(camera, cam_from_world, plane);
      break;
    case FieldKind::kLumigraphPerPixel:
      s.DrawLumigraphPixels(camera, plane);
      break;
    case FieldKind::kNearest:
      break;  // Resolve() is the nearest view
  }
  s.Resolve(camera, cam_from_world, plane);
  glFinish();
  CheckGl("drawing");
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
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
  const cv::Mat depth = state_->Depth(camera, cam_from_world);
  if (options.depth) picture.depth = depth;
  if (options.weights)
    picture.weights = WeightsOfViews(*state_->scene, *MakeField(state_->scene, options.field), camera,
                                     cam_from_world, depth, options.fill);
  return picture;
}

}  // namespace ulf
