// Defines the registers of the simulated camera: addresses, values at the start, and what clients may write.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "acquisition/simulator/gige/gvcp_server.h"
#include "acquisition/simulator/gige/register_memory.h"
#include "acquisition/simulator/simulated_camera.h"

namespace ulf::acquisition {

inline constexpr std::uint32_t kLastFrameAt = 0x1000, kTriggerSourceAt = 0x1020, kLinePeriodAt = 0x1024,
                               kThroughputModeAt = 0x1030, kThroughputLimitAt = 0x1034, kChunkModeAt = 0x1040,
                               kChunkSelectorAt = 0x1044, kChunkEnableAt = 0x1050, kLineStatusAt = 0x1080,
                               kPtpEnableAt = 0x1090, kPtpStatusAt = 0x1094, kPtpLatchAt = 0x1098,
                               kPtpOffsetAt = 0x109C, kSequencerModeAt = 0x10A0,
                               kSequencerConfigurationAt = 0x10A4, kSequencerSelectorAt = 0x10A8,
                               kSequencerSaveAt = 0x10AC, kSequencerStartAt = 0x10B0,
                               kSequencerNextAt = 0x10C0,
                               kSequencerExposureAt = 0x1100;  // the last two: one of each set
inline constexpr std::uint32_t kSequencerSets = 16;
// Addresses that Aravis's fake camera has, too.
inline constexpr std::uint32_t kWidthAt = 0x100, kHeightAt = 0x104, kGainAt = 0x110, kExposureAt = 0x120,
                               kAcquisitionAt = 0x124, kPixelFormatAt = 0x128, kOffsetXAt = 0x130,
                               kOffsetYAt = 0x134, kFramePeriodAt = 0x138, kTriggerModeAt = 0x300,
                               kTriggerSoftwareAt = 0x30C;
// Bootstrap registers of GigE Vision.
inline constexpr std::uint32_t kTickFrequencyAt = 0x93C, kStreamPortAt = 0xD00, kPacketSizeAt = 0xD04,
                               kPacketDelayAt = 0xD08, kStreamAddressAt = 0xD18, kStreamSourcePortAt = 0xD1C;
inline constexpr std::uint32_t kPacketSizeMask = 0xFFFF;

// The chunk data that the camera can add to a frame, in the order of ChunkSelector: eight bytes each. The
// image is a chunk as well.
struct SimulatedChunk {
  const char* name;
  std::uint32_t id;
  bool is_real;  // a double; false: an integer
};
inline constexpr std::array kChunks{
    SimulatedChunk{"ExposureTime", 0x1001, true}, SimulatedChunk{"Gain", 0x1002, true},
    SimulatedChunk{"Timestamp", 0x1003, false}, SimulatedChunk{"FrameID", 0x1004, false},
    SimulatedChunk{"LineStatusAll", 0x1005, false}};
inline constexpr std::uint32_t kImageChunkId = 0x1000, kChunkValueBytes = 8;
// What the image's chunk and each other chunk add to the payload, beside the image.
inline constexpr std::uint32_t kImageChunkBytes = 8, kChunkBytes = kChunkValueBytes + 8;
// Bytes a second.
inline constexpr std::uint32_t kLeastThroughput = 1'000'000, kMostThroughput = 2'000'000'000;

// Returns all registers that a client may write, with the ranges of the GenICam description: the camera
// computes with their values.
std::vector<WritableRegister> WritableRegisters(const SimulationOptions& simulation);

// What the registers of a camera at an IPv4 address hold before any client has written them. `line_hz`:
// pulses a second on Line0.
struct GigeStartValues {
  std::string address, serial;
  double line_hz = 10;
};
void WriteStartValues(const GigeStartValues& values, const SimulationOptions& simulation,
                      RegisterMemory& memory);

// The sequencer of the simulated camera (SFNC, "Sequencer Control"): sets of exposure times that the camera
// goes through by itself, one a frame. A set is saved with the exposure time that the camera has then; each
// names the next. While the sequencer runs, the register of the exposure time has no effect. For one thread.
class GigeSequencer {
 public:
  explicit GigeSequencer(RegisterMemory& memory) : memory_(memory) {}
  // Call it before a valid request is carried out.
  void BeforeRequest(const GvcpAccess& access);
  // Returns the exposure time of the next frame, in microseconds: the running set's, else `otherwise`.
  std::uint32_t NextExposureUs(std::uint32_t otherwise);

 private:
  RegisterMemory& memory_;
  bool runs_ = false;
  std::uint32_t set_ = 0;  // of the next frame
};

}  // namespace ulf::acquisition
