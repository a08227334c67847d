#include "acquisition/simulator/gige/gige_sequencer.h"

#include <algorithm>

#include "acquisition/simulator/gige/gige_registers.h"

namespace ulf::acquisition {
namespace {

std::uint32_t OfSet(std::uint32_t first, std::uint32_t set) {
  return first + 4 * std::min(set, kSequencerSets - 1);
}

}  // namespace

void GigeSequencer::BeforeRequest(const GvcpAccess& access) {
  if (access.address != kSequencerSaveAt || access.written != 1u) return;
  registers_.write(OfSet(kSequencerExposureAt, registers_.read(kSequencerSelectorAt)),
                   registers_.read(kExposureAt));
}

std::uint32_t GigeSequencer::NextExposureUs(std::uint32_t otherwise) {
  const bool runs = registers_.read(kSequencerModeAt) == 1 && registers_.read(kSequencerConfigurationAt) == 0;
  if (runs && !runs_) set_ = registers_.read(kSequencerStartAt);
  runs_ = runs;
  if (!runs) return otherwise;
  const std::uint32_t exposure_us = registers_.read(OfSet(kSequencerExposureAt, set_));
  set_ = registers_.read(OfSet(kSequencerNextAt, set_));
  return exposure_us > 0 ? exposure_us : otherwise;
}

}  // namespace ulf::acquisition
