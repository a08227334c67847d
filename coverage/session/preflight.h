// The checks before the first view: what each found and, where it failed, what to do.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/device/device.h"
#include "coverage/bound/capture_prediction.h"

namespace ulf::coverage {

struct PreflightItem {
  std::string name;  // "calibration", "exposure", "white balance", "focus", "disk", "views", "tracking"
  std::optional<bool> in_order;  // none: unknown
  std::string words;             // the finding and, where it is not in order, what to do
};

struct PreflightInput {
  std::optional<bool> calibrated;  // false: --focal-px and no distortion; none: poses and camera are given
  std::string calibration_source;
  acquisition::HeldAutomatics held;
  std::optional<CapturePrediction> prediction;
  std::optional<Cap> cap = std::nullopt;  // none: the operator ends the capture
  bool without_subject = false;
  std::uint64_t bytes_per_view = 0;  // at most
  std::optional<std::uint64_t> disk_left_bytes;
  bool has_pose = true;  // of the present frame
  // Of a view taken now (view_decision.h); none: the pose is given.
  std::optional<double> pose_error_px;
  double most_pose_error_px = 1;
};

std::vector<PreflightItem> Preflight(const PreflightInput& input);

}  // namespace ulf::coverage
