#include "render/quality/evaluate.h"

#include <algorithm>
#include <cmath>

#include "core/base/at.h"
#include "core/base/error.h"
#include "core/base/quantile.h"
#include "core/geometry/pinhole.h"
#include "render/gl/gl_renderer.h"
#include "render/output/picture_files.h"
#include "render/renderer/reference_renderer.h"

namespace ulf::render {
namespace {

// Returns views whose vertex lies on the rim, or that have no vertex.
std::vector<bool> OnRim(const RenderScene& scene) {
  std::vector<bool> rim(scene.views.size(), scene.mesh.span == Span::kSurface);
  for (std::size_t v = 0; v < scene.mesh.vertices.size(); ++v)
    for (const int view : scene.mesh.vertices[v].views)
      if (!scene.mesh.OnBoundary(static_cast<int>(v))) rim[At(view)] = false;
  return rim;
}

MeanScore MeanOf(const std::vector<ViewScore>& scores, bool inside, bool rim) {
  MeanScore mean;
  for (const ViewScore& score : scores) {
    if (!(score.on_rim ? rim : inside)) continue;
    ++mean.views;
    mean.psnr_db += score.frame.psnr_db;
    mean.ssim += score.frame.ssim;
    mean.psnr_disc_db += score.disc.psnr_db;
    mean.ssim_disc += score.disc.ssim;
  }
  if (mean.views > 0)
    for (double* value : {&mean.psnr_db, &mean.ssim, &mean.psnr_disc_db, &mean.ssim_disc})
      *value /= mean.views;
  return mean;
}

struct Truth {
  const SceneView* view;
  CameraModel camera;
  UndistortedPhotograph photograph;
  cv::Mat disc;
  bool on_rim;
};

// Keeps the middle of the picture.
void Crop(Truth& truth, int window_px) {
  const cv::Size size(std::min(window_px, truth.camera.width), std::min(window_px, truth.camera.height));
  const cv::Rect window({(truth.camera.width - size.width) / 2, (truth.camera.height - size.height) / 2},
                        size);
  truth.camera.cx -= window.x;
  truth.camera.cy -= window.y;
  truth.camera.width = size.width;
  truth.camera.height = size.height;
  truth.photograph = {truth.photograph.srgb8(window).clone(), truth.photograph.valid(window).clone()};
}

// Converts light to that which the view's camera would have recorded.
cv::Mat AsRecorded(const SceneView& view, const CameraModel& pinhole, const cv::Mat& linear) {
  if (view.correction == LightCorrection{}) return linear / view.scale + cv::Scalar::all(view.black);
  cv::Mat recorded(linear.size(), CV_32FC3);
  for (int y = 0; y < linear.rows; ++y)
    for (int x = 0; x < linear.cols; ++x) {
      const auto img = view.camera.ImgFromCam(PinholeRay(pinhole, x, y));
      const cv::Vec3f scale = view.ScaleAt(img.value_or(Eigen::Vector2d(x + 0.5, y + 0.5)));
      for (int c = 0; c < 3; ++c)
        recorded.at<cv::Vec3f>(y, x)[c] = linear.at<cv::Vec3f>(y, x)[c] / scale[c] + view.black;
    }
  return recorded;
}

ViewScore Score(Renderer& renderer, const Truth& truth,
                const std::function<void(const ComparedPicture&)>& look) {
  const Rendering picture = renderer.Render(truth.camera, truth.view->cam_from_world);
  // Compares at the photograph's own exposure.
  const cv::Mat rendered = Srgb8FromLinear(
      AsRecorded(*truth.view, truth.camera, WithNarrowGapsClosed(picture.linear, picture.drawn)));
  ViewScore score{.view_id = truth.view->id, .on_rim = truth.on_rim};
  score.frame = CompareImages(rendered, truth.photograph.srgb8, truth.photograph.valid);
  score.disc = CompareImages(rendered, truth.photograph.srgb8, truth.disc);
  score.filled_px = picture.filled_px;
  score.empty_px = picture.empty_px;
  score.ms = picture.ms;
  if (look)
    look({truth.view->id, rendered, truth.photograph.srgb8, truth.photograph.valid, picture.depth,
          picture.confidence});
  return score;
}

}  // namespace

UndistortedPhotograph Undistort(const SceneView& view) {
  UndistortedPhotograph result{view.Srgb8(), cv::Mat(view.photograph->size(), CV_8U, cv::Scalar(255))};
  if (view.camera.distortion == Distortion::kNone && !view.photograph->linear()) return result;
  const cv::Mat pixels = view.photograph->Level(0);
  const CameraModel pinhole = view.camera.WithoutDistortion();
  cv::Mat linear = cv::Mat::zeros(pinhole.height, pinhole.width, CV_32FC3);
  for (int y = 0; y < pinhole.height; ++y)
    for (int x = 0; x < pinhole.width; ++x) {
      const auto img = view.camera.ImgFromCam(PinholeRay(pinhole, x, y));
      const cv::Vec4f light =
          img && view.camera.Contains(*img) ? SampleLevel(pixels, view.camera, *img) : cv::Vec4f::all(0);
      linear.at<cv::Vec3f>(y, x) = {light[0], light[1], light[2]};
      if (!(light[3] > 0)) result.valid.at<std::uint8_t>(y, x) = 0;
    }
  result.srgb8 = Srgb8FromLinear(linear);
  return result;
}

cv::Mat SubjectDisc(const CameraModel& camera, const Rigid3& cam_from_world, const Subject& subject) {
  const Eigen::Vector3d center = cam_from_world * subject.center_in_world;
  const double distance = center.norm();
  const double cosine =
      distance > subject.radius ? std::sqrt(1 - std::pow(subject.radius / distance, 2)) : -1;
  cv::Mat disc = cv::Mat::zeros(camera.height, camera.width, CV_8U);
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      const auto ray = camera.RayFromImg({x + 0.5, y + 0.5});
      if (ray && ray->dot(center) >= cosine * distance) disc.at<std::uint8_t>(y, x) = 255;
    }
  return disc;
}

