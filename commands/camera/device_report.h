// A device's statistics for people and for programs: the same figures wherever a command ends.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "acquisition/device/device.h"

namespace ulf::commands {

// One line for what the reader got, more for what the transport counted and did, where it tells: what is not
// zero. No end of line.
std::string ToText(const acquisition::DeviceStatistics& statistics);
// {delivered, incomplete, dropped, missing, out_of_order, late, reconnects, seconds, bytes, fps, bytes_per_s,
// clock_offset_s, clock_jitter_s (null: no clock), transport: {NAME: value}}
nlohmann::ordered_json ToJson(const acquisition::DeviceStatistics& statistics);

}  // namespace ulf::commands
