// Tests: coverage/session/capture_session, coverage/bound/view_decision.
//
// What a capture takes as it goes on: memory and a frame's time stay as they are, the disk fills by the view.
#include <gmock/gmock.h>

#include <random>

#include "tests/coverage/session/planar_capture.h"
#include "tests/support/growth/capture_growth.h"
#include "tests/support/test_paths.h"

namespace ulf::test::capture_growth_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

// Of a capture that does as it should, with the noise of a machine that does other things besides.
std::vector<GrowthRow> Rows(unsigned seed) {
  std::mt19937 random(seed);
  const auto noise = [&](double most) { return std::uniform_real_distribution<>(0, most)(random); };
  std::vector<GrowthRow> rows;
  for (int i = 0; i < 30; ++i) {
    GrowthRow row;
    row.minutes = i;
    row.frames = 100 * static_cast<std::uint64_t>(i + 1);
    row.views = row.recorded = static_cast<std::size_t>(20 * (i + 1));
    row.resident_mb = 400 + (i < 5 ? 0 : 100) + noise(10);
    row.used_mb = 200 + noise(8) + (i % 7 == 3 ? 60 : 0);  // a review is open for a whole row
    row.frame_ms = 30 + noise(40);
    row.processor_ms = 20 + noise(4) + (i % 5 == 2 ? 15 : 0);
    row.files_mb = 1.5 * static_cast<double>(row.recorded) + noise(2);
    rows.push_back(row);
  }
  return rows;
}

std::vector<GrowthRow> Changed(std::vector<GrowthRow> rows, const std::function<void(GrowthRow&)>& change) {
  for (GrowthRow& row : rows) change(row);
  return rows;
}

TEST(CaptureGrowth, RowsAreReadAsTheyAreWritten) {
  const std::string line = "16.01,3104,327,371,1243.5,512.7,332.1,940.5,89.1,561.4,0.60";
  const auto row = GrowthRowOf(line);
  ASSERT_TRUE(row);
  EXPECT_EQ(GrowthLine(*row), line);
  EXPECT_EQ(row->recorded, 371u);
  EXPECT_EQ(row->journal_mb, 0.6);
  for (const std::string& other : {std::string(), GrowthHead(), line + ",1", line.substr(0, 40)})
    EXPECT_FALSE(GrowthRowOf(other)) << other;
}

TEST(CaptureGrowth, NamesWhatGrowsAndNoNoise) {
  for (const unsigned seed : {1u, 2u, 3u, 4u}) {
    const std::vector<GrowthRow> good = Rows(seed);
    EXPECT_EQ(WhatGrows(good, {}), "") << seed;
    const auto leak = [](GrowthRow& row) { row.used_mb += 0.1 * static_cast<double>(row.recorded); };
    EXPECT_THAT(WhatGrows(Changed(good, leak), {}),
                AllOf(HasSubstr("memory in use grows by"), Not(HasSubstr("disk"))))
        << seed;
    EXPECT_EQ(WhatGrows(Changed(good, leak), {.mb_a_view = 0.12}), "") << seed << ": the views explain it";
    EXPECT_THAT(
        WhatGrows(
            Changed(good, [](GrowthRow& row) { row.processor_ms += 0.01 * static_cast<double>(row.frames); }),
            {}),
        HasSubstr("a frame takes"))
        << seed;
    EXPECT_THAT(WhatGrows(Changed(good,
                                  [](GrowthRow& row) {
                                    const double views = static_cast<double>(row.recorded);
                                    row.journal_mb = 2e-3 * views * views;
                                  }),
                          {}),
                HasSubstr("of the disk, and took"))
        << seed << ": every view writes all views";
  }
}

TEST(CaptureGrowth, ManyViewsGrowTheDiskAlone) {
  const ScratchFolder scratch;
  const LongCapture captured = CaptureManyViews(scratch / "lf", 60, 12);
  EXPECT_EQ(captured.summary.recorded, 60u);
  EXPECT_EQ(captured.summary.unwritten, 0u);
  ASSERT_EQ(captured.rows.size(), 12u);
  EXPECT_GT(captured.rows.back().files_mb, 2 * captured.rows.front().files_mb);
  // Five frames a row say little of time and of what caches still take.
  EXPECT_EQ(WhatGrows(captured.rows, {.mb_a_view = 0.1, .mb = 60, .time_share = 3, .disk_share = 1}), "");
}

TEST(CaptureGrowth, TwoThousandViewsGrowTheDiskAlone) {
  const ScratchFolder scratch;
  const LongCapture captured = CaptureManyViews(scratch / "lf", 2000, 20);
  EXPECT_EQ(captured.summary.recorded, 2000u);
  EXPECT_EQ(captured.summary.unwritten, 0u);
  for (const GrowthRow& row : captured.rows) fmt::print("{}\n", GrowthLine(row));
  EXPECT_EQ(WhatGrows(captured.rows, {.mb_a_view = 0.015, .mb = 10, .time_share = 0.3, .disk_share = 0.1}),
            "");
}

// A camera that stands, or lies on the table: its pose trembles by what the tracker is off, and one view
// is enough. The bound of a view with itself is 2 px, so that no threshold below that can be met (the
// command refuses it).
TEST(CaptureGrowth, ACameraThatStandsIsRecordedOnce) {
  for (const double threshold_px : {2.2, 7.0}) {
    const ScratchFolder scratch;
    std::mt19937 random(7);
    std::normal_distribution<double> tremble_deg(0, 0.004);  // 0.04 px of the coverage image at the subject
    std::vector<PlanarShot> shots;
    for (int i = 0; i < 40; ++i) shots.push_back({PoseAt(tremble_deg(random), tremble_deg(random))});
    CaptureOptions options = Options();
    options.threshold_px = threshold_px;
    const Captured captured = Capture(scratch / "lf", shots, options);
    EXPECT_EQ(captured.light_field.views.size(), 1u) << threshold_px;
    EXPECT_EQ(Counted(captured.summary), (Counts{{"recorded", 1}, {"covered", 39}})) << threshold_px;
  }
}

}  // namespace
}  // namespace ulf::test::capture_growth_test
