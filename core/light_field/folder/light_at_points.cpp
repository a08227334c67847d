#include "core/light_field/folder/light_at_points.h"

#include <algorithm>

#include "core/light_field/folder/view_images.h"

namespace ulf {
namespace {

constexpr int kPatchPx = 5;  // width, odd, of the square around a point whose mean is taken. Guessed.
// Shares of full scale. A patch whose mean is below the first is mostly noise; a pixel above the second is
// nearly clipped. Guessed.
constexpr float kLeastLight = 0.01f, kMostLight = 0.9f;

}  // namespace

LightAtPoints::LightAtPoints(const LightField& light_field, const View& view, cv::Mat* clipped)
    : black_(view.black_level), light_(LinearFloat(ReadViewLight(light_field, view, clipped))) {}

std::optional<std::array<double, 3>> LightAtPoints::At(const Eigen::Vector2d& img) const {
  const int half = kPatchPx / 2;
  const cv::Rect patch(static_cast<int>(img.x()) - half, static_cast<int>(img.y()) - half, kPatchPx,
                       kPatchPx);
  if ((patch & cv::Rect({}, light_.size())) != patch) return std::nullopt;
  std::array<double, 3> mean{};
  for (int y = patch.y; y < patch.br().y; ++y)
    for (int x = patch.x; x < patch.br().x; ++x)
      for (int c = 0; c < 3; ++c) {
        const float light = light_.at<cv::Vec3f>(y, x)[c];
        if (!(light <= kMostLight)) return std::nullopt;
        mean[static_cast<std::size_t>(c)] += (light - black_) / patch.area();
      }
  if (*std::ranges::min_element(mean) < kLeastLight) return std::nullopt;
  return mean;
}

std::map<int, SharedPoints> PointsSharedWith(const LightField& light_field, int view_id) {
  std::map<int, SharedPoints> shared;
  for (const ScenePoint& point : light_field.points) {
    const auto own = std::ranges::find(point.track, view_id, &ViewObservation::view_id);
    if (own == point.track.end()) continue;
    for (const ViewObservation& other : point.track)
      if (other.view_id != view_id) shared[other.view_id].emplace_back(own->in_img, other.in_img);
  }
  return shared;
}

}  // namespace ulf