EvaluateSummary Evaluate(const RenderScene& scene, const EvaluateOptions& options, Progress* progress) {
  if (options.every < 2)
    throw Refusal(Parameter("every"), std::to_string(options.every), "every view would be left out",
                  "give 2 or more");
  if (scene.views.size() < 2)
    throw Error("evaluation needs at least two views, one to leave out and one to render from; there is {}",
                scene.views.size());
  const std::vector<bool> on_rim = OnRim(scene);
  std::vector<int> left_out = options.left_out;
  if (left_out.empty())
    for (std::size_t i = 0; i < scene.views.size(); i += At(options.every))
      left_out.push_back(static_cast<int>(i));
  std::vector<Truth> truths;
  for (const int i : left_out) {
    const SceneView& view = scene.views[At(i)];
    Truth truth{&view, view.camera.WithoutDistortion(), Undistort(view), {}, on_rim[At(i)]};
    if (options.window_px > 0) Crop(truth, options.window_px);
    truth.disc = SubjectDisc(truth.camera, view.cam_from_world, scene.subject) & truth.photograph.valid;
    truths.push_back(std::move(truth));
  }

  EvaluateSummary summary{.views = static_cast<int>(scene.views.size()),
                          .held_out = static_cast<int>(truths.size())};
  summary.width = truths.front().camera.width;
  summary.height = truths.front().camera.height;
  const auto rest = Without(scene, left_out);
  summary.viewpoints = rest->mesh.Description();
  const auto renderer = MakeRenderer(rest, {.renderer = options.renderer,
                                            .depth = options.look != nullptr,
                                            .gpu_memory_mb = options.gpu_memory_mb});
  summary.renderer = renderer->Name();

  std::vector<std::pair<std::shared_ptr<const Proxy>, FieldOptions>> combinations;
  for (const auto& proxy : options.proxies.empty() ? std::vector{scene.proxy} : options.proxies)
    for (const FieldOptions& field : options.fields) combinations.emplace_back(proxy, field);
  std::size_t done = 0;
  for (const auto& [proxy, field] : combinations) {
    if (renderer->scene().proxy != proxy) renderer->SetProxy(proxy);
    renderer->SetField(field);
    // Drivers compile shaders at the first picture, so it is not timed.
    renderer->Render(truths.front().camera, truths.front().view->cam_from_world);
    FieldScore result{.asked = field, .used = renderer->field(), .proxy = proxy->Name()};
    std::vector<double> times;
    for (const Truth& truth : truths) {
      const auto pictures = static_cast<double>(truths.size() * combinations.size());
      if (options.between) options.between(static_cast<double>(done) / pictures);
      const ViewScore score = Score(*renderer, truth, options.look);
      result.views.push_back(score);
      result.filled_px += score.filled_px;
      result.empty_px += score.empty_px;
      times.push_back(score.ms);
      ++done;
      if (progress)
        progress->Show(static_cast<double>(done) / pictures, proxy->Name() + ", " + FieldName(field.kind));
    }
    result.ms_per_frame = Median(times);
    result.inside = MeanOf(result.views, true, false);
    result.rim = MeanOf(result.views, false, true);
    result.all = MeanOf(result.views, true, true);
    summary.results.push_back(std::move(result));
  }
  if (options.between) options.between(1);
  return summary;
}

}  // namespace ulf::render
