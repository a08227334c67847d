// The input of a renderer: the photographs with their cameras and poses, the subject, the mesh of the
// viewpoints, and the proxy. LoadScene() builds it from a light field; renderers and fields share it and
// never change it. Photographs are read when a renderer requests them (render/photographs/photograph_store).
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "core/light_field/light_field.h"
#include "render/photographs/photograph.h"
#include "render/photographs/photograph_store.h"
#include "render/proxy/proxy.h"
#include "render/proxy/shadow_map.h"
#include "render/viewpoints/viewpoint_mesh.h"

namespace ulf::render {

// A view's observation of a point.
struct Seen {
  Eigen::Vector2d img;  // px
  double feather = 1;   // the view's weight: 0 at the edge of its image, 1 from kFeatherShare inwards
};

// The width of the band at an image's edge in which weight grows from 0 to 1, over the shorter side. Guessed.
inline constexpr double kFeatherShare = 0.03;

// A photograph's brightness relative to the other views', where it was not recorded but estimated from the
// photographs (render/quality/light_fit.h).
struct LightCorrection {
  cv::Vec3f gain{1, 1, 1};               // B G R, relative to the common scale of all views
  float falloff_r2 = 0, falloff_r4 = 0;  // the lens passes 1 + falloff_r2 r^2 + falloff_r4 r^4
  bool operator==(const LightCorrection&) const = default;

  // Returns what the lens passes at `img`; r is the distance from the principal point, divided by half of the
  // image's diagonal.
  float Falloff(const CameraModel& camera, const Eigen::Vector2d& img) const;
};

struct SceneView {
  int id = 0;          // View::id
  CameraModel camera;  // of the photograph in the store, which may be smaller than recorded
  Rigid3 cam_from_world;
  Eigen::Vector3d center_in_world = Eigen::Vector3d::Zero();
  std::shared_ptr<const Photograph> photograph;
  // (linear - black) * scale brings the photograph's linear light to a scale common to all views, whose
  // exposures differ; it is then divided by `correction`, which by default changes nothing.
  float black = 0;
  float scale = 1;
  LightCorrection correction;

  std::shared_ptr<const LazyShadowMap> shadow_map;  // null: the proxy hides nothing
  std::shared_ptr<const LazyDepthMap> depth_map;    // null: the proxy has none

  // Returns the factors from light above black to the common scale at a point of the image, B G R.
  cv::Vec3f ScaleAt(const Eigen::Vector2d& img) const;
  // Returns the photograph in 8-bit sRGB, with its own exposure.
  cv::Mat Srgb8() const;
  // Returns none if the point is behind the camera or outside its image.
  std::optional<Seen> Project(const Eigen::Vector3d& point_in_world) const;
  // Does the same, and returns none if the proxy hides the point; the feather also fades at its outlines.
  std::optional<Seen> ProjectVisible(const Eigen::Vector3d& point_in_world) const;
};

struct RenderScene {
  std::vector<SceneView> views;
  Subject subject;  // if `has_subject` is false: MiddleOfPoints()
  Eigen::Vector3d up_in_world = -Eigen::Vector3d::UnitY();
  ViewpointMesh mesh;
  bool mesh_in_plane = false;    // ViewpointMeshOptions::in_plane
  bool in_metres = false;        // whether world units are metres
  bool knows_exposures = false;  // KnowsExposures() of exposure_scales.h
  // Whether light is linear sRGB, by a colour profile, a raw file's own matrix, or the camera's encoding.
  // Otherwise (linear masters without a profile) colours are the sensor's own.
  bool knows_colors = true;
  // Whether masked areas are no part of the scene (LightField::turntable) and stay empty in renderings.
  bool is_cut_out = false;
  bool has_subject = true;
  std::shared_ptr<const Proxy> proxy;
  std::shared_ptr<const PhotographStore> store;  // reads the photographs; null if they are in memory

  std::vector<Eigen::Vector3d> Centers() const;  // the views', world frame
  void MakeMesh();                               // from these
  std::string ViewpointsInWords() const;         // for people, in a line: what they span, and what follows
};

enum class PhotographForm {
  kAuto,       // kLinear if 8 bits would lose light or a photograph has a mask, otherwise kEightBits
  kEightBits,  // the photographs of images/, even if masters hold more; masks are ignored
  kLinear,     // half floats in linear light, of masters if they exist
};

// If the longest exposure is more than this many times the shortest, PhotographForm::kAuto reads linear
// light, since shadows of 8 bits would be brightened; and clipped pixels of exposures that are so much longer
// than the shortest have hardly any weight. Guessed: a third of a stop.
inline constexpr float kMostExposureRatio = 1.26f;

struct SceneOptions {
  std::optional<Subject> subject = {};              // otherwise the light field's, or from the optical axes
  std::optional<Eigen::Vector3d> up_in_world = {};  // unit; otherwise LightField::UpInWorld()
  int size_limit_px = 0;                            // PhotographStoreOptions::size_limit_px
  double memory_limit_mb = 2048;                    // PhotographStoreOptions::memory_limit_mb
  std::vector<int> leave_out = {};                  // indices of views to exclude
  PhotographForm form = PhotographForm::kAuto;
  bool mesh_in_plane = false;  // ViewpointMeshOptions::in_plane
  bool of_masks = false;       // use the views' masks as photographs: light 1 inside, 0 outside
  bool masks_clipped = true;   // false: clipped pixels count as light like others, for comparison
};

// Returns whether there is a given subject, or the light field's, or a point where the optical axes meet.
bool HasSubject(const LightField& light_field, const std::optional<Subject>& given = std::nullopt);

// Returns that subject, else MiddleOfPoints(), at the height of views that look outwards from there. Throws
// Refusal that asks for a subject if there is none.
Subject SubjectOf(const LightField& light_field, const std::optional<Subject>& given = std::nullopt);

// Reads no photograph yet, except to estimate a view's unknown exposure (exposure_scales.h). The proxy is the
// plane through the subject that faces the virtual camera. Without a subject the viewpoints have no mesh, and
// lumigraph weights are used. Throws Error for an empty light field, and as SubjectOf() does.
std::shared_ptr<const RenderScene> LoadScene(const LightField& light_field, const SceneOptions& options);

// Returns the scene without these views (indices): it shares the photographs and gets a mesh of its own.
std::shared_ptr<const RenderScene> Without(const RenderScene& scene, const std::vector<int>& left_out);

// Returns the scene over another proxy. Shadow maps are made when they are first needed.
std::shared_ptr<const RenderScene> WithProxy(const RenderScene& scene, std::shared_ptr<const Proxy> proxy);

// Returns the pyramid level at which a view is read: the one nearest to one texel per output pixel at the
// subject's centre O, for the view's centre C and the virtual camera's centre V,
//   round(log2((focal_view / |O - C|) / (focal_out / |O - V|))), limited to the pyramid.
// Without a subject all distances are taken to be equal.
int PyramidLevel(const SceneView& view, const RenderScene& scene, const Eigen::Vector3d& virtual_center,
                 double output_focal_px);

// Returns the colour of a view in pictures of the blending field, linear B G R.
cv::Vec3f ViewColor(int view_id);

}  // namespace ulf::render
