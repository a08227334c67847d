#include "tests/charts/temporal/temporal_evaluation.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <opencv2/imgproc.hpp>

#include "core/base/at.h"
#include "core/base/available_memory.h"
#include "core/base/error.h"
#include "core/base/quantile.h"
#include "render/fields/field_options.h"
#include "render/gl/gl_renderer.h"
#include "render/quality/evaluate.h"
#include "tests/charts/temporal/step_error.h"
#include "tests/charts/temporal/temporal_error.h"
#include "tests/measure/chart.h"
#include "tests/support/floors.h"

namespace ulf::test {
namespace {

// Each true picture is compared with many renderings: keep them all as display levels in 16 bits.
constexpr double kSixteenBits = 65535.0 / 255;

struct TrueFrame {
  cv::Mat levels16;  // CV_16UC3
  cv::Mat disc;
  TrueDepth depth;  // empty where it is not known

  cv::Mat Levels() const {
    cv::Mat levels;
    levels16.convertTo(levels, CV_32F, 1 / kSixteenBits);
    return levels;
  }
};

cv::Mat Column(const cv::Mat& levels) {
  cv::Mat column;
  levels.col(levels.cols / 2).convertTo(column, CV_8U);
  return column;
}

std::vector<TrueFrame> TrueFrames(const RenderScene& scene, const CameraPath& path, TruthSource& truth,
                                  Progress* progress) {
  const int frames = static_cast<int>(path.cam_from_world.size());
  const CameraModel& first = path.cameras.front();
  constexpr double kBytesPerPixel = 11;  // TrueFrame
  constexpr double kMostOfMemory = 0.8;  // the rest is for rendering
  const double bytes = kBytesPerPixel * first.width * first.height * frames;
  if (bytes > kMostOfMemory * static_cast<double>(AvailableMemory()))
    throw Error("{} true pictures of {}x{} do not fit into memory; give fewer --frames or a smaller --width",
                frames, first.width, first.height);
  std::vector<TrueFrame> truths;
  for (int i = 0; i < frames; ++i) {
    const CameraModel& camera = path.cameras[At(i)];
    const Rigid3& pose = path.cam_from_world[At(i)];
    TrueFrame& frame = truths.emplace_back();
    DisplayLevels(truth.Picture(i, camera, pose)).convertTo(frame.levels16, CV_16U, kSixteenBits);
    frame.disc = SubjectDisc(camera, pose, scene.subject);
    frame.depth = {camera, pose, truth.Depth(camera, pose)};
    if (progress) progress->Show(static_cast<double>(i + 1) / frames, "true pictures");
  }
  return truths;
}

std::string NameOf(const TemporalScore& score) { return FieldText(score.used) + ", " + score.proxy; }

}  // namespace

TemporalSummary EvaluateOverTime(const std::shared_ptr<const RenderScene>& scene,
                                 const TemporalOptions& options, TruthSource& truth, Progress* progress) {
  const CameraPath& path = options.path;
  const int frames = static_cast<int>(path.cam_from_world.size());
  if (frames < 3) throw Error("a second difference needs three pictures; the path has {}", frames);
  truth.RequireSameWorld(*scene);
  TemporalSummary summary{.views = static_cast<int>(scene->views.size()),
                          .frames = frames,
                          .width = path.cameras.front().width,
                          .height = path.cameras.front().height};
  const std::vector<TrueFrame> truths = TrueFrames(*scene, path, truth, progress);
  summary.true_strip.create(summary.height, frames, CV_8UC3);
  for (int i = 0; i < frames; ++i) Column(truths[At(i)].Levels()).copyTo(summary.true_strip.col(i));

  const auto renderer =
      MakeRenderer(scene, {.renderer = options.renderer, .gpu_memory_mb = options.gpu_memory_mb});
  summary.renderer = renderer->Name();
  const std::size_t all = options.proxies.size() * options.fields.size() * At(frames);
  std::size_t done = 0;
  for (const auto& proxy : options.proxies) {
    renderer->SetProxy(proxy);
    for (const FieldOptions& field : options.fields) {
      renderer->SetField(field);
      renderer->Render(path.cameras.front(), path.cam_from_world.front());  // drivers compile shaders
      TemporalScore score{.asked = field, .used = renderer->field(), .proxy = proxy->Name()};
      score.strip.create(summary.height, frames, CV_8UC3);
      TemporalError error;
      StepError steps;
      const bool has_depth = !truths.front().depth.depth.empty();
      std::vector<double> times;
      for (int i = 0; i < frames; ++i) {
        if (i + 1 < frames) renderer->Prefetch(path.cameras[At(i + 1)], path.cam_from_world[At(i + 1)]);
        const Rendering picture = renderer->Render(path.cameras[At(i)], path.cam_from_world[At(i)]);
        const cv::Mat levels = DisplayLevels(picture.linear);
        const TrueFrame& truth_here = truths[At(i)];
        error.Add(levels, truth_here.Levels(), truth_here.disc);
        if (has_depth) steps.Add(levels, truth_here.Levels(), truth_here.depth, truth_here.disc);
        Column(levels).copyTo(score.strip.col(i));
        times.push_back(picture.ms);
        if (progress)
          progress->Show(static_cast<double>(++done) / static_cast<double>(all),
                         proxy->Name() + ", " + FieldName(field.kind));
      }
      score.ms_per_frame = Median(times);
      score.temporal_error = error.FrameRms();
      score.temporal_error_disc = error.DiscRms();
      if (has_depth) {
        score.step_error = steps.FrameRms();
        score.step_error_disc = steps.DiscRms();
      }
      score.psnr_db = error.PsnrDb();
      score.over_time = error.over_time();
      summary.results.push_back(std::move(score));
    }
  }
  return summary;
}

cv::Mat StripPicture(const TemporalSummary& summary, const std::string& made_by) {
  constexpr int kLabelHeight = 22, kLeastWidth = 480;
  // The middle half of the column, where the subject is.
  const cv::Range rows(summary.height / 4, summary.height - summary.height / 4);
  const int scale = std::max(1, (kLeastWidth + summary.frames - 1) / summary.frames);
  std::vector<std::pair<std::string, cv::Mat>> strips{{"truth, " + made_by, summary.true_strip}};
  for (const TemporalScore& score : summary.results)
    strips.emplace_back(fmt::format("{}: temporal error {:.2f}", NameOf(score), score.temporal_error) +
                            (score.step_error ? fmt::format(", step error {:.2f}", *score.step_error) : ""),
                        score.strip);
  const int step = kLabelHeight + rows.size();
  cv::Mat picture(step * static_cast<int>(strips.size()), scale * summary.frames, CV_8UC3,
                  cv::Scalar::all(250));
  for (std::size_t i = 0; i < strips.size(); ++i) {
    const int top = step * static_cast<int>(i);
    cv::putText(picture, strips[i].first, {6, top + kLabelHeight - 7}, cv::FONT_HERSHEY_DUPLEX, 0.45,
                cv::Scalar::all(40), 1, cv::LINE_AA);
    cv::Mat wide;
    cv::resize(strips[i].second.rowRange(rows), wide, {picture.cols, rows.size()}, 0, 0, cv::INTER_NEAREST);
    wide.copyTo(picture.rowRange(top + kLabelHeight, top + step));
  }
  return picture;
}

void DrawTemporalChart(const TemporalSummary& summary, const std::string& path, const std::string& made_by) {
  ChartPanel panel{.title = "second difference of the error over time",
                   .cost = {"picture"},
                   .error = FromZero({"RMS, levels of 255"}),
                   .compared = false};
  for (const TemporalScore& score : summary.results)
    for (std::size_t t = 0; t < score.over_time.size(); ++t)
      panel.points.push_back({NameOf(score), "", Spread::Exactly(static_cast<double>(t + 1)),
                              Spread::Exactly(score.over_time[t])});
  DrawChartFile(path, {.title = "How restless pictures are", .caption = made_by, .panels = {panel}});
}

}  // namespace ulf::test
