// The simulated studio photographed where a hand would have recorded views, and from places between them, for
// charts of rendering: no noise, no blur, poses exact, so that what is measured is the sampling, the geometry
// and the blending.
#pragma once

#include <memory>
#include <vector>

#include "render/renderer/renderer.h"
#include "render/scene/scene.h"
#include "tests/measure/cpu_time.h"
#include "tests/support/floors.h"

namespace ulf::test {

struct StudioOptions {
  std::uint64_t seed = 1;  // of the scene and of the hand
  double threshold_px = 12;
  int width = 480, height = 320;
};

// Views of a cap of 60 x 40 degrees, recorded as a capture decides (coverage map, `threshold_px`) from a hand
// that scans in rows as far apart as that allows, until 95 % are covered. The proxy is the plane.
std::shared_ptr<const RenderScene> StudioScene(const StudioOptions& options);

// Photographs from where another hand holds the camera within that cap: the same for every threshold.
std::vector<SceneView> StudioTruth(const StudioOptions& options, int count);

// What a hand sees on its way there, thirty times a second.
struct TruePicture {
  CameraModel camera;
  Rigid3 cam_from_world;
  cv::Mat levels;  // CV_32FC3, display levels of 255, B G R
};
std::vector<TruePicture> StudioPath(const StudioOptions& options, int count);

// Points on the surfaces that those photographs show, off by half a pixel of parallax or so (0.2 % of the
// depth): as tracked ones are.
std::vector<ScenePoint> StudioPoints(const StudioOptions& options, int count);

struct RenderedQuality {
  double psnr_db = 0, psnr_disc_db = 0;  // means over the pictures; the second in the subject's silhouette
  double ssim = 0;
  double cpu_ms = 0;  // of a picture once its photographs are there, median
};
RenderedQuality MeasureRendering(Renderer& renderer, const std::vector<SceneView>& truth);
// TemporalError::FrameRms() on the path.
double TemporalErrorAlong(Renderer& renderer, const std::vector<TruePicture>& path);

}  // namespace ulf::test
