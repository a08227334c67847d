#include "tests/support/growth/capture_growth.h"

#include <fmt/format.h>
#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>

#include "core/base/error.h"
#include "core/base/host_time.h"
#include "core/base/quantile.h"
#include "tests/support/test_run.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
extern "C" std::size_t __sanitizer_get_current_allocated_bytes();  // GCC ships no header for it
#endif

namespace ulf::test {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

double BlocksMb(double bytes) { return 4096 * std::ceil(bytes / 4096) / 1e6; }

// Files come and go while it is counted.
double FolderMb(const fs::path& folder) {
  double sum = 0;
  std::error_code gone;
  for (fs::recursive_directory_iterator at(folder, gone), end; !gone && at != end; at.increment(gone)) {
    std::error_code moved;
    const auto bytes = at->is_regular_file(moved) ? fs::file_size(at->path(), moved) : 0;
    if (!moved) sum += BlocksMb(static_cast<double>(bytes));
  }
  return sum;
}

using Of = std::function<double(const GrowthRow&)>;

// The median of the slopes between all pairs of rows.
double Slope(const std::vector<GrowthRow>& rows, const Of& x, const Of& y) {
  std::vector<double> slopes;
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t j = i + 1; j < rows.size(); ++j)
      if (x(rows[j]) != x(rows[i])) slopes.push_back((y(rows[j]) - y(rows[i])) / (x(rows[j]) - x(rows[i])));
  return slopes.empty() ? 0 : Median(slopes);
}

}  // namespace

double ResidentMb() {
  std::ifstream file("/proc/self/statm");
  double pages = 0, resident = 0;
  file >> pages >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

double UsedMb() {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  return static_cast<double>(__sanitizer_get_current_allocated_bytes()) / 1e6;
#else
  const auto info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd) / 1e6;
#endif
}

GrowthLog::GrowthLog(fs::path light_field) : light_field_(std::move(light_field)), began_(Clock::now()) {}

void GrowthLog::FrameComes() {
  came_ = Clock::now();
  processor_came_s_ = ThreadCpuSeconds();
}

void GrowthLog::FrameIsDone(const coverage::CaptureState& state) {
  processor_ms_.push_back(1000 * (ThreadCpuSeconds() - processor_came_s_));
  frames_ms_.push_back(1000 * SecondsSince(came_));
  const double resident_mb = ResidentMb(), used_mb = UsedMb();
  const bool first = frames_ms_.size() == 1;
  row_.resident_mb = first ? resident_mb : std::min(row_.resident_mb, resident_mb);
  row_.used_mb = first ? used_mb : std::min(row_.used_mb, used_mb);
  ++row_.frames;
  row_.views = state.view_ids.size();
  if (!state.view_ids.empty())
    row_.recorded = std::max(row_.recorded, static_cast<std::size_t>(state.view_ids.back()));
}

const GrowthRow& GrowthLog::EndRow() {
  if (frames_ms_.empty()) throw Error("no frame was in this row");
  row_.minutes = SecondsSince(began_) / 60;
  row_.frame_ms = Median(frames_ms_);
  row_.slow_frame_ms = Quantile(frames_ms_, 0.95);
  row_.processor_ms = Median(processor_ms_);
  std::error_code none;
  const auto journal = fs::file_size(light_field_ / "journal.jsonl", none);
  row_.journal_mb = none ? 0 : BlocksMb(static_cast<double>(journal));
  row_.files_mb = FolderMb(light_field_) - row_.journal_mb;
  frames_ms_.clear();
  processor_ms_.clear();
  return rows_.emplace_back(row_);
}

std::string GrowthHead() {
  return "minutes,frames,views,recorded,resident_mb,used_mb,frame_ms,slow_frame_ms,processor_ms,files_mb,"
         "journal_mb";
}

std::string GrowthLine(const GrowthRow& row) {
  return fmt::format("{:.2f},{},{},{},{:.1f},{:.1f},{:.1f},{:.1f},{:.1f},{:.1f},{:.2f}", row.minutes,
                     row.frames, row.views, row.recorded, row.resident_mb, row.used_mb, row.frame_ms,
                     row.slow_frame_ms, row.processor_ms, row.files_mb, row.journal_mb);
}

std::optional<GrowthRow> GrowthRowOf(const std::string& line) {
  GrowthRow row;
  int length = 0;
  const int read =
      std::sscanf(line.c_str(), "%lf,%lu,%zu,%zu,%lf,%lf,%lf,%lf,%lf,%lf,%lf%n", &row.minutes, &row.frames,
                  &row.views, &row.recorded, &row.resident_mb, &row.used_mb, &row.frame_ms,
                  &row.slow_frame_ms, &row.processor_ms, &row.files_mb, &row.journal_mb, &length);
  if (read != 11 || static_cast<std::size_t>(length) != line.size()) return std::nullopt;
  return row;
}

std::string WhatGrows(const std::vector<GrowthRow>& all, const GrowthLimits& limits) {
  if (all.size() < 9) throw Error("{} rows say nothing about growth; nine are needed", all.size());
  const std::vector<GrowthRow> rows(all.begin() + static_cast<std::ptrdiff_t>(all.size() / 3), all.end());
  const Of frames = [](const GrowthRow& row) { return static_cast<double>(row.frames); };
  const Of recorded = [](const GrowthRow& row) { return static_cast<double>(row.recorded); };
  const double span = frames(rows.back()) - frames(rows.front());
  const double new_views = recorded(rows.back()) - recorded(rows.front());
  std::string grows;

  const auto memory = [&](const char* name, double mb_a_view, const Of& mb) {
    const double most_mb = limits.mb + mb_a_view * new_views;
    if (const double growth = span * Slope(rows, frames, mb); growth > most_mb)
      grows += fmt::format("{} grows by {:.1f} MB, and {:.0f} more views explain {:.1f}; ", name, growth,
                           new_views, most_mb);
  };
  memory("memory in use", limits.mb_a_view, [](const GrowthRow& row) { return row.used_mb; });
  if (!kIsSanitized)  // freed pages come back late or never
    memory("resident memory", std::max(limits.mb_a_view, limits.resident_mb_a_view),
           [](const GrowthRow& row) { return row.resident_mb; });

  const Of processor_ms = [](const GrowthRow& row) { return row.processor_ms; };
  std::vector<double> times;
  for (const GrowthRow& row : rows) times.push_back(row.processor_ms);
  if (const double slower = span * Slope(rows, frames, processor_ms);
      slower > limits.time_share * Median(times))
    grows += fmt::format("a frame takes {:.1f} ms more than {:.1f}; ", slower, Median(times));

  // Where few views come, a file of another kind outweighs them.
  constexpr double kEnoughViews = 30;
  const std::vector<GrowthRow> before(rows.begin(),
                                      rows.begin() + static_cast<std::ptrdiff_t>(rows.size() / 2));
  const std::vector<GrowthRow> after(rows.begin() + static_cast<std::ptrdiff_t>(rows.size() / 2), rows.end());
  const auto more = [&](const std::vector<GrowthRow>& half) {
    return recorded(half.back()) - recorded(half.front());
  };
  if (std::min(more(before), more(after)) >= kEnoughViews) {
    const Of disk_mb = [](const GrowthRow& row) { return row.files_mb + row.journal_mb; };
    const double was = Slope(before, recorded, disk_mb), is = Slope(after, recorded, disk_mb);
    if (std::abs(is - was) > limits.disk_share * was)
      grows += fmt::format("a view takes {:.3f} MB of the disk, and took {:.3f}; ", is, was);
  }
  return grows;
}

}  // namespace ulf::test
