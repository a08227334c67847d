// Measures what a capture takes as it goes on (memory, time for a frame, disk) in rows over its time, and
// finds out whether one of them grows that must not.
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
  double minutes = 0;        // since the beginning, by the computer's clock
  std::uint64_t frames = 0;  // since the beginning
  std::size_t views = 0;     // in the light field
  std::size_t recorded = 0;  // the same, with those that were taken back since
  // The least during the row: a review or an adjustment needs memory while it is open.
  double resident_mb = 0, used_mb = 0;
  // The capture's own work on a frame, from its arrival to the decision: the median and the 95th percentile
  // by the clock, and the median in processor time of its thread, which other programs do not lengthen.
  double frame_ms = 0, slow_frame_ms = 0, processor_ms = 0;
  double files_mb = 0, journal_mb = 0;  // all files but the journal, and it; in whole blocks of 4 kB
};

// Return this process's memory: resident, and in use without what the allocator keeps for later.
double ResidentMb();
double UsedMb();

// Fills rows from the hooks of a capture.
class GrowthLog {
 public:
  explicit GrowthLog(std::filesystem::path light_field);
  void FrameComes();                                      // call it from CaptureHooks::keep_frame
  void FrameIsDone(const coverage::CaptureState& state);  // call it from CaptureHooks::after_frame
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

// Return the columns' names and a row as lines of CSV.
std::string GrowthHead();
std::string GrowthLine(const GrowthRow& row);
// Returns the row that GrowthLine() wrote; none for any other line.
std::optional<GrowthRow> GrowthRowOf(const std::string& line);

struct GrowthLimits {
  double mb_a_view = 0;  // memory in use that a recorded view may keep
  // The same with what the allocator keeps of freed memory, in the arenas of threads.
  double resident_mb_a_view = 0;
  double mb = 20;            // how much memory may grow besides, over the last two thirds of the rows
  double time_share = 0.3;   // by how much a frame may become slower over them
  double disk_share = 0.25;  // by how much a view's disk space may change from their first half to the second
};
// Returns what grows beyond the limits, over the last two thirds of the rows (the first third fills caches),
// by the median of the slopes between all pairs of rows (Theil and Sen), which single rows do not move.
// Empty: nothing does. Throws Error for fewer than nine rows.
std::string WhatGrows(const std::vector<GrowthRow>& rows, const GrowthLimits& limits);

struct LongCapture {
  CameraModel camera;
  coverage::CaptureSummary summary;
  std::vector<GrowthRow> rows;
};
// Captures so many viewpoints of a textured plane over a cap of a hundred degrees, at 320x240 with known
// poses, as fast as frames are taken: each becomes a view. There is no tracking, geometry or display.
LongCapture CaptureManyViews(const std::filesystem::path& light_field, int views, int rows);

}  // namespace ulf::test
