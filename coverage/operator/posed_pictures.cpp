#include "coverage/operator/posed_pictures.h"

#include <algorithm>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <set>

#include "acquisition/image.h"

namespace ulf {

PosedPicture PosedPicture::Of(const CaptureState& state, std::uint64_t key, int longer_side) {
  const double scale =
      std::min(1.0, static_cast<double>(longer_side) / std::max(state.camera.width, state.camera.height));
  const cv::Size size(std::max(1, static_cast<int>(std::lround(scale * state.camera.width))),
                      std::max(1, static_cast<int>(std::lround(scale * state.camera.height))));
  cv::Mat small;
  cv::resize(ulf::Srgb8(state.live), small, size, 0, 0, cv::INTER_AREA);
  PosedPicture picture;
  picture.key = key;
  picture.camera = state.camera.ScaledTo(size.width, size.height);
  picture.cam_from_world = *state.cam_from_world;
  picture.device_time_s = state.device_time_s;
  cv::imencode(".jpg", small, picture.jpeg, {cv::IMWRITE_JPEG_QUALITY, 92});
  return picture;
}

cv::Mat PosedPicture::Srgb8() const { return cv::imdecode(jpeg, cv::IMREAD_COLOR); }

void SpreadPictures::Offer(const CaptureState& state) {
  if (!state.cam_from_world || state.points.empty()) return;
  const Eigen::Vector3d center = state.cam_from_world->OriginInSource();
  // What is a step depends on how far away things are.
  if (least_baseline_ == 0) {
    std::vector<double> depths;
    for (const VisiblePoint& point : state.points) depths.push_back(point.depth);
    std::nth_element(depths.begin(), depths.begin() + static_cast<long>(depths.size() / 2), depths.end());
    constexpr double kStep = 0.02;
    least_baseline_ = kStep * depths[depths.size() / 2];
  }
  PosedPicture* nearest = nullptr;
  double nearest_distance = std::numeric_limits<double>::infinity();
  for (PosedPicture& picture : pictures_) {
    const double distance = (picture.cam_from_world.OriginInSource() - center).norm();
    if (distance < nearest_distance) nearest_distance = distance, nearest = &picture;
  }
  if (nearest_distance < least_baseline_) {
    // Replaced only by one that is as near to the middle of its place: else a slow hand would drag it along.
    constexpr double kStale_s = 2;
    if (nearest_distance < 0.25 * least_baseline_ && state.device_time_s > nearest->device_time_s + kStale_s)
      *nearest = PosedPicture::Of(state, next_key_++);
    return;
  }
  pictures_.push_back(PosedPicture::Of(state, next_key_++));
  while (pictures_.size() > most_) {
    least_baseline_ *= 1.25;
    std::vector<PosedPicture> kept;
    for (PosedPicture& picture : pictures_) {
      const Eigen::Vector3d at = picture.cam_from_world.OriginInSource();
      const bool crowded = std::any_of(kept.begin(), kept.end(), [&](const PosedPicture& other) {
        return (other.cam_from_world.OriginInSource() - at).norm() < least_baseline_;
      });
      if (!crowded) kept.push_back(std::move(picture));
    }
    pictures_ = std::move(kept);
  }
}

void RecordedPictures::Add(const CaptureState& state) {
  if (!state.recorded_view || !state.cam_from_world) return;
  const int id = *state.recorded_view;
  pictures_.insert_or_assign(id, PosedPicture::Of(state, static_cast<std::uint64_t>(id)));
}

void RecordedPictures::Follow(const CaptureState& state) {
  if (!state.coverage) return;
  const std::set<int> living(state.view_ids.begin(), state.view_ids.end());
  std::erase_if(pictures_, [&](const auto& picture) { return !living.contains(picture.first); });
  if (state.takes_stills) return;
  for (std::size_t i = 0; i < state.view_ids.size(); ++i) {
    const auto found = pictures_.find(state.view_ids[i]);
    if (found == pictures_.end()) continue;
    const CriterionView& view = state.coverage->views()[i];
    const Eigen::Quaterniond rotation(view.cam_from_world);
    found->second.cam_from_world = {rotation, -(rotation * view.center_in_world)};
  }
}

void CaptureFeed::Publish(std::shared_ptr<const CaptureState> state) {
  constexpr std::size_t kMost = 32;  // of a display that stands still: the review then misses the oldest
  const std::lock_guard lock(mutex_);
  if (closed_) return;
  if (state->recorded_view) {
    recorded_.push_back(state);
    if (recorded_.size() > kMost) recorded_.pop_front();
  }
  newest_.Publish(std::move(state));
}

void CaptureFeed::Close() {
  const std::lock_guard lock(mutex_);
  closed_ = true;
  recorded_.clear();
  newest_.Publish(nullptr);
}

std::vector<std::shared_ptr<const CaptureState>> CaptureFeed::TakeRecorded() {
  const std::lock_guard lock(mutex_);
  std::vector<std::shared_ptr<const CaptureState>> taken(recorded_.begin(), recorded_.end());
  recorded_.clear();
  return taken;
}

}  // namespace ulf
