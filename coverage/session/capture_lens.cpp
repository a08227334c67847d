#include "coverage/session/capture_lens.h"

#include <utility>

namespace ulf::coverage {

std::optional<CameraModel> CaptureLens::After(const tracking::Track& track,
                                              const tracking::PoseSource& poses) {
  if (!track.wrong_lens)
    contradicted_.reset();
  else if (!contradicted_)
    contradicted_ = poses.Statistics().calibration;
  if (std::exchange(revision_, track.lens_revision) == track.lens_revision) return std::nullopt;
  return AfterFinish(poses);
}

std::optional<CameraModel> CaptureLens::AfterFinish(const tracking::PoseSource& poses) {
  const std::optional<tracking::RefinedLens> found = poses.Statistics().refined_lens;
  if (!found) return std::nullopt;
  found_ = found;
  if (found->camera == live_) return std::nullopt;
  return std::exchange(live_, found->camera);
}

}  // namespace ulf::coverage
