// Evaluates a field: every k-th view is left out, rendered from the others, and compared with its photograph.
//
// The pinhole rendering is compared with the undistorted photograph at its own exposure, in 8-bit sRGB, on
// the full image and inside the silhouette of the subject's sphere (the disc). Pixels that other views fill
// count like all others; only pixels where the undistorted photograph is empty are left out. Views on the rim
// of the hull of all viewpoints, which must be extrapolated, are reported separately.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "render/fields/field_options.h"
#include "render/quality/quality.h"
#include "render/renderer/renderer.h"

namespace ulf::render {

// A picture of a left-out view beside its photograph, both in 8-bit sRGB. The images do not outlive the call.
struct ComparedPicture {
  int view_id = 0;
  const cv::Mat& rendered;
  const cv::Mat& photograph;
  const cv::Mat& valid;       // CV_8U, 0 where the photograph has no light
  const cv::Mat& depth;       // CV_32F, the proxy's
  const cv::Mat& confidence;  // CV_32F
};

struct EvaluateOptions {
  int every = 8;
  std::vector<int> left_out = {};         // indices of views, ascending; empty: every `every`-th
  std::vector<FieldOptions> fields = {};  // at least one
  // Each proxy is combined with each field; empty means the scene's own proxy. Their geometry should not come
  // from the left-out views.
  std::vector<std::shared_ptr<const Proxy>> proxies = {};
  RendererKind renderer = RendererKind::kGl;
  double gpu_memory_mb = 0;  // RenderOptions::gpu_memory_mb
  int window_px = 0;         // size limit of the evaluated middle of each picture; 0: all of it
  std::function<void(const ComparedPicture&)> look = {};  // called with each picture
  // Called before each picture, and at the end, with the share that is done, 0 to 1; what it throws ends the
  // evaluation.
  std::function<void(double share)> between = {};
};

struct ViewScore {
  int view_id = 0;
  bool on_rim = false;
  Quality frame = {}, disc = {};
  long filled_px = 0, empty_px = 0;
  double ms = 0;
};

struct MeanScore {
  int views = 0;
  double psnr_db = 0, ssim = 0, psnr_disc_db = 0, ssim_disc = 0;  // means over the views
};

struct FieldScore {
  FieldOptions asked, used;  // they differ if the viewpoints do not allow the asked field
  std::string proxy;
  MeanScore inside = {}, rim = {}, all = {};
  double ms_per_frame = 0;  // median
  long filled_px = 0, empty_px = 0;
  std::vector<ViewScore> views = {};

  // Returns the mean of the views inside the hull; of all views if none is inside.
  const MeanScore& Main() const { return inside.views > 0 ? inside : all; }
};

struct EvaluateSummary {
  int views = 0;              // number of all views
  int held_out = 0;           // number of left-out views
  int width = 0, height = 0;  // px of the first left-out view as rendered
  std::string renderer = {};
  std::string viewpoints = {};  // ViewpointMesh::Description() of the used views
  std::vector<FieldScore> results = {};
};

// `scene` has all views. Throws Refusal for an `every` below 2, Error for fewer than two views, and as
// MakeRenderer() does. Results are in the order of proxies, and of the fields for each.
EvaluateSummary Evaluate(const RenderScene& scene, const EvaluateOptions& options,
                         Progress* progress = nullptr);

// The photograph resampled to a pinhole camera (CameraModel::WithoutDistortion, same size).
struct UndistortedPhotograph {
  cv::Mat srgb8;
  cv::Mat valid;  // CV_8U, 0 where the photograph has no light for a pixel
};
UndistortedPhotograph Undistort(const SceneView& view);

// Returns CV_8U, 255 where the ray of a pixel meets the subject's sphere.
cv::Mat SubjectDisc(const CameraModel& camera, const Rigid3& cam_from_world, const Subject& subject);

}  // namespace ulf::render
