#include "coverage/operator/posed_pictures.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "core/base/quantile.h"
#include "core/image/files/jpeg_codec.h"
#include "core/image/image.h"

namespace ulf::coverage {
namespace {

// Guessed.
constexpr double kPosedThinning = 1.25;  // the step grows by this while there are too many
// A picture within this share of a step from the middle of its place may replace another.
constexpr double kPosedSamePlace = 0.25;
constexpr double kPosedStale_s = 2;  // when the one that is there is older than this

}  // namespace

PosedPicture PosedPicture::Of(const Image& image, const CameraModel& camera, const Rigid3& cam_from_world,
                              std::uint64_t key) {
  const double scale =
      std::min(1.0, static_cast<double>(kLongerSide) / std::max(camera.width, camera.height));
  const cv::Size size(std::max(1, static_cast<int>(std::lround(scale * camera.width))),
                      std::max(1, static_cast<int>(std::lround(scale * camera.height))));
  cv::Mat small;
  cv::resize(ulf::Srgb8(image), small, size, 0, 0, cv::INTER_AREA);
  PosedPicture picture;
  picture.key = key;
  picture.camera = camera.ScaledTo(size.width, size.height);
  picture.cam_from_world = cam_from_world;
  constexpr int kJpegQuality = 92;
  picture.jpeg = JpegBytes(small, kJpegQuality);
  picture.jpeg.shrink_to_fit();  // RecordedPictures counts its size
  return picture;
}

cv::Mat PosedPicture::Srgb8() const { return ReadJpeg(jpeg, "a small picture of a view").pixels; }

std::vector<WeightedPicture> SpreadPictures::pictures() const {
  std::vector<WeightedPicture> pictures;
  for (const Kept& kept : kept_) pictures.push_back({&kept.picture, 1});
  return pictures;
}

SpreadPictures::Kept SpreadPictures::Keep(const CaptureState& state) {
  // A photograph that has just been recorded is not the live picture.
  const auto view = state.takes_stills ? std::nullopt : state.recorded_view;
  return {PosedPicture::Of(state.live, state.camera, *state.cam_from_world, next_key_++), state.device_time_s,
          view};
}

void SpreadPictures::Offer(const CaptureState& state) {
  // Under another lens the world is another one: these poses do not fit it.
  if (std::exchange(lens_, state.camera) != state.camera) {
    kept_.clear();
    least_baseline_ = 0;
  }
  std::erase_if(kept_, [&](const Kept& kept) {
    return kept.view && !std::ranges::binary_search(state.view_ids, *kept.view);
  });
  if (!state.cam_from_world || state.points.empty()) return;
  const Eigen::Vector3d center = state.cam_from_world->OriginInSource();
  if (least_baseline_ == 0) {
    std::vector<double> depths;
    for (const tracking::VisiblePoint& point : state.points) depths.push_back(point.depth);
    constexpr double kStep = 0.02;  // of the median depth. Guessed
    least_baseline_ = kStep * Median(std::move(depths));
  }
  const auto distance = [&](const Kept& kept) { return (kept.Center() - center).norm(); };
  const auto nearest = std::ranges::min_element(kept_, {}, distance);
  if (nearest != kept_.end() && distance(*nearest) < least_baseline_) {
    // Only a picture near the middle of the place may replace it: otherwise a slow movement would drag it
    // along.
    const bool stale = distance(*nearest) < kPosedSamePlace * least_baseline_ &&
                       state.device_time_s > nearest->device_time_s + kPosedStale_s;
    const bool recorded = state.recorded_view && !state.takes_stills && !nearest->view;
    if (stale || recorded) *nearest = Keep(state);
    return;
  }
  kept_.push_back(Keep(state));
  while (kept_.size() > most_) Thin();
}

void SpreadPictures::Thin() {
  least_baseline_ *= kPosedThinning;
  std::vector<Kept> apart;
  for (Kept& kept : kept_) {
    const bool crowded = std::ranges::any_of(
        apart, [&](const Kept& other) { return (other.Center() - kept.Center()).norm() < least_baseline_; });
    if (!crowded) apart.push_back(std::move(kept));
  }
  kept_ = std::move(apart);
}

}  // namespace ulf::coverage
