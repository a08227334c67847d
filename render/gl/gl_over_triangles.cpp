#include <epoxy/gl.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <set>
#include <utility>

#include "core/base/at.h"
#include "core/base/error.h"
#include "core/geometry/pinhole.h"
#include "render/fields/blending_field.h"
#include "render/fields/field_options.h"
#include "render/fields/make_field.h"
#include "render/gl/gl_renderer_state.h"

namespace ulf::render {

using Eigen::Matrix3d;
using Eigen::Vector3d;

int GlRendererState::NearestOf(std::span<const int> of_views) const {
  return *std::ranges::min_element(of_views, [&](int a, int b) {
    return (scene->views[At(a)].center_in_world - virtual_center).squaredNorm() <
           (scene->views[At(b)].center_in_world - virtual_center).squaredNorm();
  });
}

// Returns how many of the views, from the first on, can be drawn now; the caller asks again for the rest.
std::size_t GlRendererState::MakeResident(std::span<const int> of_views) {
  if (options.show_field || of_views.empty()) return of_views.size();
  const std::vector<GlPhotographs::LevelRequest> level_requests = views.LevelRequests(of_views);
  if (options.complete) {
    const std::size_t resident = photographs.Require(level_requests);
    if (resident < level_requests.size() && !std::exchange(warned_of_passes, true))
      spdlog::info(
          "the photographs of a picture do not fit into {} MB of graphics memory ({}) at once: "
          "drawing it in several passes takes longer",
          photographs.limit_bytes() / 1000000, Parameter("gpu_memory"));
    return resident;
  }
  std::vector<std::optional<int>> drawn_levels;  // of earlier passes
  for (const GlPhotographs::LevelRequest& level_request : offered)
    drawn_levels.push_back(photographs.LevelOf(level_request.view));
  offered.insert(offered.end(), level_requests.begin(), level_requests.end());
  lacks = !photographs.Offer(offered);
  const bool nothing_serves =
      std::ranges::none_of(offered, [&](const GlPhotographs::LevelRequest& level_request) {
        return photographs.PlaceOf(level_request.view).has_value();
      });
  if (lacks && nothing_serves) {  // wait for one photograph, so that the picture is not empty
    try {
      photographs.Require(views.LevelRequests(std::array{NearestOf(of_views)}));
    } catch (const Error&) {
      // Offer() warns of an unreadable photograph.
    }
    lacks = !photographs.Offer(offered);
  }
  for (std::size_t i = 0; i < drawn_levels.size(); ++i) {  // a finer level came too late for these passes
    const auto level = photographs.LevelOf(offered[i].view);
    outdated = outdated || (level && (!drawn_levels[i] || *level < *drawn_levels[i]));
  }
  return of_views.size();
}

// Calls draw() for the fans whose photographs are resident at the same time, until all fans are drawn.
void GlRendererState::ForResidentFans(const std::vector<GpuFan>& of_fans, const DrawPass& draw) {
  const std::vector<int> of_views = ViewsOf(of_fans);
  ProvideShadowMaps(of_views);
  for (std::size_t done = 0; done < of_views.size();) {
    const std::size_t end = done + MakeResident(std::span(of_views).subspan(done));
    if (!options.show_field) views.SetPlaces(photographs);
    const int first = of_views[done], last = of_views[end - 1];
    const FanBatches of_pass = MakeFanBatches(
        of_fans,
        [&](int view) -> std::optional<unsigned> {
          if (view < first || view > last) return std::nullopt;
          if (options.show_field) return 0;
          const auto place = photographs.PlaceOf(view);
          return place ? std::optional(place->texture) : std::nullopt;
        },
        programs.most_views_of_fan_batch());
    Upload(of_pass);
    draw(of_pass, done == 0 && end == of_views.size());
    done = end;
  }
}

void GlRendererState::Upload(const FanBatches& some) {
  fans.Upload(some.fans);
  fans.BindStorage(2);
  batches.Upload(some.batches);
  batches.BindStorage(3);
}

// Consecutive batches of one array and of about as many views are one draw. Unused views of a program cost as
// much as used ones, so there are programs for different numbers.
void GlRendererState::DrawFanBatches(const FanBatches& some, bool direct) {
  const auto kind_of = [&](const GpuFanBatch& batch) {
    const int views = static_cast<int>(batch.count | 1);
    return std::pair(batch.array, std::min(views, programs.most_views_of_fan_batch()));
  };
  std::set<int> are_set;  // programs whose uniforms are set
  for (std::size_t first = 0, end = 0; first < some.batches.size(); first = end) {
    const auto kind = kind_of(some.batches[first]);
    while (end < some.batches.size() && kind_of(some.batches[end]) == kind) ++end;
    const GlProgram& program = programs.FanBatch(kind.second, direct);
    if (are_set.insert(kind.second).second) {
      SetCommon(program);
      SetResolve(program);
    }
    program.Use();
    glBindTextureUnit(0, kind.first);
    glDrawArrays(GL_TRIANGLES, static_cast<GLint>(3 * first), static_cast<GLsizei>(3 * (end - first)));
  }
}

void GlRendererState::BindForAdding() {
  drawn.Bind();
  glEnable(GL_BLEND);
  glBlendFunc(GL_ONE, GL_ONE);
}

// The last of overlapping triangles counts. If each triangle has all its views in one batch, drawing the
// batches in their order finishes the picture, except for open pixels. Otherwise the batches are added up at
// the pixels where their triangle is the last one, which the depth test decides.
void GlRendererState::DrawBatch(const TriangleBatch& batch, bool more_follow) {
  if (batch.triangles.empty()) return drawn.Clear(0);
  triangles.Upload(batch.triangles);
  triangles.BindStorage(1);
  no_vertices.Bind();
  bool is_covered = false;
  const auto cover = [&] {
    if (std::exchange(is_covered, true)) return;
    drawn.Clear(0);
    SetDepthTest(GL_ALWAYS, true);
    confidence.Bind();
    programs.cover().Use();
    glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(3 * batch.triangles.size()));
    glDisable(GL_DEPTH_TEST);
  };
  ForResidentFans(batch.fans, [&](const FanBatches& of_pass, bool are_all) {
    is_resolved = are_all && of_pass.one_each && !more_follow;
    if (is_resolved) {
      ClearResolved();
      resolved.Bind();
      SetDepthTest(GL_ALWAYS, true);
      DrawFanBatches(of_pass, true);
    } else {
      cover();
      SetDepthTest(GL_EQUAL, false);
      BindForAdding();
      DrawFanBatches(of_pass, false);
      glDisable(GL_BLEND);
    }
    glDisable(GL_DEPTH_TEST);
  });
  if (!is_resolved) cover();
}

