// The result of a calibration as text and as JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "acquisition/calibration/calibrate.h"

namespace ulf::commands {

// `truth`: the intrinsics that the device itself knows (the simulator).
std::string ReportText(const acquisition::CalibrationResult& result,
                       const std::optional<CameraModel>& truth = {});
// A table of the lens models with their errors, and the reason for the choice.
std::string CandidateTable(const acquisition::LensChoice& choice);
nlohmann::ordered_json ReportJson(const acquisition::CalibrationResult& result);

// The largest difference in pixels between the image points of the same rays in two models, after the
// rotation that fits best, over a grid out to `reach` (a share of half the diagonal). It tells how much
// differences between parameters matter.
double LargestDifferencePx(const CameraModel& a, const CameraModel& b, double reach = 1);

}  // namespace ulf::commands
