#include "coverage/session/record/capture_lens.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "acquisition/calibration/intrinsics.h"

namespace ulf::coverage {

std::optional<CameraModel> CaptureLens::Update(const tracking::Track& track,
                                               const tracking::PoseSource& poses) {
  if (!track.wrong_lens)
    contradicted_.reset();
  else if (!contradicted_)
    contradicted_ = poses.Statistics().calibration;
  if (std::exchange(revision_, track.lens_revision) == track.lens_revision) return std::nullopt;
  return UpdateAfterFinish(poses);
}

std::optional<CameraModel> CaptureLens::UpdateAfterFinish(const tracking::PoseSource& poses) {
  const std::optional<tracking::RefinedLens> found = poses.Statistics().refined_lens;
  if (!found) return std::nullopt;
  found_ = found;
  if (found->camera == live_) return std::nullopt;
  return std::exchange(live_, found->camera);
}

std::string CaptureLens::FoundSource() const {
  const std::string from = acquisition::kLensFoundInCapture;
  return found_ && found_->focal_sigma_px > 0 ? fmt::format("{} (± {:.1f} px)", from, found_->focal_sigma_px)
                                              : from;
}

double LargestShiftPx(const CameraModel& a, const CameraModel& b, int longer_side_px) {
  const double scale = static_cast<double>(longer_side_px) / std::max(a.width, a.height);
  double largest = 0;
  constexpr int kPlaces = 4;  // along each side; lenses differ smoothly
  for (int row = 0; row <= kPlaces; ++row)
    for (int column = 0; column <= kPlaces; ++column) {
      const Eigen::Vector2d img(a.width * column / kPlaces, a.height * row / kPlaces);
      const auto ray = a.RayFromImg(img);
      const auto there = ray ? b.ImgFromCam(*ray) : std::nullopt;
      if (there) largest = std::max(largest, scale * (*there - img).norm());
    }
  return largest;
}

}  // namespace ulf::coverage
