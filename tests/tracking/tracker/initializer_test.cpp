// Tests: tracking/tracker/initializer, tracking/tracker/start_progress, tracking/tracker/track,
// tracking/tracker/tracker_options, tracking/map/tracked_image.
#include "tracking/tracker/initializer.h"

#include <gmock/gmock.h>

#include "tests/support/floors.h"
#include "tests/tracking/scenes/textured_room.h"
#include "tracking/tracker/track.h"

namespace ulf::initializer_test {
namespace {

using test::TexturedRoom;
using ::testing::HasSubstr;

class InitializerTest : public ::testing::Test {
 protected:
  InitializerAttempt Step(const Rigid3& cam_from_world, double gain = 1) {
    const Frame frame = room_.Take(cam_from_world, static_cast<std::uint64_t>(frame_), TexturedRoom::Camera(),
                                   {.gain = gain});
    TrackedImage image;
    image.time_s = frame_++ / 30.0;
    image.pyramid = std::make_shared<const Pyramid>(BuildPyramid(GrayForTracking(frame.image)));
    image.features = std::make_shared<const FeatureSet>(extractor_.Extract(*image.pyramid, 1700));
    return initializer_.Step(image);
  }

  const TexturedRoom room_{{}};
  FeatureExtractor extractor_{TexturedRoom::Camera()};
  Initializer initializer_{TexturedRoom::Camera(), 1};
  int frame_ = 0;
};

TEST_F(InitializerTest, StartsRightOnceParallaxSuffices) {
  EXPECT_EQ(Step(TexturedRoom::HandAt(0)).progress.obstacle, StartObstacle::kFirstView);
  for (int k = 1; k < 60; ++k) {
    const InitializerAttempt attempt = Step(TexturedRoom::HandAt(k));
    EXPECT_EQ(attempt.start.has_value(), attempt.progress.obstacle == StartObstacle::kNone) << k;
    if (!attempt.start) continue;
    EXPECT_GE(attempt.progress.parallax_deg, attempt.progress.parallax_needed_deg);
    const Rigid3 truth = TexturedRoom::HandAt(k) * TexturedRoom::HandAt(0).Inverse();
    EXPECT_GT(attempt.start->second_from_first.translation.dot(truth.translation.normalized()), 0.99);
    EXPECT_EQ(attempt.start->points.size(), attempt.start->matches.size());
    return;
  }
  FAIL() << "no start in two seconds";
}

TEST_F(InitializerTest, TurningAloneIsNamed) {
  Step(TexturedRoom::TurningAt(0));
  int named = 0;
  for (int k = 1; k <= 20; ++k) {
    const InitializerAttempt attempt = Step(TexturedRoom::TurningAt(k));
    EXPECT_FALSE(attempt.start) << k;
    named += attempt.progress.obstacle == StartObstacle::kRotationOnly;
  }
  EXPECT_GE(named, 15);
}

TEST_F(InitializerTest, DarknessIsNamed) {
  const InitializerAttempt attempt = Step(TexturedRoom::HandAt(0), 0.01);
  EXPECT_EQ(attempt.progress.obstacle, StartObstacle::kTooFewFeatures);
  EXPECT_LT(attempt.progress.matches, attempt.progress.matches_needed);
}

TEST(TrackWords, SayWhatTheOperatorCanDo) {
  EXPECT_EQ(InWords(StartProgress{StartObstacle::kLowParallax, 0.3, 0.8, 100, 60}, FrameSource::kCamera),
            "too little parallax: continue to move sideways (0.3 of 0.8 degrees of parallax)");
  EXPECT_THAT(InWords(StartProgress{StartObstacle::kTooFewFeatures, 0, 0.8, 12, 80}, FrameSource::kCamera),
              HasSubstr("(12 of 80)"));
  Track track;
  EXPECT_EQ(InWords(track, FrameSource::kCamera), "starting");
  track.state = TrackState::kTracking;
  track.matched_points = 1;
  EXPECT_EQ(InWords(track, FrameSource::kCamera), "following 1 point");
  track.state = TrackState::kLost;
  EXPECT_THAT(InWords(track, FrameSource::kCamera), HasSubstr("nothing in view is recognised"));
  track.features = 12;
  EXPECT_THAT(InWords(track, FrameSource::kCamera), HasSubstr("(12 of 80)"));
}

}  // namespace
}  // namespace ulf::initializer_test
