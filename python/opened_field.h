// A light field that is open in Python: what needs more than its files is made when it is first needed.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/mutex.h"
#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"
#include "core/light_field/light_field.h"
#include "coverage/bound/coverage_map.h"
#include "render/proxy/proxy.h"
#include "render/renderer/renderer.h"
#include "render/scene/scene.h"

namespace ulf::python {

// A left-out view beside its undistorted photograph, both in 8-bit sRGB, B G R.
struct LeftOutPicture {
  int view_id = 0;
  cv::Mat rendered, photograph, valid;  // `valid` is CV_8U, 0 where the photograph has no light
  double psnr_db = 0, ssim = 0;         // as of render/quality/quality.h, of valid pixels
};

// A depth map, CV_32F: along the optical axis in world units, NaN where it is unknown.
struct SeenDepth {
  cv::Mat depth;
  CameraModel camera;  // of its pixels, without distortion
};

// Several threads may call it; they take turns.
class OpenedField {
 public:
  explicit OpenedField(LightField light_field) : light_field_(std::move(light_field)) {}

  const LightField& light_field() const { return light_field_; }

  // Returns CV_32FC3, B G R, linear light of the median exposure, over the most detailed geometry that the
  // light field has. Throws Error for a camera with distortion and for an empty light field.
  cv::Mat Render(const CameraModel& camera, const Rigid3& cam_from_world);

  // Renders views (ids) from all others and compares them with their photographs (render/quality/evaluate.h).
  // `proxy` is "auto", the light field's own, or a name of render/proxy/proxy_choice.h. Throws Refusal for an
  // unknown view, and unless some are left out and some stay.
  std::vector<LeftOutPicture> LeftOut(const std::vector<int>& ids, const std::string& proxy);

  // Returns the view's depth map, or else the mesh as the view sees it. Throws Error if there is neither.
  SeenDepth DepthOf(const View& view);

 private:
  std::shared_ptr<const render::RenderScene> Scene() ULF_REQUIRES(mutex_);
  std::shared_ptr<const render::Proxy> Geometry() ULF_REQUIRES(mutex_);
  render::RendererKind Kind() ULF_REQUIRES(mutex_);
  std::unique_ptr<render::Renderer> MakeOwnRenderer() ULF_REQUIRES(mutex_);

  const LightField light_field_;
  Mutex mutex_;
  std::shared_ptr<const render::RenderScene> scene_ ULF_GUARDED_BY(mutex_);
  std::shared_ptr<const render::Proxy> proxy_ ULF_GUARDED_BY(mutex_);
  std::optional<render::RendererKind> kind_ ULF_GUARDED_BY(mutex_);
  std::unique_ptr<render::Renderer> renderer_ ULF_GUARDED_BY(mutex_);
};

// Tells which part of a cap views cover by the bound.
struct CapCoverage {
  coverage::CoverageMap map;
  std::vector<coverage::CoverageMap::CellView> cells;
  std::vector<int> view_ids;  // by the index of a view
};

// `cap_deg`: azimuth and elevation; none: the capture's goal, or the whole sphere. `threshold_px`; none: the
// capture's, or 7. Throws Refusal for values out of range, and without a subject.
CapCoverage CoverageOfCap(const LightField& light_field,
                          const std::optional<std::pair<double, double>>& cap_deg,
                          const std::optional<double>& threshold_px);

}  // namespace ulf::python
