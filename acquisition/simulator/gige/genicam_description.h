// Writes the simulated camera's GenICam description (GenApi XML, schema 1.0). Addresses: gige_registers.h.
#pragma once

#include <string>

namespace ulf::acquisition {

// Returns the description, which is written once per process.
const std::string& GenicamDescription();

}  // namespace ulf::acquisition
