#include "render/gl_renderer.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <map>
#include <optional>

#include "acquisition/error.h"
#include "render/embedded_shaders.h"
#include "render/gl_context.h"
#include "render/gl_objects.h"
#include "render/image_triangulation.h"
#include "render/lumigraph_field.h"
#include "render/mesh_field.h"

namespace ulf {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

std::size_t At(int index) { return static_cast<std::size_t>(index); }

using Vec4 = std::array<float, 4>;

Vec4 MakeVec4(double x, double y, double z, double w) {
  return {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z), static_cast<float>(w)};
}

// The shaders' structs (std430).
struct GpuView {
  Vec4 row0, row1, row2, intrinsics, size, k, more, color, center;
  std::array<std::int32_t, 4> place;
};
struct GpuCone {
  Vec4 row0, row1, row2;
};
struct GpuVertex {
  float x, y, w;
  std::uint32_t triangle;
};

constexpr int kMostLumigraphViews = 8;

// What one draw of triangles needs, whatever they are triangles of.
struct TriangleBatch {
  std::vector<GpuVertex> vertices;
  std::vector<GpuCone> cones;
};

// The triangle's image; nothing when it does not meet the frame. Corners are in the camera frame.
void AddTriangle(const Matrix3d& corners_in_cam, const Matrix3d& cone_from_ray_in_cam,
                 const CameraModel& camera, double confidence, std::int32_t first, std::int32_t count,
                 TriangleBatch& batch) {
  std::array<GpuVertex, 3> corners;
  std::array<int, 5> outside{};
  for (int k = 0; k < 3; ++k) {
    const Vector3d c = corners_in_cam.col(k);
    const double x = 2 * (camera.fx * c.x() + camera.cx * c.z()) / camera.width - c.z();
    const double y = 2 * (camera.fy * c.y() + camera.cy * c.z()) / camera.height - c.z();
    outside[0] += c.z() <= 0;
    outside[1] += x > c.z();
    outside[2] += -x > c.z();
    outside[3] += y > c.z();
    outside[4] += -y > c.z();
    corners[At(k)] = {static_cast<float>(x), static_cast<float>(y), static_cast<float>(c.z()),
                      static_cast<std::uint32_t>(batch.cones.size())};
  }
  if (std::count(outside.begin(), outside.end(), 3) > 0) return;
  batch.vertices.insert(batch.vertices.end(), corners.begin(), corners.end());
  const Matrix3d& m = cone_from_ray_in_cam;
  batch.cones.push_back({MakeVec4(m(0, 0), m(0, 1), m(0, 2), confidence),
                         MakeVec4(m(1, 0), m(1, 1), m(1, 2), std::bit_cast<float>(first)),
                         MakeVec4(m(2, 0), m(2, 1), m(2, 2), std::bit_cast<float>(count))});
}

// A view's weights at a triangle's corners; the vertex index travels in a float's bits.
Vec4 MakeEntry(int vertex, const std::array<double, 3>& weights) {
  Vec4 entry = MakeVec4(0, weights[0], weights[1], weights[2]);
  entry[0] = std::bit_cast<float>(static_cast<std::int32_t>(vertex));
  return entry;
}

// For each triangle the range of its entries.
struct EntryTable {
  std::vector<Vec4> entries;
  std::vector<std::int32_t> first;  // one more than there are triangles
};

template <typename WeightsOfCorner>
EntryTable MakeEntries(const std::vector<Triangle>& triangles, WeightsOfCorner&& weights_of_corner) {
  EntryTable table;
  for (const Triangle& t : triangles) {
    table.first.push_back(static_cast<std::int32_t>(table.entries.size()));
    std::map<int, std::array<double, 3>> of_key;
    for (std::size_t k = 0; k < 3; ++k)
      weights_of_corner(t[k], [&](int key, double weight) { of_key[key][k] += weight; });
    for (const auto& [key, weights] : of_key) table.entries.push_back(MakeEntry(key, weights));
  }
  table.first.push_back(static_cast<std::int32_t>(table.entries.size()));
  return table;
}

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
  PlaneProxy proxy;
  GlContext context;

  PhotographTextures photographs;
  GlProgram triangles, lumigraph, resolve;
  GlBuffer views, cones, entries, view_of_vertex, nearest_first, vertices;
  GlVertexArray vertex_array;
  GlTarget drawn, resolved;
  std::vector<double> trusted_extent;

  std::unique_ptr<MeshField> mesh_field;
  EntryTable mesh_entries;

  State(std::shared_ptr<const RenderScene> the_scene, const RenderOptions& the_options)
      : scene(std::move(the_scene)), options(the_options), proxy(scene->subject) {}

  void Build();
  void UploadViews(const CameraModel& camera, const Rigid3& cam_from_world);
  void SetCommon(const GlProgram& program, const CameraModel& camera, const PlaneInCamera& plane) const;
  void DrawMesh(const CameraModel& camera, const Rigid3& cam_from_world);
  void DrawLumigraphTriangles(const CameraModel& camera, const Rigid3& cam_from_world,
                              const PlaneInCamera& plane);
  void DrawLumigraphPixels();
  void DrawBatch(const TriangleBatch& batch);
  void Resolve(const CameraModel& camera, const Rigid3& cam_from_world, const PlaneInCamera& plane);
};

