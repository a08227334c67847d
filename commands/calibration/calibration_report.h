// Reports calibrations of a lens, of colours and of a grey card as text and as JSON.
#pragma once

#include <array>
#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "acquisition/calibration/calibrate.h"
#include "acquisition/calibration/color_fit.h"

namespace ulf::commands {

// `truth` holds the intrinsics that the device itself knows (the simulator).
std::string ReportText(const acquisition::CalibrationResult& result,
                       const std::optional<CameraModel>& truth = {});
// Returns a table of the lens models with their errors, and the reason for the choice.
std::string CandidateTable(const acquisition::LensChoice& choice);
nlohmann::ordered_json ReportJson(const acquisition::CalibrationResult& result);

// Returns the largest difference in pixels between the image points of the same rays in two models, after the
// rotation that fits best, over a grid out to `reach` (a share of half the diagonal): the effect of their
// differing parameters on images.
double LargestDifferencePx(const CameraModel& a, const CameraModel& b, double reach = 1);

// `found` counts the pictures with a chart, `looked_at` all.
std::string ColorFitText(const acquisition::ColorFit& fit, std::size_t found, std::size_t looked_at);
nlohmann::ordered_json ColorFitJson(const acquisition::ColorFit& fit, std::size_t found,
                                    std::size_t looked_at);

std::string GreyCardText(const acquisition::GreyCard& card);
nlohmann::ordered_json GreyCardJson(const acquisition::GreyCard& card);

// Returns "R 1.92, G 1, B 1.31".
std::string BalanceText(const std::array<double, 3>& white_balance);

}  // namespace ulf::commands
