#include "render/gl/gl_views.h"

#include <algorithm>
#include <cstdint>
#include <limits>

#include "core/base/at.h"

namespace ulf::render {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Vec4 OfSizeOne(const CameraModel& camera) {
  return MakeVec4(camera.fx / camera.width, camera.fy / camera.height, camera.cx / camera.width,
                  camera.cy / camera.height);
}

}  // namespace

void GlViews::Build(const RenderScene& scene) {
  // Most views have the same camera as the previous one.
  const CameraModel* before = nullptr;
  for (const SceneView& view : scene.views) {
    const bool is_as_before = before && *before == view.camera;
    distortion_extent_.push_back(is_as_before ? distortion_extent_.back() : view.camera.DistortionExtent());
    shadow_map_.push_back(is_as_before ? shadow_map_.back() : OfSizeOne(ShadowMapCamera(view.camera)));
    before = &view.camera;
  }
  has_gaps_.assign(scene.views.size(), false);
}

void GlViews::Place(const RenderScene& scene, const CameraModel& camera, const Rigid3& cam_from_world) {
  const Rigid3 world_from_cam = cam_from_world.Inverse();
  const Vector3d virtual_center = cam_from_world.OriginInSource();
  gpu_views_.clear();
  level_.clear();
  for (std::size_t i = 0; i < scene.views.size(); ++i) {
    const SceneView& view = scene.views[i];
    const Rigid3 view_from_cam = view.cam_from_world * world_from_cam;
    const Matrix3d r = view_from_cam.RotationMatrix();
    const Vector3d& t = view_from_cam.translation;
    const auto& c = view.camera.coefficients;
    const bool fisheye = view.camera.distortion == Distortion::kFisheye;
    const double kind = view.camera.distortion == Distortion::kNone ? 0 : fisheye ? 2 : 1;
    const cv::Vec3f bgr = ViewColor(view.id);
    const Vector3d center = cam_from_world * view.center_in_world;
    GpuView& out = gpu_views_.emplace_back();
    out.row0 = MakeVec4(r(0, 0), r(0, 1), r(0, 2), t.x());
    out.row1 = MakeVec4(r(1, 0), r(1, 1), r(1, 2), t.y());
    out.row2 = MakeVec4(r(2, 0), r(2, 1), r(2, 2), t.z());
    out.intrinsics = MakeVec4(view.camera.fx, view.camera.fy, view.camera.cx, view.camera.cy);
    out.size =
        MakeVec4(view.camera.width, view.camera.height,
                 kFeatherShare * std::min(view.camera.width, view.camera.height), distortion_extent_[i]);
    out.k = MakeVec4(c[0], c[1], c[2], c[3]);
    out.more = MakeVec4(c[4], view.black, view.scale, kind);
    out.color = MakeVec4(bgr[2], bgr[1], bgr[0], 1);
    out.center = MakeVec4(center.x(), center.y(), center.z(), has_gaps_[i] ? 1 : 0);
    out.shadow_map = shadow_map_[i];
    out.place = {-1, 0, -1, -1};
    const LightCorrection& light = view.correction;
    out.color[3] = light.falloff_r4;
    out.correction = MakeVec4(1 / light.gain[2], 1 / light.gain[1], 1 / light.gain[0], light.falloff_r2);
    level_.push_back(PyramidLevel(view, scene, virtual_center, camera.MeanFocalPx()));
  }
}

std::vector<GlPhotographs::LevelRequest> GlViews::LevelRequests(std::span<const int> views) const {
  std::vector<GlPhotographs::LevelRequest> level_requests;
  for (const int view : views) level_requests.push_back({view, level_[At(view)]});
  return level_requests;
}

void GlViews::Upload() {
  views_.Upload(gpu_views_);
  views_.Bind(kUnit);
}

std::size_t GlViews::SetPlaces(std::span<const int> views, const GlPhotographs& photographs,
                               std::vector<unsigned>& arrays) {
  for (GpuView& view : gpu_views_) view.place[0] = -1;
  arrays.clear();
  std::size_t done = 0;
  for (; done < views.size(); ++done) {
    const auto place = photographs.PlaceOf(views[done]);
    if (!place) continue;
    const auto array = std::ranges::find(arrays, place->texture);
    const auto number = static_cast<std::int32_t>(array - arrays.begin());
    if (array == arrays.end()) {
      if (number == kMostArrays) break;
      arrays.push_back(place->texture);
    }
    GpuView& view = gpu_views_[At(views[done])];
    view.place[0] = static_cast<float>(number);
    view.place[1] = static_cast<float>(place->layer);
  }
  Upload();
  return done;
}

void GlViews::SetPlaces(const GlPhotographs& photographs) {
  for (std::size_t i = 0; i < gpu_views_.size(); ++i)
    if (const auto place = photographs.PlaceOf(static_cast<int>(i)))
      gpu_views_[i].place[1] = static_cast<float>(place->layer);
  Upload();
}

void GlViews::SetShadowMaps(const GlShadowMaps& shadow_maps) {
  for (std::size_t i = 0; i < gpu_views_.size(); ++i)
    gpu_views_[i].place[3] = static_cast<float>(shadow_maps.LayerOf(static_cast<int>(i)));
  Upload();
}

void GlViews::SetDepthMaps(const RenderScene& scene, const GlDepthMaps& depth_maps) {
  for (std::size_t i = 0; i < gpu_views_.size(); ++i) {
    GpuView& out = gpu_views_[i];
    const int layer = depth_maps.LayerOf(static_cast<int>(i));
    out.place[2] = static_cast<float>(layer);
    if (layer < 0) continue;
    const ViewDepthMap& map = scene.views[i].depth_map->Get();
    const CameraModel& camera = map.camera;
    constexpr double kMost = std::numeric_limits<std::uint16_t>::max();
    out.map_intrinsics = MakeVec4(camera.fx, camera.fy, camera.cx, camera.cy);
    out.map_more = MakeVec4(camera.width, camera.height, kMost * map.unit, map.step);
  }
  Upload();
}

void GlViews::SetOneCamera(const GlProgram& program) const {
  const GpuView& first = gpu_views_.front();
  const auto& [fx, fy, cx, cy] = first.intrinsics;
  const auto& [width, height, feather, extent] = first.size;
  program.Set("to_uv", Vec4{fx / width, fy / height, cx / width, cy / height});
  program.Set("intrinsics", first.intrinsics);
  program.Set("size", first.size);
  program.Set("k", first.k);
  program.Set("more", first.more);
  program.Set("light", Vec4{width / feather, height / feather, first.more[1], first.more[2]});
  program.Set("shadow_map", first.shadow_map);
}

void GlViews::SetGaps(int view) {
  has_gaps_[At(view)] = true;
  gpu_views_[At(view)].center[3] = 1;
}

void GlViews::Release() { views_.Release(); }

}  // namespace ulf::render
