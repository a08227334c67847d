// Rendering a light field: photographs in, a picture from anywhere out. One interface, two renderers: the
// plain reference on the CPU, which is the truth, and OpenGL without a window, which is fast and must agree
// with it.
//
//   auto scene = LoadScene(ReadLightField(dir), {});
//   auto renderer = MakeRenderer(scene, {});
//   const Rendering picture = renderer->Render(camera, cam_from_world);
//   cv::imwrite("picture.png", Srgb8FromLinear(picture.linear));
//
// Per pixel: the proxy gives the point P, the blending field the views' weights; a view that does not see P
// loses its weight, feathered over the last 3 % of its image; the rest is renormalised and blended in linear
// light. Where less than half of the weight is left, lumigraph weights of the nearest views that see P fill
// in, by as much as it is less: all of it where nothing is left (counted), and no step on the way there.
// Where no view sees P the nearest that has it in its image at least; else the pixel is empty (black,
// counted).
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/image/image.h"
#include "render/fields/aperture.h"
#include "render/fields/blending_field.h"
#include "render/proxy/proxy.h"
#include "render/scene/scene.h"

namespace ulf::render {

enum class RendererKind { kGl, kReference };

struct RenderOptions {
  FieldOptions field = {};
  RendererKind renderer = RendererKind::kGl;
  bool fill = true;         // where the field's own views hardly see the point, others do
  bool show_field = false;  // a colour for each view in place of its photograph (thesis, figure 5-1)
  bool depth = false;       // Rendering::depth
  bool weights = false;     // Rendering::weights; takes the reference's time in either renderer
  // Of photographs in graphics memory; 0: what the driver says is free, or 2048. Where a picture needs more
  // it is drawn in several passes.
  double gpu_memory_mb = 0;
  // Waits for photographs that are not read yet. If not, a picture is drawn from what is there, coarser
  // levels and fewer views, and is better the next time, until loading() says that nothing is missing.
  bool complete = true;
  std::optional<Aperture> aperture = {};  // SetAperture()
};

// How much of each pixel's light a view gives.
struct ViewWeights {
  int view_id = 0;
  cv::Mat weight;  // CV_16F
};

struct Rendering {
  cv::Mat linear;  // CV_32FC3, B G R, linear light of the median exposure
  // CV_32F, 0 to 1: the weight of views that really see the point; times 0.25 outside the hull of the
  // viewpoints, less in wide triangles; 0 where filled or empty.
  cv::Mat confidence;
  cv::Mat drawn;  // CV_8U, 255 where any view gives light
  cv::Mat depth;  // CV_32F along the optical axis, the proxy's; empty unless asked for
  // Of the views that have any, in order of id; they sum to one where there is light. Empty unless asked for.
  std::vector<ViewWeights> weights;
  long filled_px = 0;  // nothing of the field covered these; other views did
  long empty_px = 0;   // no view sees these
  double ms = 0;       // drawing alone, without reading the picture back
};

class Renderer {
 public:
  virtual ~Renderer() = default;
  // The camera must be free of distortion (CameraModel::WithoutDistortion).
  virtual Rendering Render(const CameraModel& camera, const Rigid3& cam_from_world) = 0;
  // Another field over the same photographs, which stay where they are.
  virtual void SetField(const FieldOptions& field) = 0;
  // The same photographs and field over another proxy.
  virtual void SetProxy(std::shared_ptr<const Proxy> proxy) = 0;
  // A lens that is wide open: the focal plane is the proxy until there is none again, which brings the
  // scene's back. Fields without a mesh of viewpoints have no rings to widen: of them it changes the proxy
  // alone.
  virtual void SetAperture(const std::optional<Aperture>& aperture) = 0;
  // Where a picture is going to be wanted next: what it needs is read ahead.
  virtual void Prefetch(const CameraModel& camera, const Rigid3& cam_from_world);
  // Whether the last picture lacked photographs that are still being read (RenderOptions::complete).
  virtual bool loading() const { return false; }
  // What is really used: FieldThatServes() of what was asked.
  virtual FieldOptions field() const = 0;
  virtual std::string Name() const = 0;  // "reference", or "gl" with the device's name
  // With the proxy of its own, whatever the aperture.
  virtual const RenderScene& scene() const = 0;
};

// kGl without any usable OpenGL 4.5 is an Error that says what was tried and names --renderer reference.
std::unique_ptr<Renderer> MakeRenderer(std::shared_ptr<const RenderScene> scene,
                                       const RenderOptions& options);

// Weights whose sum is below this count as none.
inline constexpr double kLeastWeight = 1e-4;

// Below which sum of weights pixels are filled up, and by how many views; 0: not at all.
struct Filling {
  double whole = kLeastWeight;
  int views = 0;
};
// The nearest view is meant to be one, and a wide aperture's blur is what its views make together: these are
// filled where there is nothing else.
Filling FillingOf(const RenderOptions& options);

void RequireUndistorted(const CameraModel& camera);

}  // namespace ulf::render
