// Tests: coverage/session/cap_watch, coverage/bound/coverage_map.
//
// A cap that cannot be filled is said, with the smaller one that is there; whoever still gains hears nothing.
#include "coverage/session/cap_watch.h"

#include <gmock/gmock.h>

#include <cmath>
#include <vector>

#include "tests/coverage/session/planar_capture.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::test::cap_watch_test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

const Subject kSubject{{0.3, -0.2, 0.1}, 0.2};
const Eigen::Vector3d kUp = Eigen::Vector3d::UnitZ();

CriterionView ViewAt(double azimuth_deg, double elevation_deg) {
  static const CapFrame frame(Eigen::Vector3d(1, 0.4, 0.2), kUp);
  CriterionView camera;
  camera.fx = camera.fy = 600;
  camera.width = 640, camera.height = 480;
  camera.cx = 320, camera.cy = 240;
  const Eigen::Vector3d direction = frame.Direction(azimuth_deg * M_PI / 180, elevation_deg * M_PI / 180);
  return camera.AimedAt(kSubject.center_in_world, kSubject.center_in_world + 1.2 * direction, kUp);
}

CoverageMap AskedFor(const char* cap) {
  return CoverageMap(kSubject, {.cap = Cap::ParseDegrees(cap), .up_in_world = kUp, .threshold_px = 20});
}

// Views over width x height degrees about the first, without gaps.
void Fill(CoverageMap& map, double width_deg, double height_deg) {
  map.Add(ViewAt(0, 0));
  for (double elevation = -height_deg / 2; elevation <= height_deg / 2; elevation += 3)
    for (double azimuth = -width_deg / 2; azimuth <= width_deg / 2; azimuth += 3)
      map.Add(ViewAt(azimuth, elevation));
}

TEST(LargestCovered, IsTheCapThatIsCovered) {
  CoverageMap map = AskedFor("60x40");
  EXPECT_FALSE(LargestCovered(map, 0.98)) << "nothing is recorded";
  Fill(map, 30, 20);
  const auto there = LargestCovered(map, 0.98);
  ASSERT_TRUE(there);
  // Views reach over the place at which they stand by what one covers.
  EXPECT_GE(there->Degrees().x(), 30);
  EXPECT_LT(there->Degrees().x(), 48);
  EXPECT_NEAR(there->Degrees().x() / there->Degrees().y(), 1.5, 0.1) << "the shape that was asked for";
  EXPECT_NEAR(there->Degrees().x(), std::round(there->Degrees().x()), 1e-9) << "whole degrees";
  const auto share_of = [&](const Cap& cap) {
    CoverageMapOptions options = map.options();
    options.cap = cap;
    return CoverageMap(kSubject, options, map.views()).CoveredShare();
  };
  EXPECT_GE(share_of(*there), 0.98);
  EXPECT_LT(share_of({1.15 * there->width, 1.15 * there->height}), 0.98);
}

TEST(CapWatch, SaysOnceThatNothingIsGainedAndWhatIsThere) {
  CoverageMap map = AskedFor("60x40");
  Fill(map, 30, 20);
  CapWatch watch(0.98, false, FrameSource::kCamera);
  std::vector<std::string> said;
  double way_deg = 0;
  for (int turn = 0; turn < 40; ++turn)
    for (int azimuth = -15; azimuth < 15; ++azimuth, ++way_deg)
      if (const auto words =
              watch.Update(map, ViewAt(turn % 2 ? -azimuth : azimuth, 0).center_in_world, true)) {
        said.push_back(*words);
        EXPECT_GT(way_deg, 150) << "too early";
        EXPECT_LT(way_deg, 300);
      }
  ASSERT_EQ(said.size(), 1u);
  const Cap there = *LargestCovered(map, 0.98);
  EXPECT_THAT(said[0], ::testing::MatchesRegex(fmt::format(
                           "no new coverage in the last 20[0-9]° of movement; {:.0f} % still open, mostly "
                           "[0-9]+° (left|right|up|down).* of the first view\\. Finish now, or "
                           "resume with until_covered {:.0f}x{:.0f}, which is covered to 98 %",
                           100 * (1 - map.CoveredShare()), there.Degrees().x(), there.Degrees().y())));
  // One more view there, and it begins anew.
  map.Add(ViewAt(25, 0));
  EXPECT_FALSE(watch.Update(map, ViewAt(25, 0).center_in_world, true));
}

// A table turns on past what is asked for: only a whole turn that brings nothing says something.
TEST(CapWatch, WaitsForAWholeTurnOfATurntable) {
  CoverageMap map = AskedFor("60x40");
  Fill(map, 30, 6);
  CapWatch watch(0.98, true, FrameSource::kCamera);
  std::vector<std::string> said;
  for (int degree = 0; degree < 720; ++degree)
    if (const auto words = watch.Update(map, ViewAt(degree, 0).center_in_world, true)) {
      said.push_back(*words);
      EXPECT_GT(degree, 360);
      EXPECT_LT(degree, 440);
    }
  ASSERT_EQ(said.size(), 1u);
  EXPECT_THAT(said[0], ::testing::AllOf(::testing::HasSubstr("in a whole turn of the table"),
                                        ::testing::HasSubstr("set the camera higher or lower")));
}

