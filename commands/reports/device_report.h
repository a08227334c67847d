// Reports a device's statistics as text and as JSON, for all commands that read frames.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "acquisition/device/device.h"

namespace ulf::commands {

// Returns one line of frame counts, then the transport's counters that are not zero, without a final newline.
std::string ToText(const acquisition::DeviceStatistics& statistics);
// Returns {delivered, incomplete, dropped, missing, out_of_order, late, reconnects, seconds, bytes, fps,
// bytes_per_s, clock_offset_s, clock_jitter_s (null: no clock), transport: {NAME: value}}.
nlohmann::ordered_json ToJson(const acquisition::DeviceStatistics& statistics);

}  // namespace ulf::commands
