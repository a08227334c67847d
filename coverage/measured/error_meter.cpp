#include "coverage/measured/error_meter.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "core/base/host_time.h"

namespace ulf::coverage {
namespace {

constexpr double kMeterAgainShare = 0.15;  // more, for frames that are measured again. Guessed.
// Small pictures, 80 kB each, that can be measured again. Guessed.
constexpr std::size_t kMeterFramesKept = 600;
// Share of the silhouette that views see: with less, nothing is measured. Guessed.
constexpr double kMeterLeastSeen = 0.6;
// Root mean square, grey values: with less there is nothing to see. Guessed.
constexpr double kMeterLeastContrast = 2.5;

using Clock = std::chrono::steady_clock;

Clock::time_point After(Clock::time_point start, double seconds) {
  return start + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

}  // namespace

cv::Mat SmallSrgb8(const Image& image, int longer_side_px) {
  const int side = std::max(image.pixels.cols, image.pixels.rows);
  if (side <= 2 * longer_side_px) return Srgb8(image);
  const double scale = 2.0 * longer_side_px / side;
  if (image.mosaic != Mosaic::kNone) {  // neighbours have other colours: grey is all that is compared
    cv::Mat grey;
    cv::resize(GrayForTracking(image), grey, {}, scale, scale, cv::INTER_AREA);
    cv::cvtColor(grey, grey, cv::COLOR_GRAY2BGR);
    return grey;
  }
  Image small = image;
  cv::resize(image.pixels, small.pixels, {}, scale, scale, cv::INTER_AREA);
  return Srgb8(small);
}

void ErrorMeter::SetGeometry(const Subject& subject, std::shared_ptr<const render::TriangleMesh> mesh) {
  if (!(subject == predictor_.subject())) {  // directions are from another point now
    kept_.clear();
    stale_.clear();
  }
  predictor_.SetGeometry(subject, std::move(mesh));
}

void ErrorMeter::StartAgain() {
  predictor_ = render::FramePredictor();
  kept_.clear();
  stale_.clear();
}

void ErrorMeter::MoveViews(const std::map<int, Rigid3>& cam_from_world) {
  predictor_.MoveViews(cam_from_world);
  kept_.clear();
  stale_.clear();
}

void ErrorMeter::AddView(int id, const Image& image, const CameraModel& camera,
                         const Rigid3& cam_from_world) {
  predictor_.AddView(id, maker_.Make(SmallSrgb8(image, options_.size_px), camera, cam_from_world));
  MarkStale(cam_from_world);
}

void ErrorMeter::RemoveView(int id, const Rigid3& cam_from_world) {
  predictor_.RemoveView(id);
  MarkStale(cam_from_world);
}

void ErrorMeter::MarkStale(const Rigid3& cam_from_world) {
  const Eigen::Vector3d& center = predictor_.subject().center_in_world;
  const Eigen::Vector3d direction = cam_from_world.OriginInSource() - center;
  for (const auto& [key, frame] : kept_)
    if (AngleBetween(direction, frame.small.center_in_world - center) < kViewReach &&
        std::ranges::find(stale_, key) == stale_.end())
      stale_.push_back(key);
}

void ErrorMeter::AddEarlierView(int id, ReadPicture picture, const CameraModel& camera,
                                const Rigid3& cam_from_world) {
  predictor_.AddView(id, cam_from_world, [this, picture = std::move(picture), camera, cam_from_world] {
    return maker_.Make(picture(), camera, cam_from_world);
  });
}

std::optional<MeasuredFrame> ErrorMeter::Measure(const Input& input) {
  const auto now = std::chrono::steady_clock::now();
  if (!predictor_.has_geometry() || predictor_.views() == 0) return std::nullopt;
  if (!options_.every_frame && now < rested_) return std::nullopt;
  const double before_s = ThreadCpuSeconds();
  const render::StereoView small =
      maker_.Make(SmallSrgb8(input.image, options_.size_px), input.camera, input.cam_from_world);
  MeasuredFrame measured = MeasureSmall(small, input.center_sigma, input.time_s);
  Keep(measured, small, input.center_sigma);
  const double took_s = ThreadCpuSeconds() - before_s;
  measured.processor_ms = 1e3 * took_s;
  rested_ = After(now, took_s / options_.processor_share);
  return measured;
}

std::optional<MeasuredFrame> ErrorMeter::MeasureAgain() {
  const auto now = std::chrono::steady_clock::now();
  if (stale_.empty() || !predictor_.has_geometry() || (!options_.every_frame && now < rested_again_))
    return std::nullopt;
  const auto found = kept_.find(stale_.front());
  stale_.pop_front();
  if (found == kept_.end()) return std::nullopt;
  const double before_s = ThreadCpuSeconds();
  render::StereoView small = found->second.small;
  found->second.small.grey.convertTo(small.grey, CV_32F);
  MeasuredFrame measured = MeasureSmall(small, found->second.center_sigma, found->second.time_s);
  const double took_s = ThreadCpuSeconds() - before_s;
  measured.processor_ms = 1e3 * took_s;
  rested_again_ = After(now, took_s / kMeterAgainShare);
  return measured;
}

void ErrorMeter::Keep(const MeasuredFrame& measured, const render::StereoView& small,
                      std::optional<double> center_sigma) {
  const ErrorMap::Key key = ErrorMap::KeyOf(measured.direction);
  Kept kept{small, center_sigma, measured.time_s, ++kept_so_far_};
  small.grey.convertTo(kept.small.grey, CV_8U);  // a new picture: the old one stays as it is
  kept_.insert_or_assign(key, std::move(kept));
  std::erase(stale_, key);
  if (kept_.size() > kMeterFramesKept)
    kept_.erase(std::ranges::min_element(kept_, {}, [](const auto& each) { return each.second.number; }));
}

MeasuredFrame ErrorMeter::MeasureSmall(const render::StereoView& small, std::optional<double> center_sigma,
                                       double time_s) {
  MeasuredFrame measured;
  measured.direction = (small.center_in_world - predictor_.subject().center_in_world).normalized();
  measured.nearest_view_angle = predictor_.NearestViewAngle(small.center_in_world);
  measured.time_s = time_s;
  if (const auto predicted = predictor_.Predict(small)) {
    const render::PredictionError error =
        render::MeasureError(small, *predicted, predictor_.subject(), {.center_sigma = center_sigma});
    measured.one_sided = predicted->one_sided;
    measured.measurable = error.inside.SeenShare() >= kMeterLeastSeen &&
                          error.on_mesh_share >= kMeterLeastSeen &&
                          error.inside.contrast >= kMeterLeastContrast;
    measured.db = error.inside.db;
    measured.db_aligned = error.inside.db_aligned;
    measured.db_outside = error.outside.db;
    measured.misregistration_px = error.inside.misregistration_px;
    measured.cause = render::CauseOf(error, options_.good_db);
  } else {
    measured.cause = render::ErrorCause::kNotSeen;
  }
  return measured;
}

}  // namespace ulf::coverage
