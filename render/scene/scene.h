// The input of a renderer: the photographs with their cameras and poses, the subject, the mesh of the
// viewpoints, and the proxy. LoadScene() builds it from a light field; renderers and fields share it and
// never change it. Photographs are read when a renderer requests them (render/photographs/photograph_store).
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/light_field/light_field.h"
#include "render/photographs/photograph.h"
#include "render/photographs/photograph_store.h"
#include "render/proxy/proxy.h"
#include "render/proxy/shadow_map.h"
#include "render/viewpoints/viewpoint_mesh.h"

namespace ulf::render {

// A point in a view's image.
struct Seen {
  Eigen::Vector2d img;  // pixels
  double feather = 1;   // the view's weight there: 0 at the edge of its image, 1 from kFeatherShare inwards
};

// The width of the band at the edge of a view's image in which its weight grows from 0 to 1, over the shorter
// side of the image. Guessed.
inline constexpr double kFeatherShare = 0.03;

// How bright a photograph is beside the other views', where nobody wrote it down: what
// render/quality/light_fit found.
struct LightCorrection {
  cv::Vec3f gain{1, 1, 1};               // B G R: over the common scale of all views
  float falloff_r2 = 0, falloff_r4 = 0;  // the lens gives 1 + falloff_r2 r^2 + falloff_r4 r^4 of the light
  bool operator==(const LightCorrection&) const = default;

  // r is the distance from the principal point over half of the image's diagonal.
  float Falloff(const CameraModel& camera, const Eigen::Vector2d& img) const;
};

struct SceneView {
  int id = 0;          // View::id
  CameraModel camera;  // of the photograph as the store reads it, which may be smaller than recorded
  Rigid3 cam_from_world;
  Eigen::Vector3d center_in_world = Eigen::Vector3d::Zero();
  std::shared_ptr<const Photograph> photograph;
  // (linear - black) * scale is light on a scale common to all views: their exposures and gains differ.
  float black = 0;
  float scale = 1;
  // Divided out after that. Left alone it changes nothing.
  LightCorrection correction;

  std::shared_ptr<const LazyShadowMap> shadow_map;  // null: the proxy hides nothing
  std::shared_ptr<const LazyDepthMap> depth_map;    // null: the proxy has none

  // B G R: what light above black is multiplied by at a point of the image, to be on the common scale.
  cv::Vec3f ScaleAt(const Eigen::Vector2d& img) const;
  // The photograph in 8-bit sRGB, with its own exposure.
  cv::Mat Srgb8() const;
  // None where the point is behind the camera or outside its image.
  std::optional<Seen> Frame(const Eigen::Vector3d& point_in_world) const;
  // The same, and none where the proxy hides the point; the feather fades at the proxy's edges as well.
  std::optional<Seen> See(const Eigen::Vector3d& point_in_world) const;
};

struct RenderScene {
  std::vector<SceneView> views;
  Subject subject;
  Eigen::Vector3d up_in_world = -Eigen::Vector3d::UnitY();
  ViewpointMesh mesh;
  bool mesh_in_plane = false;
  bool in_metres = false;  // whether world units are metres
  // Whether the light field says how long or how sensitively the photographs were exposed.
  bool knows_exposures = false;
  // Whether its light is linear sRGB: by a colour profile, a raw file's own matrix, or because the camera
  // encoded its pictures so. Else (linear masters without a profile) colours are the sensor's own.
  bool knows_colors = true;
  // Whether what masks leave out is no part of the scene (LightField::turntable), and pictures
  // are empty there.
  bool is_cut_out = false;
  std::shared_ptr<const Proxy> proxy;
  std::shared_ptr<const PhotographStore> store;  // reads the photographs; null: they are in memory

  std::vector<Eigen::Vector3d> Centers() const;
  void MakeMesh();  // from the views' centres
};

enum class PhotographForm {
  kAuto,       // kLinear where 8 bits would lose light, else kEightBits
  kEightBits,  // the photographs of images/, even where masters hold more
  kLinear,     // half floats in linear light, of masters where there are some
};

struct SceneOptions {
  std::optional<Subject> subject = {};              // else the light field's, else from the optical axes
  std::optional<Eigen::Vector3d> up_in_world = {};  // unit; else LightField::UpInWorld()
  int size_limit_px = 0;                            // PhotographStoreOptions::size_limit_px
  double memory_limit_mb = 2048;                    // PhotographStoreOptions::memory_limit_mb
  std::vector<int> leave_out = {};                  // indices of views that the scene does not get
  PhotographForm form = PhotographForm::kAuto;
  bool mesh_in_plane = false;  // ViewpointMeshOptions::in_plane
  // Where the longest exposure is more than this many times the shortest, kAuto reads linear light, since
  // shadows of 8 bits would be brightened; and clipped pixels of exposures that are so much longer than the
  // shortest have hardly any weight. Guessed: a third of a stop.
  float most_exposure_ratio = 1.26f;
  bool of_masks = false;      // the views' masks in place of their photographs: light 1 inside, 0 outside
  bool masks_clipped = true;  // false: clipped pixels are light like others, for comparison
};

// The given subject, else the light field's, else the point where the optical axes meet. Throws Refusal
// that asks for a subject where there is none.
Subject SubjectOf(const LightField& light_field, const std::optional<Subject>& given = std::nullopt);

// Reads no photograph yet, but those that tell a view's unknown exposure (exposure_scales.h). The proxy is
// the plane through the subject that faces the virtual camera. Throws Error for an empty light field.
std::shared_ptr<const RenderScene> LoadScene(const LightField& light_field, const SceneOptions& options);

// The scene without some of its views: it shares the photographs and gets a mesh of its own.
std::shared_ptr<const RenderScene> Without(const RenderScene& scene, const std::vector<int>& left_out);

// The scene over another proxy. Shadow maps are made when they are first needed.
std::shared_ptr<const RenderScene> WithProxy(const RenderScene& scene, std::shared_ptr<const Proxy> proxy);

// The pyramid level at which a view is read: the one nearest to one texel per output pixel at the subject's
// distance,
//   round(log2((focal_view / |O - C|) / (focal_out / |O - V|))), limited to the pyramid.
int PyramidLevel(const SceneView& view, const Subject& subject, const Eigen::Vector3d& virtual_center,
                 double output_focal_px);

// A colour for each view, as linear B G R, for pictures of the blending field.
cv::Vec3f ViewColor(int index);

}  // namespace ulf::render
