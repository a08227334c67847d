// Tests: coverage/simulated_operator/rows_by_eye.
#include "coverage/simulated_operator/rows_by_eye.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/floors.h"
#include "tests/support/staged_capture.h"

namespace ulf::test::rows_by_eye_test {
namespace {

constexpr double kDegree = M_PI / 180;

TEST(RowsByEye, GoAlongARowAndBackAlongTheNext) {
  StagedCapture capture({.cap = Cap::ParseDegrees("60x40")});
  capture.Record(capture.CameraAt(0, 0));
  const auto at = [&](double azimuth_deg, double elevation_deg) {
    return *ShownSphere::Of(*capture.At(capture.CameraAt(azimuth_deg, elevation_deg)));
  };
  for (const std::uint64_t seed : {1, 2, 3}) {
    RowsByEye rows(seed, false), again(seed, false);
    const auto first = rows.Toward(at(0, 0), 0);
    ASSERT_TRUE(first);
    const double level_deg = first->elevation / kDegree;
    EXPECT_GT(std::abs(level_deg), 12) << "the first row is at an edge of the cap";
    EXPECT_LT(std::abs(level_deg), 21);
    EXPECT_EQ(again.Toward(at(0, 0), 0)->elevation, first->elevation) << "of the seed alone";
    // On the row it goes on to the rim, and there the next one begins, nearer to the middle.
    const double side = rows.Toward(at(0, level_deg), 1)->azimuth > 0 ? 1 : -1;
    EXPECT_GT(std::abs(rows.Toward(at(20 * side, level_deg), 2)->azimuth), 20 * kDegree);
    const auto next = rows.Toward(at(29.9 * side, level_deg), 3);
    ASSERT_TRUE(next);
    EXPECT_LT(std::abs(next->elevation), std::abs(first->elevation));
  }
}

TEST(RowsByEye, KnowNothingBeforeADiscIsDrawn) {
  StagedCapture capture;
  RowsByEye rows(1, false);
  EXPECT_FALSE(rows.Toward(*ShownSphere::Of(*capture.At(capture.CameraAt(0, 0))), 0));
}

}  // namespace
}  // namespace ulf::test::rows_by_eye_test
