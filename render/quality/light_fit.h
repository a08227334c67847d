// Estimates the brightness of each photograph relative to the others, and the vignetting (fall-off) of the
// lens, for all views together: imported sets do not record exposure, and phones vary it.
//
// Points of the proxy's surface that several views see should send the same light to all of them. The model
//
//   log light(view, channel) = log light(point, channel) + gain(view, channel) + log(1 + a r^2 + b r^4)
//
// is solved for the gains, whose mean over the views is 0 in each channel, and for a and b of each camera (r:
// LightCorrection). Highlights, moving things and errors of the proxy are outliers: weights are those of the
// absolute deviation first, then Geman and McClure's. Held-out points decide how much of the model is needed:
// nothing, gains, or gains and fall-off.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/base/model_choice.h"
#include "render/quality/light_samples.h"
#include "render/quality/light_solution.h"
#include "render/scene/scene.h"

namespace ulf::render {

struct LightFit {
  LightModel model = LightModel::kAsRecorded;
  std::map<int, cv::Vec3f> gains = {};  // factors B G R, by SceneView::id; empty for kAsRecorded
  std::vector<std::pair<CameraModel, Eigen::Vector2f>> falloffs = {};  // a and b of each camera
  std::size_t points = 0;                                              // number of compared points
  double stops = 0;  // between the darkest and the brightest view, in the channel with the largest range
  double corner_stops = 0;  // darkening of the corners, the largest of all cameras
  ModelChoice explained = {};

  std::string Words() const;  // describes the result in a clause
};

// `scene` has a proxy with triangles and its shadow maps (WithProxy). A proxy without triangles, or one on
// which views have no points in common, leaves everything as recorded.
LightFit FitLight(const RenderScene& scene);

// Returns the scene with the corrections. A view that was not fitted, such as a left-out one, gets the
// fall-off of its camera if a fitted view has the same one, and a gain of 1, because its exposure is unknown.
// But an automatic exposure depends on what the picture shows: if the gains of fitted views can be predicted
// from their neighbours', its gain is predicted so, too.
std::shared_ptr<const RenderScene> WithLight(const RenderScene& scene, const LightFit& fit);

}  // namespace ulf::render
