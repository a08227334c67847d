// What a calibration found, for people and for programs.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "acquisition/calibration/calibrate.h"

namespace ulf::commands {

// `truth`: what the device itself knows of its lens (the simulator).
std::string ReportText(const acquisition::CalibrationResult& result,
                       const std::optional<CameraModel>& truth = {});
// The candidates, what each explains, and why one was chosen.
std::string CandidateTable(const acquisition::LensChoice& choice);
nlohmann::ordered_json ReportJson(const acquisition::CalibrationResult& result);

// The farthest that any point of the image moves when seen through the one instead of the other model, with
// the one rotation between them that fits best taken out; pixels, over a grid out to `reach` (a share of half
// the diagonal). What a difference in parameters is worth.
double LargestDifferencePx(const CameraModel& a, const CameraModel& b, double reach = 1);

}  // namespace ulf::commands