TEST(CapWatch, IsSilentWhileSomethingIsGained) {
  CoverageMap map = AskedFor("60x40");
  map.Add(ViewAt(0, 0));
  CapWatch watch(0.98, false, FrameSource::kCamera);
  for (double elevation = -18; elevation <= 18; elevation += 3)
    for (double azimuth = -27; azimuth <= 27; azimuth += 3) {
      EXPECT_FALSE(watch.Update(map, ViewAt(azimuth, elevation).center_in_world, true));
      map.Add(ViewAt(azimuth, elevation));
    }
}

TEST(CapWatch, IsSilentWhenPausedStillOrWithoutACap) {
  CoverageMap map = AskedFor("60x40"), without(kSubject, {.up_in_world = kUp});
  Fill(map, 30, 20);
  without.Add(ViewAt(0, 0));
  CapWatch trembling(0.98, false, FrameSource::kCamera), paused(0.98, false, FrameSource::kCamera),
      free(0.98, false, FrameSource::kCamera);
  for (int i = 0; i < 2000; ++i) {
    EXPECT_FALSE(trembling.Update(map, ViewAt(i % 2 ? 0.5 : -0.5, 0).center_in_world, true));
    EXPECT_FALSE(paused.Update(map, ViewAt(15 * std::sin(0.05 * i), 0).center_in_world, false));
    EXPECT_FALSE(free.Update(without, ViewAt(15 * std::sin(0.05 * i), 0).center_in_world, true));
  }
}

// What is less than a degree is no cap that could be asked for.
TEST(LargestCovered, NamesNoneThatWouldBeRefused) {
  CoverageMap map(kSubject, {.cap = Cap::ParseDegrees("60x2"), .up_in_world = kUp, .threshold_px = 20});
  map.Add(ViewAt(0, 0));
  EXPECT_FALSE(LargestCovered(map, 0.98));
}

// The whole way, from frames to what the person hears.
TEST(CapWatch, SpeaksDuringACapture) {
  const ScratchFolder scratch;
  std::vector<PlanarShot> shots;
  for (int i = 0; i < 180; ++i) {
    const int there = i % 20;
    shots.push_back({PoseAt(i / 20 % 2 ? 20 - there : there, 0)});
  }
  CaptureOptions options = Options();
  options.cap = Cap::ParseDegrees("50x4");
  options.threshold_px = 20;
  std::vector<std::string> said;
  CaptureHooks hooks;
  hooks.say = [&](const std::string& line) { said.push_back(line); };
  const Captured captured = Capture(scratch / "lf", shots, options, {}, hooks);
  EXPECT_THAT(said, Contains(HasSubstr("no new coverage in the last")));
  EXPECT_GT(captured.light_field.views.size(), 1u);
}

// With everything else in the way of recording it is not the cap that is at fault.
TEST(CapWatch, IsSilentWhileDiskOrLightBlocks) {
  CoverageMap map = AskedFor("60x40");
  Fill(map, 30, 20);
  CapWatch watch(0.98, false, FrameSource::kCamera);
  for (int i = 0; i < 4000; ++i)
    EXPECT_FALSE(watch.Update(map, ViewAt(15 * std::sin(0.05 * i), 0).center_in_world, false));
  // It goes on counting where it was, from where the camera now is.
  EXPECT_FALSE(watch.Update(map, ViewAt(14, 0).center_in_world, true));
}

// All of it: the last cell ends the capture, whatever the sums over cells come to.
TEST(CoverageMap, AMapWithoutAnOpenCellIsCoveredWholly) {
  for (const char* cap : {"11x7", "13x5", "7.3x9.1", "20x3", "15x15"}) {
    CoverageMap map = AskedFor(cap);
    map.Add(ViewAt(0, 0));
    for (double elevation = -9; elevation <= 9; elevation += 1.5)
      for (double azimuth = -12; azimuth <= 12; azimuth += 1.5) {
        EXPECT_EQ(map.CoveredShare() == 1, map.Holes().empty());
        map.Add(ViewAt(azimuth, elevation));
      }
    EXPECT_TRUE(map.Holes().empty()) << cap;
    EXPECT_EQ(map.CoveredShare(), 1) << cap;
  }
}

TEST(CapWatch, EndsOnAWholeCap) {
  const ScratchFolder scratch;
  std::vector<PlanarShot> shots;
  for (double elevation : {0.0, 3.0, -3.0})
    for (double azimuth = -6; azimuth <= 6; azimuth += 1) shots.push_back({PoseAt(azimuth + 6, elevation)});
  CaptureOptions options = Options();
  options.cap = Cap::ParseDegrees("8x4");
  options.until_share = 1;
  options.threshold_px = 20;
  const Captured captured = Capture(scratch / "lf", shots, options);
  EXPECT_EQ(captured.summary.stopped_because, StoppedBecause::kCovered);
}

}  // namespace
}  // namespace ulf::test::cap_watch_test
