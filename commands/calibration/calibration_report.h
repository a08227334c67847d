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

// Describes a calibration that succeeded (`result.ok()`) and, given the true intrinsics, its errors.
std::string ReportText(const acquisition::CalibrationResult& result,
                       const std::optional<CameraModel>& truth = {});
// Returns a table of the lens models with their errors, and the reason for the choice.
std::string CandidateTable(const acquisition::LensChoice& choice);
// For a refused calibration, the JSON has only the board, the reason and the views.
nlohmann::ordered_json ReportJson(const acquisition::CalibrationResult& result);

// Returns how far, in pixels, two models project the same ray apart at most, after the rotation of the camera
// that fits best. The rays are those of a grid in the image of `a` within `reach` (a share of half the
// diagonal) of its middle; rays that one of the models does not have are left out.
double LargestDifferencePx(const CameraModel& a, const CameraModel& b, double reach = 1);

// `found` is the number of pictures with a colour chart, `looked_at` that of all pictures.
std::string ColorFitText(const acquisition::ColorFit& fit, std::size_t found, std::size_t looked_at);
nlohmann::ordered_json ColorFitJson(const acquisition::ColorFit& fit, std::size_t found,
                                    std::size_t looked_at);

std::string GreyCardText(const acquisition::GreyCard& card);
nlohmann::ordered_json GreyCardJson(const acquisition::GreyCard& card);

// Formats the factors of red, green and blue: "R 1.92, G 1, B 1.31".
std::string BalanceText(const std::array<double, 3>& white_balance);

}  // namespace ulf::commands
