// The figures of a device's transport (packets, buffers, photographs): what each is, whether it counts, and
// its name for people, in one place. docs/measured/cameras.md says what the figures of GigE Vision count, and
// which are not reliable.
#pragma once

#include <optional>
#include <utility>
#include <vector>

namespace ulf::acquisition {

enum class TransportFigure {
  kPixelRate,
  kFramesCompleted,
  kFramesFailed,
  kFramesTimedOut,
  kFramesAborted,
  kFramesMissing,
  kSizeMismatches,
  kUnderruns,
  kPacketsReceived,
  kPacketsMissing,
  kResendRequests,
  kPacketsResent,
  kResendLimitReached,
  kResendsGivenUp,
  kPacketsTwice,
  kPacketsWithErrors,
  kPacketsIgnored,
  kBytesReceived,
  kBytesIgnored,
  kBuffers,
  kPayloadBytes,
  kSetFps,
  kThroughputLimit,
  kRealTimePriority,
  kHighPriority,
  kPacketsRefused,
  kPacketSize,
  kPacketSizeNegotiated,
  kPacketDelayNs,
  kResends,
  kPacketTimeoutMs,
  kFrameRetentionMs,
  kSocketBufferAsked,
  kSocketBuffer,
  kClockShared,
  kClockOffsetNs,
  kExposureUs,
  kWrongPacketIds,
  kWhileSettling,
  kPhotographs,
  kNotDownloaded,
  kLiveViewRefused,
  kReleaseToAnnouncementMs,
};

// "packets resent".
const char* Name(TransportFigure figure);
// Whether it counts since the start: counts of two streams add up. Of settings and rates the latest value
// holds.
bool IsCount(TransportFigure figure);

// In display order.
using TransportFigures = std::vector<std::pair<TransportFigure, double>>;
// None: the device does not have it.
std::optional<double> FigureIn(const TransportFigures& figures, TransportFigure figure);
// Adds what a later stream counted, and takes over its other values.
void Add(const TransportFigures& later, TransportFigures& sum);

}  // namespace ulf::acquisition
