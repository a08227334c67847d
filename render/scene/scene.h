// What a renderer works from: the photographs with their cameras and poses, the subject, the mesh of the
// viewpoints, and the proxy. Built once from a light field and shared by renderers and fields; never changed
// afterwards. Photographs are read when they are looked at (render/scene/photograph_store).
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/light_field/light_field.h"
#include "render/fields/viewpoint_mesh.h"
#include "render/proxy/proxy.h"
#include "render/proxy/shadow_map.h"
#include "render/scene/photograph.h"
#include "render/scene/photograph_store.h"

namespace ulf::render {

struct Seen {
  Eigen::Vector2d img;  // in the view's image
  double feather = 1;   // 0 at the edge of what is seen to 1 from kFeatherShare of the image inwards
};

// A view loses its weight over this share of the shorter side of its image.
inline constexpr double kFeatherShare = 0.03;

struct SceneView {
  int id = 0;          // View::id
  CameraModel camera;  // of the photograph as it is read, which may be smaller than it was recorded
  Rigid3 cam_from_world;
  Eigen::Vector3d center_in_world = Eigen::Vector3d::Zero();
  std::shared_ptr<const Photograph> photograph;
  // Light common to all views is (linear - black) * scale: exposure and gain differ from view to view.
  float black = 0;
  float scale = 1;

  std::shared_ptr<const LazyShadowMap> shadow_map;  // null: nothing hides anything

  // The photograph for a display, in its own exposure.
  cv::Mat Srgb8() const;
  // None when the point is behind the camera or outside its image.
  std::optional<Seen> Frame(const Eigen::Vector3d& point_in_world) const;
  // Of those the points that the proxy does not hide; the feather fades at its edges, too.
  std::optional<Seen> See(const Eigen::Vector3d& point_in_world) const;
};

struct RenderScene {
  std::vector<SceneView> views;
  Subject subject;
  Eigen::Vector3d up_in_world = -Eigen::Vector3d::UnitY();
  ViewpointMesh mesh;
  bool mesh_in_plane = false;
  bool in_metres = false;  // world units
  std::shared_ptr<const Proxy> proxy;
  std::shared_ptr<const PhotographStore> store;  // that the photographs are read from; null: they are held

  std::vector<Eigen::Vector3d> Centers() const;
  void MakeMesh();  // from the views
};

enum class PhotographForm {
  kAuto,       // kLinear where it says more, else kEightBits
  kEightBits,  // the photographs of images/, whatever masters hold more
  kLinear,     // masters where there are some; halves in linear light
};

struct SceneOptions {
  std::optional<Subject> subject = {};              // else the light field's, else from the optical axes
  std::optional<Eigen::Vector3d> up_in_world = {};  // unit; else LightField::UpInWorld()
  int size_limit_px = 0;            // longer side of the photographs as they are read; 0: as they are
  double memory_limit_mb = 2048;    // of photographs held in memory
  std::vector<int> leave_out = {};  // indices of views that are not to be used
  PhotographForm form = PhotographForm::kAuto;
  bool mesh_in_plane = false;  // ViewpointMeshOptions::in_plane
};

// The subject to render about; UsageError that asks for --subject when there is none to be had.
Subject SubjectOf(const LightField& light_field, const std::optional<Subject>& given = std::nullopt);

// Reads no photograph yet. Throws Error for an empty light field. The proxy is the plane through the subject
// that faces the virtual camera.
std::shared_ptr<const RenderScene> LoadScene(const LightField& light_field, const SceneOptions& options);

// The same photographs with some views left out: pixels are shared, the mesh is built anew.
std::shared_ptr<const RenderScene> Without(const RenderScene& scene, const std::vector<int>& left_out);

// The same photographs over another proxy; what it hides from a view is found out when that is asked.
std::shared_ptr<const RenderScene> WithProxy(const RenderScene& scene, std::shared_ptr<const Proxy> proxy);

// The pyramid level at which a view is read: the nearest to one texel per output pixel at the subject's
// distance,
//   round(log2((focal_view / |O - C|) / (focal_out / |O - V|))), within the pyramid.
int PyramidLevel(const SceneView& view, const Subject& subject, const Eigen::Vector3d& virtual_center,
                 double output_focal_px);

// A colour for each view, as linear B G R: what the blending field looks like.
cv::Vec3f ViewColor(int index);

}  // namespace ulf::render
