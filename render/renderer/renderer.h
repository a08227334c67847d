// Renders a light field from any viewpoint. One interface has two implementations: the reference renderer on
// the processor, which defines the result, and OpenGL without a window (render/gl/gl_renderer.h), which is
// fast and must agree with it.
//
//   auto scene = LoadScene(ReadLightField(dir), {});  // over a plane
//   scene = WithProxy(*scene, OwnProxy(DefaultProxies(dir).front(), scene->subject, dir));  // proxy_choice.h
//   auto renderer = MakeRenderer(scene, {});  // render/gl/gl_renderer.h
//   const Rendering picture = renderer->Render(camera, cam_from_world);
//   WritePictureFile("picture.png", Srgb8FromLinear(picture.linear));
//
// For each pixel the proxy gives the point P, and the blending field gives the weights of the views. A view
// that does not see P loses its weight, gradually over kFeatherShare at the edge of its image. The remaining
// weights are normalised and the views blended in linear light. If less than half of the weight remains,
// lumigraph weights of the nearest views that see P fill up the rest, so that there is no visible edge; if
// nothing remains they fill the whole pixel, which is counted. If no view sees P, the nearest view that has P
// in its image is used; otherwise the pixel is empty (black, counted).
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/image/image.h"
#include "render/fields/aperture.h"
#include "render/fields/field_options.h"
#include "render/proxy/proxy.h"
#include "render/scene/scene.h"

namespace ulf::render {

enum class RendererKind { kGl, kReference };

struct RenderOptions {
  FieldOptions field = {};
  RendererKind renderer = RendererKind::kGl;
  bool fill = true;         // other views fill pixels that the field's own views hardly see
  bool show_field = false;  // show a colour for each view as its photograph (thesis, figure 5-1)
  bool depth = false;       // fill Rendering::depth
  bool weights = false;     // fill Rendering::weights, which takes as long as the reference renderer
  // Memory for photographs on the GPU; 0: GlPhotographs::LimitBytes(). Pictures that need more take several
  // passes.
  double gpu_memory_mb = 0;
  // Wait for photographs that are not read yet. Otherwise a picture is drawn from the loaded ones (coarser
  // levels, fewer views), and improves from picture to picture, until loading() returns false.
  bool complete = true;
  std::optional<Aperture> aperture = {};  // SetAperture()
};

// A view's weight in each pixel.
struct ViewWeights {
  int view_id = 0;
  cv::Mat weight;  // CV_16F
};

struct Rendering {
  cv::Mat linear;  // CV_32FC3, B G R, linear light of the median exposure
  // CV_32F, 0 to 1: the weight of the field's own views that see the point, times FieldSample::confidence; 0
  // in filled and empty pixels.
  cv::Mat confidence;
  cv::Mat drawn;  // CV_8U, 255 where any view gives light
  cv::Mat alpha;  // CV_32F, the subject's share of a pixel (CutOutRenderer); empty: 1
  cv::Mat depth;  // CV_32F, the proxy's depth along the optical axis, world units; empty unless requested
  // The weights of the views that give light to any pixel, in order of id; they sum to one where there is
  // light. Empty unless requested.
  std::vector<ViewWeights> weights;
  long filled_px = 0;  // number of pixels that none of the field's own views sees, filled by other views
  long empty_px = 0;   // number of pixels to which no view gives light
  double ms = 0;       // time to draw, without reading the picture back
};

class Renderer {
 public:
  virtual ~Renderer() = default;
  // The camera must have no distortion (CameraModel::WithoutDistortion); throws Error otherwise.
  virtual Rendering Render(const CameraModel& camera, const Rigid3& cam_from_world) = 0;
  // Changes the field; the photographs stay in memory.
  virtual void SetField(const FieldOptions& field) = 0;
  // Changes the proxy; the photographs stay in memory.
  virtual void SetProxy(std::shared_ptr<const Proxy> proxy) = 0;
  // With an aperture the focal plane replaces the scene's proxy; without one the scene's proxy is used again.
  // Only fields on the viewpoint mesh blur what is off this plane (aperture_field.h).
  virtual void SetAperture(const std::optional<Aperture>& aperture) = 0;
  // Starts to read the photographs of the expected next picture.
  virtual void Prefetch(const CameraModel& /*camera*/, const Rigid3& /*cam_from_world*/) {}
  // Returns whether the last picture lacked photographs that are still being read (RenderOptions::complete).
  virtual bool loading() const { return false; }
  // Returns the field in use: FieldThatServes() of the one that was set.
  virtual FieldOptions field() const = 0;
  virtual std::string Name() const = 0;  // "reference", or "gl" with the device's name
  // Returns the scene with its own proxy, even while there is an aperture.
  virtual const RenderScene& scene() const = 0;
};

// If the weights of the views that see a pixel's point sum to less, none counts as seeing it. Guessed.
inline constexpr double kLeastWeight = 1e-4;

// Says how other views fill pixels that the field's own views hardly see.
struct Filling {
  double whole = kLeastWeight;  // below this sum of weights a pixel is filled up
  int views = 0;                // number of filling views; 0: pixels are not filled
};
// Other views fill up a pixel below this sum of its own views' weights. Guessed; filling up gradually brought
// 1 dB on the data set fox_half, together with the filled holes of the proxy.
inline constexpr double kWholeWeight = 0.5;
// Number of views that fill a pixel, by lumigraph weights. Guessed.
inline constexpr int kFillingViews = 4;
// The nearest-view field, which must remain a single view, and a wide aperture, whose blur consists of all
// its views, are filled only at pixels that no own view sees.
inline Filling FillingOf(const RenderOptions& options) {
  if (options.field.kind == FieldKind::kNearest) return {kLeastWeight, 1};
  if (!options.fill) return {};
  return {options.aperture ? kLeastWeight : kWholeWeight, kFillingViews};
}

// Throws Error for a camera with distortion or with values out of range.
inline void RequireUndistorted(const CameraModel& camera) {
  camera.Validate("the virtual camera");
  if (camera.distortion != Distortion::kNone)
    throw Error("the virtual camera has lens distortion; render with CameraModel::WithoutDistortion()");
}

}  // namespace ulf::render
