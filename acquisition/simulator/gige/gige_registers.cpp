#include "acquisition/simulator/gige/gige_registers.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <string>
#include <utility>

#include "acquisition/gige_vision/gige_vision_probe.h"
#include "acquisition/gige_vision/gvcp.h"
#include "acquisition/simulator/gige/gige_pictures.h"

namespace ulf::acquisition {

using namespace gvcp;

namespace {

// Addresses of the GenICam description.
constexpr std::uint32_t kSensorHeightAt = 0x118, kSensorWidthAt = 0x11C, kAcquisitionModeAt = 0x12C;
constexpr std::uint32_t kUserNameBytes = 16, kInterfacesAt = 0x600, kStreamChannelsAt = 0x904;
constexpr char kGigeVersion[] = "0.8.26";  // the release of Aravis whose registers the camera has
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

// Aravis's fake camera has these registers, whose place in the simulated camera clients may know: binning,
// the mode of the gain, the trigger's source and a value for tests. Nothing reads them.
constexpr std::pair<std::uint32_t, std::uint32_t> kUnused[] = {
    {0x108, 1}, {0x10C, 1}, {0x114, 1}, {0x304, 1}, {0x1F0, 0x12345678}};

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

void WriteStartValues(const GigeStartValues& values, const SimulationOptions& simulation,
                      RegisterMemory& memory) {
  memory.Write(kCurrentAddressAt, Ipv4(values.address).value_or(0));
  for (const auto& [at, text] : std::initializer_list<std::pair<std::uint32_t, std::string>>{
           {kMakerAt, "ULF"},
           {kModelAt, "HandheldSimulator"},
           {kVersionAt, kGigeVersion},
           {kInfoAt, "ulf simulate: ray-cast scenes"},
           {kSerialAt, values.serial}})
    memory.Write(at, text);
  const auto set = [&](std::uint32_t at, double value) {
    memory.Write(at, static_cast<std::uint32_t>(std::lround(value)));
  };
  for (const std::uint32_t at : {kWidthAt, kSensorWidthAt}) set(at, simulation.width);
  for (const std::uint32_t at : {kHeightAt, kSensorHeightAt}) set(at, simulation.height);
  set(kFramePeriodAt, 1e6 / simulation.fps);
  set(kExposureAt, 1e6 * simulation.exposure_s);
  set(kGainAt, 10 * simulation.gain_db);
  set(kPixelFormatAt, PixelsOf(simulation.format).code);
  set(kTriggerSourceAt, 1);  // Software
  set(kLinePeriodAt, 1e6 / values.line_hz);
  set(kThroughputLimitAt, 125e6);  // gigabit Ethernet
  set(kTickFrequencyAt + 4, 1e9);  // the lower half: the clock counts nanoseconds
  set(kHeartbeatTimeoutAt, 3000);
  set(kPacketSizeAt, 1400);
  for (const std::uint32_t at : {kAcquisitionModeAt, kInterfacesAt, kStreamChannelsAt}) set(at, 1);
  for (const auto& [at, value] : kUnused) memory.Write(at, value);
}

void GigeSequencer::BeforeRequest(const GvcpAccess& access) {
  if (access.address != kSequencerSaveAt || access.written != 1u) return;
  memory_.Write(OfSet(kSequencerExposureAt, memory_.Read(kSequencerSelectorAt)), memory_.Read(kExposureAt));
}

std::uint32_t GigeSequencer::NextExposureUs(std::uint32_t otherwise) {
  const bool runs = memory_.Read(kSequencerModeAt) == 1 && memory_.Read(kSequencerConfigurationAt) == 0;
  if (runs && !runs_) set_ = memory_.Read(kSequencerStartAt);
  runs_ = runs;
  if (!runs) return otherwise;
  const std::uint32_t exposure_us = memory_.Read(OfSet(kSequencerExposureAt, set_));
  set_ = memory_.Read(OfSet(kSequencerNextAt, set_));
  return exposure_us > 0 ? exposure_us : otherwise;
}

}  // namespace ulf::acquisition
