// Registers of the simulated camera that Aravis does not define, and the values that clients may write.
#pragma once

#include <cstdint>
#include <vector>

#include "acquisition/simulator/gige/gvcp_filter.h"
#include "acquisition/simulator/simulated_camera.h"

namespace ulf::acquisition {

inline constexpr std::uint32_t kLastFrameAt = 0x1000, kTriggerSourceAt = 0x1020, kLinePeriodAt = 0x1024;
// Bootstrap registers of GigE Vision.
inline constexpr std::uint32_t kCurrentAddressAt = 0x24, kStreamSourcePortAt = 0xD1C;

// All registers that a client may write, with the ranges of the GenICam description. Aravis does not check
// values: it would divide by a frame period of 0 and allocate by any width.
std::vector<WritableRegister> WritableRegisters(const SimulationOptions& simulation);

}  // namespace ulf::acquisition
