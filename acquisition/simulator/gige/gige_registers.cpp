#include "acquisition/simulator/gige/gige_registers.h"

#include <algorithm>

#include "acquisition/simulator/gige/gige_pictures.h"

namespace ulf::acquisition {
namespace {

// Addresses of the GenICam description.
constexpr std::uint32_t kWidthAt = 0x100, kHeightAt = 0x104, kGainAt = 0x110, kPixelFormatAt = 0x128,
                        kAcquisitionModeAt = 0x12C, kOffsetXAt = 0x130, kOffsetYAt = 0x134,
                        kFramePeriodAt = 0x138, kTriggerModeAt = 0x300, kTriggerSoftwareAt = 0x30C;
// Bootstrap registers of GigE Vision.
constexpr std::uint32_t kHeartbeatTimeoutAt = 0x938, kControlPrivilegeAt = 0xA00, kUserNameAt = 0xE8,
                        kUserNameBytes = 16;
constexpr std::uint32_t kSmallestPacket = 100, kDoNotFragment = 1u << 30;

WritableRegister Between(std::uint32_t address, std::uint32_t low, std::uint32_t high) {
  return {address, [low, high](std::uint32_t value) { return low <= value && value <= high; }};
}

WritableRegister AnyValue(std::uint32_t address) {
  return {address, [](std::uint32_t) { return true; }};
}

std::uint32_t OfSet(std::uint32_t first, std::uint32_t set) {
  return first + 4 * std::min(set, kSequencerSets - 1);
}

}  // namespace

std::vector<WritableRegister> WritableRegisters(const SimulationOptions& simulation) {
  const auto width = static_cast<std::uint32_t>(simulation.width),
             height = static_cast<std::uint32_t>(simulation.height);
  std::vector<WritableRegister> writable{
      Between(kWidthAt, 1, width),
      Between(kHeightAt, 1, height),
      Between(kOffsetXAt, 0, width),
      Between(kOffsetYAt, 0, height),
      {kPixelFormatAt, [](std::uint32_t code) { return SensorFormatByCode(code).has_value(); }},
      Between(kAcquisitionAt, 0, 1),
      Between(kAcquisitionModeAt, 0, 2),
      Between(kFramePeriodAt, 1'000, 10'000'000),
      Between(kExposureAt, 10, 1'000'000),
      Between(kGainAt, 0, 360),
      Between(kTriggerModeAt, 0, 1),
      Between(kTriggerSoftwareAt, 0, 1),
      Between(kTriggerSourceAt, 0, 1),
      Between(kLinePeriodAt, 5'000, 10'000'000),
      Between(kControlPrivilegeAt, 0, 3),
      Between(kHeartbeatTimeoutAt, 500, 600'000),
      {kPacketSizeAt,
       [](std::uint32_t value) {
         const std::uint32_t bytes = value & ~kDoNotFragment;
         return kSmallestPacket <= bytes && bytes <= 0xFFFF;
       }},
      AnyValue(kStreamPortAt),
      AnyValue(kPacketDelayAt),
      AnyValue(kStreamAddressAt),
      Between(kThroughputModeAt, 0, 1),
      Between(kThroughputLimitAt, kLeastThroughput, kMostThroughput),
      Between(kChunkModeAt, 0, 1),
      Between(kChunkSelectorAt, 0, static_cast<std::uint32_t>(kChunks.size() - 1)),
      Between(kPtpEnableAt, 0, 1),
      Between(kPtpLatchAt, 0, 1),
      Between(kSequencerModeAt, 0, 1),
      Between(kSequencerConfigurationAt, 0, 1),
      Between(kSequencerSelectorAt, 0, kSequencerSets - 1),
      Between(kSequencerSaveAt, 0, 1),
      Between(kSequencerStartAt, 0, kSequencerSets - 1)};
  for (std::uint32_t set = 0; set < kSequencerSets; ++set)
    writable.push_back(Between(kSequencerNextAt + 4 * set, 0, kSequencerSets - 1));
  for (std::uint32_t i = 0; i < kChunks.size(); ++i)
    writable.push_back(Between(kChunkEnableAt + 4 * i, 0, 1));
  for (std::uint32_t at = kUserNameAt; at < kUserNameAt + kUserNameBytes; at += 4)
    writable.push_back(AnyValue(at));
  return writable;
}

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
