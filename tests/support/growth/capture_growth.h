// What a capture takes as it goes on: memory, time for a frame, disk, in rows over its time; and whether one
// of them grows that must not.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "coverage/session/capture_session.h"

namespace ulf::test {

struct GrowthRow {
  double minutes = 0;  // since the beginning, by the computer's clock
  std::uint64_t frames = 0;
  std::size_t views = 0;     // in the light field
  std::size_t recorded = 0;  // the same, with those that were taken back since
  // The least of the row's time: what is open for a while (a review, an adjustment) needs memory
  // while it is open.
  double resident_mb = 0, used_mb = 0;
  // Of the capture's own work on a frame, from the frame's arrival to the decision: by the clock, and of
  // processor time in the capture's thread, which other programs do not lengthen.
  double frame_ms = 0, slow_frame_ms = 0, processor_ms = 0;  // medians, and the slowest twentieth
  double files_mb = 0, journal_mb = 0;                       // blocks taken on the disk, as `du` counts
};

// Resident, and in use without what the allocator keeps for later.
double ResidentMb();
double UsedMb();

// Fills a row from the hooks of a capture.
class GrowthLog {
 public:
  explicit GrowthLog(std::filesystem::path light_field);
  void FrameComes();                                      // CaptureHooks::keep_frame
  void FrameIsDone(const coverage::CaptureState& state);  // CaptureHooks::after_frame
  std::size_t frames_in_row() const { return frames_ms_.size(); }
  // Ends the row and begins the next one; at least one frame must have been in it.
  const GrowthRow& EndRow();
  const std::vector<GrowthRow>& rows() const { return rows_; }

 private:
  const std::filesystem::path light_field_;
  const std::chrono::steady_clock::time_point began_;
  std::chrono::steady_clock::time_point came_;
  double processor_came_s_ = 0;
  GrowthRow row_;
  std::vector<double> frames_ms_, processor_ms_;
  std::vector<GrowthRow> rows_;
};

// As lines of CSV.
std::string GrowthHead();
std::string GrowthLine(const GrowthRow& row);
// What GrowthLine wrote; none of any other line.
std::optional<GrowthRow> GrowthRowOf(const std::string& line);

struct GrowthLimits {
  double mb_a_view = 0;  // of memory in use that a recorded view may keep
  // The same with what the allocator keeps of freed memory, in the arenas of threads.
  double resident_mb_a_view = 0;
  double mb = 20;           // that memory may grow besides, over the last two thirds of the rows
  double time_share = 0.3;  // by which a frame may become slower over them
  double disk_share =
      0.25;  // by which a view's share of the disk may change from the first half of them to the second
};
// What grows beyond the limits, over the last two thirds of the rows (the first fills caches), by the median
// of the slopes between all pairs of rows (Theil and Sen), which single rows do not move. Empty: nothing
// does. At least nine rows.
std::string WhatGrows(const std::vector<GrowthRow>& rows, const GrowthLimits& limits);

// A capture of many views one after the other, as fast as they are taken: what grows with the
// number of views.
struct LongCapture {
  CameraModel camera;
  coverage::CaptureSummary summary;
  std::vector<GrowthRow> rows;
};
// `views` viewpoints of a textured plane over a cap of a hundred degrees, at 320x240, poses known: each
// becomes a view. No tracking, no geometry, no display.
LongCapture CaptureManyViews(const std::filesystem::path& light_field, int views, int rows);

}  // namespace ulf::test
