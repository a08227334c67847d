// Registers of the simulated camera beside those that the library knows by name, as its description names
// them, and what may be written into which.
#pragma once

#include <cstdint>
#include <vector>

#include "acquisition/simulator/gige/gvcp_filter.h"
#include "acquisition/simulator/simulated_camera.h"

namespace ulf::acquisition {

inline constexpr std::uint32_t kLastFrameAt = 0x1000, kTriggerSourceAt = 0x1020, kLinePeriodAt = 0x1024;
// The standard's own.
inline constexpr std::uint32_t kCurrentAddressAt = 0x24, kStreamSourcePortAt = 0xD1C;

// All that a client may write; the ranges are the description's. The library takes every value for what it
// says: a frame period of 0 is a division, a width the size of an allocation.
std::vector<WritableRegister> WritableRegisters(const SimulationOptions& simulation);

}  // namespace ulf::acquisition
