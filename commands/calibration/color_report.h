// The result of a colour calibration as text and as JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "acquisition/calibration/color_fit.h"

namespace ulf::commands {

// `found`, `looked_at`: pictures with a chart, and all.
std::string ColorFitText(const acquisition::ColorFit& fit, std::size_t found, std::size_t looked_at);
nlohmann::ordered_json ColorFitJson(const acquisition::ColorFit& fit, std::size_t found,
                                    std::size_t looked_at);

std::string GreyCardText(const acquisition::GreyCard& card);
nlohmann::ordered_json GreyCardJson(const acquisition::GreyCard& card);

// "R 1.92, G 1, B 1.31"
std::string BalanceText(const std::array<double, 3>& white_balance);

}  // namespace ulf::commands