void GlRendererState::AddRings(const TriangleBatch& rings) {
  triangles.Upload(rings.triangles);
  triangles.BindStorage(1);
  no_vertices.Bind();
  confidence.Bind();
  glEnable(GL_BLEND);
  glBlendFunc(GL_ONE, GL_ONE);
  Upload(MakeFanBatches(
      rings.fans, [](int) { return 0u; }, 1));
  SetCommon(programs.RingWeight());
  glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(3 * rings.fans.size()));
  ForResidentFans(rings.fans, [&](const FanBatches& of_pass, bool /*are_all*/) {
    BindForAdding();
    DrawFanBatches(of_pass, false);
  });
  glDisable(GL_BLEND);
}

void GlRendererState::DrawMesh() {
  const PlacedMesh placed = mesh_field->Place(cam_from_world.OriginInSource());
  const TriangleBatch rings = RingTriangles(placed, camera, cam_from_world);
  if (!rings.fans.empty()) confidence.Clear(0);
  DrawBatch(MeshTriangles(placed, camera, cam_from_world), !rings.fans.empty());
  if (!rings.fans.empty()) AddRings(rings);
}

// Returns the field on the processor, for the current picture; null for the soft field.
std::unique_ptr<PlacedField> GlRendererState::FieldFrom() const {
  if (options.field.kind == FieldKind::kSoft) return nullptr;
  if (aperture_field) return aperture_field->From(cam_from_world, *options.aperture);
  if (options.field.kind == FieldKind::kLumigraph)
    return LumigraphAtVertices(*scene, camera, cam_from_world, DepthOfVertices(), options.field);
  return MakeField(scene, options.field)->From(cam_from_world.OriginInSource());
}

// Returns the rings of a wide aperture, in no order, with weights times the rings' share; none if no ring has
// grown.
TriangleBatch GlRendererState::RingTriangles(const PlacedMesh& placed, const CameraModel& camera,
                                             const Rigid3& cam_from_world) const {
  TriangleBatch batch;
  if (!aperture_field) return batch;
  const WarpedRings rings = aperture_field->Warp(placed, cam_from_world, *options.aperture);
  if (rings.share == 0) return batch;
  for (const WarpedTriangle& part : rings.triangles) {
    const auto triangle = MakeTriangle(part.corners, part.cone_from_ray, camera,
                                       mesh_field->field_mesh().confidence[At(part.triangle)], 0);
    if (!triangle) continue;
    const Vector3d weights = rings.share * part.weights;
    batch.fans.push_back({static_cast<std::uint32_t>(batch.triangles.size()),
                          static_cast<std::uint32_t>(placed.view_of_vertex[At(part.vertex)]),
                          {},
                          MakeVec4(weights.x(), weights.y(), weights.z(), 0)});
    batch.triangles.push_back(*triangle);
  }
  return batch;
}

TriangleBatch GlRendererState::MeshTriangles(const PlacedMesh& placed, const CameraModel& camera,
                                             const Rigid3& cam_from_world) const {
  const FieldMesh& mesh = mesh_field->field_mesh();
  const Matrix3d cam_from_world_r = cam_from_world.RotationMatrix();
  const double count = static_cast<double>(mesh.triangles.size());
  TriangleBatch batch;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (placed.cone_from_ray[t].isZero(0)) continue;
    AddTriangle(cam_from_world_r * placed.corners[t], placed.cone_from_ray[t] * cam_from_world_r.transpose(),
                camera, mesh.confidence[t], static_cast<double>(t) / count, mesh_entries, t,
                placed.view_of_vertex, batch);
  }
  return batch;
}

DepthAt GlRendererState::DepthOfVertices() const {
  return DepthFromPicture(has_triangles ? proxy.ReadDepth() : cv::Mat(), plane, camera);
}

TriangleBatch GlRendererState::LumigraphTriangles() const {
  const auto image = TriangulateLumigraph(*scene, camera, cam_from_world, DepthOfVertices(), options.field);
  const EntryTable table = MakeEntries(image.triangles, [&](int vertex, auto&& add) {
    for (const ViewWeight& entry : image.weights[At(vertex)]) add(entry.view, entry.weight);
  });
  const double count = static_cast<double>(image.triangles.size());
  TriangleBatch batch;
  for (std::size_t t = 0; t < image.triangles.size(); ++t) {
    Matrix3d corners;
    for (int k = 0; k < 3; ++k) corners.col(k) = PinholeRay(camera, image.img[At(image.triangles[t][At(k)])]);
    AddTriangle(corners, corners.inverse(), camera, 1.0, static_cast<double>(t) / count, table, t, {}, batch);
  }
  return batch;
}

}  // namespace ulf::render
