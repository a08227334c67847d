// Compares blending fields and proxies along a camera path whose true pictures are known: by temporal_error.h
// and step_error.h, and with the picture of thesis figure 5-4, one column of the image over time.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "render/fields/field_options.h"
#include "render/output/camera_path.h"
#include "render/renderer/renderer.h"
#include "tests/charts/temporal/truth.h"

namespace ulf::test {

struct TemporalOptions {
  render::CameraPath path;  // with a camera for each pose, all with one image size
  std::vector<render::FieldOptions> fields = {};
  std::vector<std::shared_ptr<const render::Proxy>> proxies = {};  // each is combined with each field
  render::RendererKind renderer = render::RendererKind::kGl;
  double gpu_memory_mb = 0;  // render::RenderOptions::gpu_memory_mb
};

struct TemporalScore {
  render::FieldOptions asked,
      used;  // they differ where the viewpoints do not allow the field that was asked for
  std::string proxy;
  // Levels of 255: on the full image, and in the silhouette of the subject's sphere.
  double temporal_error = 0, temporal_error_disc = 0;
  // The same by StepError; none where the truth has no depth.
  std::optional<double> step_error = {}, step_error_disc = {};
  double psnr_db = 0;  // of all pictures together
  double ms_per_frame = 0;
  std::vector<double> over_time = {};  // temporal error at each picture except the first and the last
  cv::Mat strip = {};                  // 8-bit sRGB: column t is the middle column of picture t
};

struct TemporalSummary {
  int views = 0, frames = 0, width = 0, height = 0;
  std::string renderer = {};
  cv::Mat true_strip = {};
  std::vector<TemporalScore> results = {};
};

// Throws Error for a path of fewer than three pictures, and where the true pictures do not fit into memory.
TemporalSummary EvaluateOverTime(const std::shared_ptr<const render::RenderScene>& scene,
                                 const TemporalOptions& options, TruthSource& truth,
                                 Progress* progress = nullptr);

// All strips with their names, the true one on top, with what made them.
cv::Mat StripPicture(const TemporalSummary& summary, const std::string& made_by);

// Writes a chart of the temporal error over time (gnuplot; .png, .svg or .pdf), with what made it below.
void DrawTemporalChart(const TemporalSummary& summary, const std::string& path, const std::string& made_by);

}  // namespace ulf::test