void GlRenderer::State::Build() {
  std::vector<const ViewPyramid*> pyramids;
  for (const SceneView& view : scene->views) {
    pyramids.push_back(&view.pyramid);
    trusted_extent.push_back(TrustedExtent(view.camera));
  }
  photographs.Upload(pyramids);
  const std::string head =
      "#version 450 core\n#define ARRAYS " + std::to_string(photographs.ArrayCount()) + "\n";
  const std::string common = head + shaders::k_common_glsl;
  triangles.Build("triangles", head + shaders::k_triangles_vert, common + shaders::k_triangles_frag);
  lumigraph.Build("lumigraph", head + shaders::k_fullscreen_vert, common + shaders::k_lumigraph_frag);
  resolve.Build("resolve", head + shaders::k_fullscreen_vert, common + shaders::k_resolve_frag);
  vertex_array.Attribute(0, 3, GL_FLOAT, 0);
  vertex_array.Attribute(1, 1, GL_UNSIGNED_INT, 3 * sizeof(float));
}

void GlRenderer::State::UploadViews(const CameraModel& camera, const Rigid3& cam_from_world) {
  const Rigid3 world_from_cam = cam_from_world.Inverse();
  const Vector3d virtual_center = cam_from_world.OriginInSource();
  std::vector<GpuView> gpu_views;
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
    out.place = {array, layer, PyramidLevel(view, scene->subject, virtual_center, camera.MeanFocalPx()), 0};
  }
  views.Upload(gpu_views);
  views.BindStorage(0);
}

void GlRenderer::State::SetCommon(const GlProgram& program, const CameraModel& camera,
                                  const PlaneInCamera& plane) const {
  program.Use();
  program.Set("camera", MakeVec4(camera.fx, camera.fy, camera.cx, camera.cy));
  program.Set("plane", MakeVec4(plane.normal.x(), plane.normal.y(), plane.normal.z(), plane.offset));
  program.Set("far_depth", static_cast<float>(plane.far_depth));
  program.Set("show_field", options.show_field ? 1 : 0);
  program.Set("least_weight", static_cast<float>(kLeastWeight));
}

void GlRenderer::State::DrawBatch(const TriangleBatch& batch) {
  if (batch.vertices.empty()) return;
  vertices.Upload(batch.vertices);
  cones.Upload(batch.cones);
  cones.BindStorage(1);
  entries.BindStorage(2);
  view_of_vertex.BindStorage(3);
  vertex_array.Bind(vertices, sizeof(GpuVertex));
  glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(batch.vertices.size()));
}

void GlRenderer::State::DrawMesh(const CameraModel& camera, const Rigid3& cam_from_world) {
  const PlacedMesh placed = mesh_field->Place(cam_from_world.OriginInSource());
  const FieldMesh& mesh = mesh_field->field_mesh();
  const Matrix3d cam_from_world_r = cam_from_world.RotationMatrix();
  TriangleBatch batch;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (placed.cone_from_ray[t].isZero(0)) continue;
    AddTriangle(cam_from_world_r * placed.corners[t], placed.cone_from_ray[t] * cam_from_world_r.transpose(),
                camera, mesh.confidence[t], mesh_entries.first[t],
                mesh_entries.first[t + 1] - mesh_entries.first[t], batch);
  }
  view_of_vertex.Upload(placed.view_of_vertex);
  DrawBatch(batch);
}

void GlRenderer::State::DrawLumigraphTriangles(const CameraModel& camera, const Rigid3& cam_from_world,
                                               const PlaneInCamera& plane) {
  const auto image = TriangulateLumigraph(*scene, camera, cam_from_world, plane, options.field.lumigraph_k);
  const EntryTable table = MakeEntries(image.triangles, [&](int vertex, auto&& add) {
    for (const ViewWeight& entry : image.weights[At(vertex)]) add(entry.view, entry.weight);
  });
  TriangleBatch batch;
  for (std::size_t t = 0; t < image.triangles.size(); ++t) {
    // Rays with unit z as corners: what the shader normalises is then linear in the image.
    Matrix3d corners;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector2d& img = image.img[At(image.triangles[t][At(k)])];
      corners.col(k) = Vector3d((img.x() - camera.cx) / camera.fx, (img.y() - camera.cy) / camera.fy, 1.0);
    }
    AddTriangle(corners, corners.inverse(), camera, 1.0, table.first[t], table.first[t + 1] - table.first[t],
                batch);
  }
  std::vector<std::int32_t> identity(scene->views.size());
  for (std::size_t i = 0; i < identity.size(); ++i) identity[i] = static_cast<std::int32_t>(i);
  view_of_vertex.Upload(identity);
  entries.Upload(table.entries);
  DrawBatch(batch);
}

