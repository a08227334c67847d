// Tests: tracking/map/lens_watch, tracking/estimation/calibration_check.
// A lens that is given wrong is noticed while the camera still moves.
#include "tracking/map/lens_watch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "core/base/quantile.h"
#include "core/geometry/trajectory.h"
#include "tests/support/test_run.h"
#include "tests/tracking/scenes/textured_room.h"
#include "tracking/estimation/lens_evidence.h"
#include "tracking/map/pose_error.h"
#include "tracking/tracker/tracker.h"

namespace ulf::test::lens_watch_test {
namespace {

using tracking::CalibrationCheck;
using tracking::LensWatch;
using tracking::Tracker;

CalibrationCheck FocalOff(double fitted_px) {
  return {.given_focal_px = 500,
          .fitted_focal_px = fitted_px,
          .sigma_px = 1,
          .determined = true,
          .focal_wrong = std::abs(fitted_px - 500) > 10};
}

TEST(LensWatch, TwoChecksMustAgree) {
  LensWatch watch;
  EXPECT_FALSE(watch.IsDue(7));
  ASSERT_TRUE(watch.IsDue(8));
  watch.Note(FocalOff(550), 8);
  EXPECT_FALSE(watch.contradiction()) << "one alone";
  EXPECT_FALSE(watch.IsDue(9)) << "the map has hardly grown";
  ASSERT_TRUE(watch.IsDue(10));
  watch.Note(FocalOff(530), 10);
  EXPECT_FALSE(watch.contradiction()) << "they say different things";
  watch.Note(FocalOff(533), 13);
  ASSERT_TRUE(watch.contradiction());
  EXPECT_EQ(watch.contradiction()->fitted_focal_px, 533);
  watch.Note(FocalOff(560), 15);
  ASSERT_TRUE(watch.contradiction()) << "wrong in another way is not right";
  EXPECT_EQ(watch.contradiction()->fitted_focal_px, 533);
  watch.Note(FocalOff(501), 17);
  EXPECT_FALSE(watch.contradiction()) << "the larger map agrees with the lens";
  watch.Note(FocalOff(540), 22);
  watch.Reset();
  watch.Note(FocalOff(540), 8);
  EXPECT_FALSE(watch.contradiction()) << "the check before was of another map";
}

TEST(LensWatch, DistortionCountsWhereFocalLengthsDiffer) {
  CalibrationCheck bent = FocalOff(500);
  bent.distortion_wrong = true;
  bent.fitted_k1 = -0.2;
  LensWatch watch;
  watch.Note(bent, 8);
  bent.fitted_k1 = -0.21;
  watch.Note(bent, 10);
  ASSERT_TRUE(watch.contradiction());
  EXPECT_THAT(watch.contradiction()->Text(), ::testing::HasSubstr("k1 of -0.210"));
}

TEST(LensWatch, AGuessIsSoughtAgainUntilItSettles) {
  LensWatch watch;
  EXPECT_FALSE(watch.IsSearchDue(19));
  ASSERT_TRUE(watch.IsSearchDue(20));
  watch.SearchDone(20, 500, 520);
  EXPECT_FALSE(watch.IsSearchDue(31));
  ASSERT_TRUE(watch.IsSearchDue(32));
  watch.SearchDone(32, 520, 521);
  EXPECT_FALSE(watch.IsSearchDue(1000)) << "it has settled";
  watch.Reset();
  EXPECT_TRUE(watch.IsSearchDue(20)) << "another map";
  watch.SearchDone(9, 500, 500);
  EXPECT_TRUE(watch.IsSearchDue(20)) << "a young map does not settle it";
}

TEST(LensWatch, UnfittingLensIsSaidWithoutAValue) {
  CameraModel given = CameraModel::Pinhole(640, 480, 1050), fitted = CameraModel::Pinhole(640, 480, 1650);
  fitted.distortion = Distortion::kRadialTangential;
  fitted.coefficients[0] = 1.4;
  EXPECT_NEAR(tracking::DistortionAtCorner(fitted), 1.4 * 400 * 400 / (1650.0 * 1650), 1e-9);
  EXPECT_FALSE(tracking::IsPlausible(fitted, given));
  EXPECT_TRUE(tracking::IsPlausible(CameraModel::Pinhole(640, 480, 1650), given)) << "without distortion";
  fitted.coefficients[0] = -1.4;
  EXPECT_TRUE(tracking::IsPlausible(fitted, given)) << "barrels are common";
  CalibrationCheck check = FocalOff(500);
  check.no_lens_fits = true;
  LensWatch watch;
  watch.Note(check, 8);
  watch.Note(check, 10);
  ASSERT_TRUE(watch.contradiction());
  EXPECT_THAT(watch.contradiction()->Advice(FrameSource::kCamera),
              testing::AllOf(testing::HasSubstr("no real lens near it"), testing::HasSubstr("too long")));
  watch.Note(FocalOff(540), 13);
  EXPECT_TRUE(watch.contradiction() && watch.contradiction()->no_lens_fits)
      << "that is another contradiction";
}

// The room's pictures as a lens takes them.
class LensInTheRoom {
 public:
  explicit LensInTheRoom(const CameraModel& lens) : lens_(lens) {
    at_.create(lens.height, lens.width, CV_32FC2);
    for (int y = 0; y < lens.height; ++y)
      for (int x = 0; x < lens.width; ++x) {
        const auto ray = lens.RayFromImg({x + 0.5, y + 0.5});
        const auto img = ray ? TexturedRoom::Camera().ImgFromCam(*ray) : std::nullopt;
        at_.at<cv::Vec2f>(y, x) =
            img ? cv::Vec2f(static_cast<float>(img->x() - 0.5), static_cast<float>(img->y() - 0.5))
                : cv::Vec2f(-9, -9);
      }
  }
  // Seconds from the first pose until the lens was doubted; none: it was not.
  std::optional<double> DoubtedAfter(const CameraModel& given, unsigned seed,
                                     CalibrationCheck* check = nullptr,
                                     Furniture furniture = Furniture::kPanels) {
    const TexturedRoom room({.furniture = furniture, .seed = seed});
    Tracker tracker(given, {.deterministic = true, .seed = seed});
    std::optional<double> first;
    for (int i = 0; i < 100; ++i) {
      Frame frame = room.Take(TexturedRoom::HandAt(3 * i), static_cast<std::uint64_t>(i));
      cv::Mat bent;
      cv::remap(frame.image.pixels, bent, at_, cv::noArray(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
      frame.image.pixels = bent;
      const tracking::Track track = tracker.Step(frame);
      if (track.cam_from_world && !first) first = frame.device_time_s;
      if (!track.wrong_lens) continue;
      const auto known = tracker.Statistics().calibration;
      if (!known) return std::nullopt;
      if (check) *check = *known;
      return 3 * (frame.device_time_s - *first);  // every third of the hand's frames is taken
    }
    return std::nullopt;
  }

 private:
  CameraModel lens_;
  cv::Mat at_;
};

TEST(LensWatch, TrackerDoubtsAWrongFocalLength) {
  LensInTheRoom lens(TexturedRoom::Camera());
  for (const double factor : {0.95, 1.15}) {
    CameraModel given = TexturedRoom::Camera();
    given.fx *= factor;
    given.fy *= factor;
    CalibrationCheck check;
    const auto after_s = lens.DoubtedAfter(given, 15, &check);
    ASSERT_TRUE(after_s) << factor;
    EXPECT_LT(*after_s, 6) << factor;
    EXPECT_TRUE(check.focal_wrong);
    EXPECT_NEAR(check.fitted_focal_px, 520, 0.02 * 520) << factor;
  }
}

TEST(LensWatch, TheTrackerDoubtsAPrincipalPointThatIsOff) {
  LensInTheRoom lens(TexturedRoom::Camera());
  CameraModel given = TexturedRoom::Camera();
  given.cx += 30;
  CalibrationCheck check;
  ASSERT_TRUE(lens.DoubtedAfter(given, 15, &check));
  EXPECT_TRUE(check.center_wrong);
  EXPECT_FALSE(check.focal_wrong);
  EXPECT_NEAR(check.fitted_center_px.x(), TexturedRoom::Camera().cx, 8);
  EXPECT_THAT(check.Text(), ::testing::HasSubstr("principal point"));
}

// What is left of the error under each use of a lens that is 15 % too long.
TEST(LensWatch, TheTrackerGoesOnWithTheLensThatFits) {
  const TexturedRoom room({.seed = 15});
  CameraModel wrong = TexturedRoom::Camera();
  wrong.fx *= 1.15;
  wrong.fy *= 1.15;
  struct Run {
    double rms = 0;
    int revisions = 0;
    std::optional<tracking::RefinedLens> refined;
    std::optional<CalibrationCheck> check;
  };
  const auto run = [&](const CameraModel& given, tracking::LensUse use) {
    Tracker tracker(given, {.deterministic = true, .seed = 15, .lens = use});
    std::vector<TimedPose> truth;
    std::vector<std::pair<double, tracking::Track>> tracks;
    Run result;
    for (int i = 0; i < 100; ++i) {
      const Frame frame = room.Take(TexturedRoom::HandAt(3 * i), static_cast<std::uint64_t>(i));
      const tracking::Track track = tracker.Step(frame);
      result.revisions = track.lens_revision;
      EXPECT_FALSE(use == tracking::LensUse::kFixed && track.wrong_lens);
      truth.push_back({frame.device_time_s, TexturedRoom::HandAt(3 * i)});
      if (track.anchor) tracks.emplace_back(frame.device_time_s, track);
    }
    tracker.Finish();
    std::vector<TimedPose> found;
    for (const auto& [time_s, track] : tracks) found.push_back({time_s, *tracker.PoseNow(track)});
    EXPECT_GT(found.size(), 70u);
    result.rms = CompareTrajectories(found, truth, 1e-6).value().ate_rmse;
    result.refined = tracker.Statistics().refined_lens;
    result.check = tracker.Statistics().calibration;
    return result;
  };
  const Run right = run(TexturedRoom::Camera(), tracking::LensUse::kRefine);
  const Run fixed = run(wrong, tracking::LensUse::kFixed);
  const Run refined = run(wrong, tracking::LensUse::kRefine);
  EXPECT_FALSE(right.refined) << "a right lens stays";
  EXPECT_FALSE(fixed.refined);
  EXPECT_FALSE(fixed.check) << "a fixed lens is not checked";
  ASSERT_TRUE(refined.refined);
  EXPECT_GE(refined.revisions, 1) << "while the hand moves";
  EXPECT_NEAR(refined.refined->camera.fx, TexturedRoom::Camera().fx, 0.01 * TexturedRoom::Camera().fx);
  EXPECT_GT(fixed.rms, 5 * right.rms);
  EXPECT_LT(refined.rms, 2 * right.rms);
}

// Too near to the right one to be contradicted, and still replaced: nobody has measured it.
TEST(LensWatch, ReplacesAnUncontradictedGuess) {
  const TexturedRoom room({.seed = 15});
  CameraModel guess = TexturedRoom::Camera();
  guess.fx *= 1.012;
  guess.fy *= 1.012;
  Tracker tracker(guess,
                  {.deterministic = true,
                   .seed = 15,
                   .lens = tracking::LensUse::kRefine,
                   .lens_is_guess = true,
                   .mapping = {.keyframe_moved = 0.012, .keyframe_turned_deg = 4, .superfluous_share = 2}});
  int revisions = 0;
  for (int i = 0; i < 90; ++i)
    revisions =
        tracker.Step(room.Take(TexturedRoom::HandAt(3 * i), static_cast<std::uint64_t>(i))).lens_revision;
  EXPECT_GE(revisions, 1) << "while the hand moves";
  tracker.Finish();
  const auto refined = tracker.Statistics().refined_lens;
  ASSERT_TRUE(refined);
  EXPECT_NEAR(refined->camera.fx, TexturedRoom::Camera().fx, 0.004 * TexturedRoom::Camera().fx);
}

TEST(LensWatch, TheTrackerDoubtsAMissingDistortion) {
  CameraModel bent = TexturedRoom::Camera();
  bent.distortion = Distortion::kRadialTangential;
  bent.coefficients[0] = -0.2;
  LensInTheRoom lens(bent);
  CalibrationCheck check;
  const auto after_s = lens.DoubtedAfter(TexturedRoom::Camera(), 15, &check);
  ASSERT_TRUE(after_s);
  EXPECT_LT(*after_s, 6);
  EXPECT_TRUE(check.distortion_wrong);
  EXPECT_NEAR(check.fitted_k1, -0.2, 0.06);
}

TEST(LensWatch, TheTrackerTrustsARightLens) {
  LensInTheRoom lens(TexturedRoom::Camera());
  for (const unsigned seed : SeedsOf({15, 16}))
    EXPECT_FALSE(lens.DoubtedAfter(TexturedRoom::Camera(), seed)) << "seed " << seed;
}

// A flat wall tells little of the lens; what it does tell must not be a right one's fault.
TEST(LensWatch, TrackerTrustsARightLensBeforeAWall) {
  LensInTheRoom lens(TexturedRoom::Camera());
  for (const unsigned seed : SeedsOf({31, 32, 33}))
    EXPECT_FALSE(lens.DoubtedAfter(TexturedRoom::Camera(), seed, nullptr, Furniture::kWall))
        << "seed " << seed;
}

// Poses under a lens that the images contradict say what it does to them; no pose of such a map could tell.
TEST(LensWatch, QualityKnowsWhatAWrongLensDoesToPoses) {
  const TexturedRoom room({.seed = 17});
  for (const double factor : {0.95}) {
    CameraModel given = TexturedRoom::Camera();
    given.fx *= factor;
    given.fy *= factor;
    Tracker tracker(given, {.deterministic = true, .seed = 17});
    std::vector<TimedPose> found, known;
    std::vector<double> predicted, by_matches;
    for (int i = 0; i < 100; ++i) {
      const Rigid3 truth = TexturedRoom::HandAt(3 * i);
      const tracking::Track track = tracker.Step(room.Take(truth, static_cast<std::uint64_t>(i)));
      if (!track.wrong_lens) {
        EXPECT_EQ(track.lens_error_share, 0);
        continue;
      }
      ASSERT_TRUE(track.cam_from_world);
      found.push_back({i / 10.0, *track.cam_from_world});
      known.push_back({i / 10.0, truth});
      predicted.push_back(tracking::ErrorShareOf(track.quality));
      by_matches.push_back(*track.PictureSigma() / track.distance);
    }
    ASSERT_GT(found.size(), 30u);
    const auto errors = CompareTrajectories(found, known, 0.01);
    ASSERT_TRUE(errors);
    const double true_m = errors->ate_rmse;
    constexpr double kDistance_m = 2;  // about what the hand is from the panels
    EXPECT_GT(Median(predicted), true_m / kDistance_m / 2.5) << factor;
    EXPECT_LT(Median(predicted), true_m / kDistance_m * 2.5) << factor;
    EXPECT_LT(Median(by_matches), true_m / kDistance_m / 2.5) << factor << ": else this tests nothing";
  }
}

}  // namespace
}  // namespace ulf::test::lens_watch_test
