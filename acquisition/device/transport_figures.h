// Names the figures of a device's transport (packets, buffers, photographs), and says which are counts.
// docs/measured/cameras.md says what the figures of GigE Vision count, and which are not reliable.
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

// Returns the name for people: "packets resent".
const char* Name(TransportFigure figure);
// Returns whether the figure counts since the start, so that counts of two streams add up. For settings and
// rates the latest value holds.
bool IsCount(TransportFigure figure);

// Figures with their values, in display order.
using TransportFigures = std::vector<std::pair<TransportFigure, double>>;
// Returns the value of a figure; none if the device does not have it.
std::optional<double> FigureIn(const TransportFigures& figures, TransportFigure figure);
// Adds the counts of a later stream to `sum`, and takes over its other values.
void Add(const TransportFigures& later, TransportFigures& sum);

}  // namespace ulf::acquisition