void GlRenderer::State::DrawLumigraphPixels() {
  lumigraph.Set("view_count", static_cast<int>(scene->views.size()));
  lumigraph.Set("k_best", options.field.lumigraph_k);
  lumigraph.Set("resolution_penalty", static_cast<float>(kResolutionPenalty));
  lumigraph.Set("zero_penalty", static_cast<float>(kLumigraphZeroPenalty));
  lumigraph.Set("above_tie", static_cast<float>(kThresholdAboveTie));
  lumigraph.Set("above_largest", static_cast<float>(kThresholdAboveLargest));
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

void GlRenderer::State::Resolve(const CameraModel& camera, const Rigid3& cam_from_world,
                                const PlaneInCamera& plane) {
  SetCommon(resolve, camera, plane);
  resolve.Set("view_count", static_cast<int>(scene->views.size()));
  resolve.Set("fill", options.fill ? 1 : 0);
  resolve.Set("nearest_is_the_field", options.field.kind == FieldKind::kNearest ? 1 : 0);
  nearest_first.Upload(ViewsByDistance(*scene, cam_from_world.OriginInSource()));
  nearest_first.BindStorage(4);
  drawn.BindTexture(15);
  resolved.BindAndClear();
  vertex_array.BindEmpty();
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

GlRenderer::GlRenderer(std::shared_ptr<const RenderScene> scene, const RenderOptions& options)
    : state_(std::make_unique<State>(std::move(scene), options)) {
  const GlContext::Current current(state_->context);
  state_->Build();
  SetField(options.field);
}

GlRenderer::~GlRenderer() {
  if (!state_) return;
  const GlContext::Current current(state_->context);
  state_->photographs.Release();
  for (GlProgram* program : {&state_->triangles, &state_->lumigraph, &state_->resolve}) program->Release();
  for (GlBuffer* buffer : {&state_->views, &state_->cones, &state_->entries, &state_->view_of_vertex,
                           &state_->nearest_first, &state_->vertices})
    buffer->Release();
  state_->vertex_array.Release();
  state_->drawn.Release();
  state_->resolved.Release();
}

void GlRenderer::SetField(const FieldOptions& field) {
  State& s = *state_;
  s.options.field = FieldThatServes(field, s.scene->mesh);
  s.options.field.lumigraph_k = std::clamp(s.options.field.lumigraph_k, 1, kMostLumigraphViews);
  s.mesh_field.reset();
  const FieldKind kind = s.options.field.kind;
  if (kind != FieldKind::kLinear && kind != FieldKind::kSubdivision) return;
  const GlContext::Current current(s.context);
  s.mesh_field = std::make_unique<MeshField>(s.scene, s.options.field.level);
  const FieldMesh& mesh = s.mesh_field->field_mesh();
  s.mesh_entries = MakeEntries(mesh.triangles, [&](int vertex, auto&& add) {
    for (const auto& [of_vertex, weight] : mesh.weights[At(vertex)]) add(of_vertex, weight);
  });
  s.entries.Upload(s.mesh_entries.entries);
}

FieldOptions GlRenderer::field() const { return state_->options.field; }
std::string GlRenderer::Name() const { return "gl (" + state_->context.device() + ")"; }
const RenderScene& GlRenderer::scene() const { return *state_->scene; }

double GlRenderer::Draw(const CameraModel& camera, const Rigid3& cam_from_world) {
  RequireUndistorted(camera);
  State& s = *state_;
  const GlContext::Current current(s.context);
  const auto start = std::chrono::steady_clock::now();
  const PlaneInCamera plane = *s.proxy.AsPlane(cam_from_world);
  s.drawn.Resize(camera.width, camera.height);
  s.resolved.Resize(camera.width, camera.height);
  s.photographs.Bind();
  s.UploadViews(camera, cam_from_world);
  s.drawn.BindAndClear();
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_CULL_FACE);
  glDisable(GL_BLEND);
  switch (s.options.field.kind) {
    case FieldKind::kLinear:
    case FieldKind::kSubdivision:
      s.SetCommon(s.triangles, camera, plane);
      s.DrawMesh(camera, cam_from_world);
      break;
    case FieldKind::kLumigraph:
      s.SetCommon(s.triangles, camera, plane);
      s.DrawLumigraphTriangles(camera, cam_from_world, plane);
      break;
    case FieldKind::kLumigraphPerPixel:
      s.SetCommon(s.lumigraph, camera, plane);
      s.vertex_array.BindEmpty();
      s.DrawLumigraphPixels();
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
  for (int y = 0; y < bgra.rows; ++y)
    for (int x = 0; x < bgra.cols; ++x) {
      const cv::Vec4f& p = bgra.at<cv::Vec4f>(y, x);
      picture.linear.at<cv::Vec3f>(y, x) = {p[0], p[1], p[2]};
      picture.confidence.at<float>(y, x) = std::max(0.0f, p[3]);
      picture.filled_px += p[3] == -1.0f;
      picture.empty_px += p[3] == -2.0f;
    }
  return picture;
}

}  // namespace ulf
