// Where trackers fail: each case named by what happens and what shall come of it. The table is in
// docs/measured/tracking.md.
//
// Everyday: small pictures, one seed. With ULF_STABILITY=seeds: full pictures, five seeds.
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "tests/stability/situations.h"
#include "tests/support/floors.h"

namespace ulf {
namespace {

using test::Furniture;
using test::LeadThrough;
using test::Outcome;
using test::Situation;
using test::TexturedRoom;

constexpr double kWrong = 0.03;  // of the distance: farther off is a wrong pose
constexpr double kWrongDeg = 2;

bool Full() {
  const char* asked = std::getenv("ULF_STABILITY");
  return asked && std::string(asked) == "seeds";
}

// Calls check(outcome, label) for every seed.
template <typename Check>
void ForSeeds(const Situation& situation, Check&& check) {
  const CameraModel camera = Full() ? TexturedRoom::Camera() : TexturedRoom::Camera().ScaledTo(320, 240);
  const int features = Full() ? 1000 : 600;
  for (unsigned seed = 1; seed <= (Full() ? 5u : 1u); ++seed) {
    const Outcome outcome = LeadThrough(situation, seed, camera, features);
    SCOPED_TRACE("seed " + std::to_string(seed) + ", started at " + std::to_string(outcome.first_tracked) +
                 ", worst at frame " + std::to_string(outcome.worst.frame));
    EXPECT_LT(outcome.worst.center, kWrong);
    EXPECT_LT(outcome.worst.turn_deg, kWrongDeg);
    check(outcome);
  }
}

// Frames of the long run, and of the everyday one.
int Frames(int full, int everyday) { return Full() ? full : everyday; }

double BlurScale() { return Full() ? 1.0 : 0.5; }

TEST(Stability, PureRotationNeverStartsAndSaysSo) {
  for (const Furniture furniture : {Furniture::kWall, Furniture::kPanels}) {
    if (!Full() && furniture == Furniture::kPanels) continue;
    ForSeeds({.furniture = furniture, .frames = Frames(80, 30), .motion = TexturedRoom::TurningAt},
             [](const Outcome& outcome) {
               EXPECT_EQ(outcome.first_tracked, -1);
               EXPECT_GT(outcome.Told(StartObstacle::kRotationOnly), Frames(80, 30) / 2);
             });
  }
}

TEST(Stability, StandingStillNeverStartsAndSaysSo) {
  ForSeeds({.frames = Frames(60, 15), .motion = [](int) { return TexturedRoom::HandAt(0); }},
           [](const Outcome& outcome) {
             EXPECT_EQ(outcome.first_tracked, -1);
             EXPECT_GT(outcome.Told(StartObstacle::kRotationOnly), Frames(60, 15) - 5);
           });
}

TEST(Stability, AFlatWallStartsRight) {
  ForSeeds({.furniture = Furniture::kWall, .frames = Frames(120, 60)}, [](const Outcome& outcome) {
    ASSERT_GE(outcome.first_tracked, 0);
    EXPECT_EQ(outcome.Tracked(outcome.first_tracked, Frames(120, 60)),
              Frames(120, 60) - outcome.first_tracked);
  });
}

// Seen at a slant while the hand goes along it: the motion of a wall that lies across the way explains it as
// well.
TEST(Stability, SlantedWallStartsRightAfterWaiting) {
  const auto slanted = [](int k) {
    const Rigid3 turned{Eigen::Quaterniond(Eigen::AngleAxisd(50 * M_PI / 180, Eigen::Vector3d::UnitY())),
                        {0, 0, 0}};
    return turned * TexturedRoom::HandAt(k);
  };
  ForSeeds({.furniture = Furniture::kWall, .frames = Frames(120, 60), .motion = slanted},
           [](const Outcome& outcome) {
             // Larger pictures tell the two apart at once.
             EXPECT_GE(outcome.Told(StartObstacle::kAmbiguousPlane), Frames(0, 1));
             EXPECT_GE(outcome.first_tracked, 0);
           });
}

TEST(Stability, AWallAndABoxStartRight) {
  ForSeeds({.furniture = Furniture::kBox, .frames = Frames(100, 50)}, [](const Outcome& outcome) {
    ASSERT_GE(outcome.first_tracked, 0);
    EXPECT_LE(outcome.first_tracked, 45);
    EXPECT_EQ(outcome.Tracked(outcome.first_tracked, Frames(100, 50)),
              Frames(100, 50) - outcome.first_tracked);
  });
}

TEST(Stability, FollowsACorridorToTheVanishingPoint) {
  ForSeeds({.furniture = Furniture::kCorridor,
            .frames = Frames(110, 70),
            .motion = TexturedRoom::WalkingAt,
            .distance_m = 3},
           [](const Outcome& outcome) {
             ASSERT_GE(outcome.first_tracked, 0);
             EXPECT_LE(outcome.first_tracked, 60);
             EXPECT_EQ(outcome.Tracked(outcome.first_tracked, Frames(110, 70)),
                       Frames(110, 70) - outcome.first_tracked);
           });
}

// A focal length that is wrong by a hundredth leaves the walls of a whole turn apart where they should meet.
TEST(Stability, OnceAroundARoomTheLoopIsClosed) {
  const CameraModel camera = Full() ? TexturedRoom::Camera() : TexturedRoom::Camera().ScaledTo(320, 240);
  constexpr int kFrames = TexturedRoom::kRoundFrames * 11 / 10;
  for (unsigned seed = 1; seed <= (Full() ? 5u : 1u); ++seed) {
    const Outcome outcome = LeadThrough({.furniture = Furniture::kRound,
                                         .frames = kFrames,
                                         .motion = TexturedRoom::RoundAt,
                                         .distance_m = 2,
                                         .believed_focal = 1.01},
                                        seed, camera, Full() ? 1000 : 600);
    std::printf("seed %u: started at %d, %d loops, worst %.3f live at %d, %.3f after (%.2f degrees)\n", seed,
                outcome.first_tracked, outcome.loops, outcome.worst.center, outcome.worst.frame,
                outcome.worst_after.center, outcome.worst_after.turn_deg);
    SCOPED_TRACE("seed " + std::to_string(seed));
    ASSERT_GE(outcome.first_tracked, 0);
    EXPECT_EQ(outcome.Tracked(outcome.first_tracked, kFrames), kFrames - outcome.first_tracked);
    EXPECT_GE(outcome.loops, 1);
    EXPECT_LT(outcome.worst_after.center, kWrong);
    EXPECT_LT(outcome.worst_after.turn_deg, kWrongDeg);
  }
}

// Dark while the camera moves on by some tiles; then, farther, the picture shows nothing but tiles.
TEST(Stability, RepeatingTilesAreRightOrLost) {
  const auto motion = [](int k) {
    Rigid3 pose = TexturedRoom::HandAt(k);
    if (k >= 60 && k < 90) pose.translation.x() -= 2 * TexturedRoom::kTile;
    if (k >= 90) pose.translation.x() -= 6.5 * TexturedRoom::kTile;
    return pose;
  };
  const auto moment = [](int k) { return TexturedRoom::Moment{.gain = k >= 55 && k < 60 ? 0.02 : 1.0}; };
  ForSeeds({.furniture = Furniture::kTiles, .frames = Frames(120, 98), .motion = motion, .moment = moment},
           [](const Outcome& outcome) {
             ASSERT_GE(outcome.first_tracked, 0);
             EXPECT_LE(outcome.first_tracked, 50);
             EXPECT_EQ(outcome.Tracked(outcome.first_tracked, 55), 55 - outcome.first_tracked);
           });
}

TEST(Stability, FollowsThroughAMirrorAndAShadow) {
  const auto moment = [](int) { return TexturedRoom::Moment{.shadow = true}; };
  ForSeeds({.furniture = Furniture::kMirror, .frames = Frames(100, 60), .moment = moment},
           [](const Outcome& outcome) {
             ASSERT_GE(outcome.first_tracked, 0);
             EXPECT_LE(outcome.first_tracked, 40);
             EXPECT_EQ(outcome.Tracked(outcome.first_tracked, Frames(100, 60)),
                       Frames(100, 60) - outcome.first_tracked);
           });
}

TEST(Stability, AJumpOf40DegreesIsLostOrFoundNeverWrong) {
  const auto motion = [](int k) {
    Rigid3 pose = TexturedRoom::HandAt(k);
    if (k >= 60 && k < 85)
      pose = Rigid3{Eigen::Quaterniond(Eigen::AngleAxisd(50 * M_PI / 180, Eigen::Vector3d::UnitY())),
                    Eigen::Vector3d::Zero()} *
             pose;
    return pose;
  };
  ForSeeds({.frames = 100, .motion = motion}, [](const Outcome& outcome) {
    ASSERT_GE(outcome.first_tracked, 0);
    ASSERT_TRUE(outcome.tracks[59].cam_from_world);
    const int found = outcome.FoundAgain(85);
    EXPECT_TRUE(found >= 85 && found <= 87) << found;
    EXPECT_EQ(outcome.Tracked(88, 100), 12);
  });
}

TEST(Stability, FoundThreeFramesAfterASecondOfDarkness) {
  const auto moment = [](int k) { return TexturedRoom::Moment{.gain = k >= 50 && k < 80 ? 0.02 : 1.0}; };
  ForSeeds({.frames = 95, .moment = moment}, [](const Outcome& outcome) {
    ASSERT_TRUE(outcome.tracks[49].cam_from_world);
    EXPECT_EQ(outcome.Tracked(50, 80), 0);
    const int found = outcome.FoundAgain(80);
    EXPECT_TRUE(found >= 80 && found <= 82) << found;
    EXPECT_EQ(outcome.Tracked(83, 95), 12);
  });
}

TEST(Stability, HalvedExposureIsFollowedOrFoundAgain) {
  const auto moment = [](int k) { return TexturedRoom::Moment{.gain = k >= 50 ? 0.5 : 1.0}; };
  ForSeeds({.moment = moment}, [](const Outcome& outcome) {
    ASSERT_TRUE(outcome.tracks[49].cam_from_world);
    EXPECT_EQ(outcome.Tracked(53, 80), 27);
  });
}

// The hand flicks: five frames blurred by 15 px, at twice that from frame to frame.
TEST(Stability, MotionBlurOf15PxIsSurvivedOrFoundAgain) {
  const double step = 30 / 520.0;
  const auto turned = [](int k) { return k < 50 ? 0 : k < 55 ? k - 49 : k < 60 ? 5 : k < 65 ? 64 - k : 0; };
  const auto motion = [&](int k) {
    return Rigid3{Eigen::Quaterniond(Eigen::AngleAxisd(0.7 * step * turned(k), Eigen::Vector3d::UnitY())),
                  Eigen::Vector3d::Zero()} *
           TexturedRoom::HandAt(k);
  };
  const auto moment = [&](int k) {
    const bool moving = (k >= 50 && k < 55) || (k >= 60 && k < 65);
    return TexturedRoom::Moment{.blur_px = {moving ? 15 * BlurScale() : 0, 0}};
  };
  ForSeeds({.motion = motion, .moment = moment}, [](const Outcome& outcome) {
    ASSERT_TRUE(outcome.tracks[49].cam_from_world);
    const int between = outcome.FoundAgain(55), after = outcome.FoundAgain(65);
    EXPECT_TRUE(between >= 55 && between <= 57) << between;
    EXPECT_TRUE(after >= 65 && after <= 67) << after;
    EXPECT_EQ(outcome.Tracked(68, 80), 12);
  });
}

// Two keyframes can agree about all of the half that moves: it hangs by the moment when it begins.
TEST(Stability, FollowsTheStillHalfOfThePicture) {
  const int rest = Frames(60, 30);
  for (const int begins : {25, 40, 60}) {
    SCOPED_TRACE("begins to move at frame " + std::to_string(begins));
    const auto moment = [&](int k) { return TexturedRoom::Moment{.moving_half = k >= begins}; };
    ForSeeds({.frames = begins + rest, .moment = moment}, [&](const Outcome& outcome) {
      ASSERT_TRUE(outcome.tracks[static_cast<std::size_t>(begins) - 1].cam_from_world);
      EXPECT_EQ(outcome.Tracked(begins, begins + rest), rest);
    });
  }
}

// Nobody can tell which half is the world: no map starts, and why is said.
TEST(Stability, DoesNotStartOnAHalfMovingPicture) {
  const auto moment = [](int) { return TexturedRoom::Moment{.moving_half = true}; };
  ForSeeds({.frames = Frames(90, 40), .moment = moment}, [](const Outcome& outcome) {
    EXPECT_EQ(outcome.first_tracked, -1);
    EXPECT_GT(outcome.Told(StartObstacle::kConflictingMotions), Frames(45, 14));
  });
}

}  // namespace
}  // namespace ulf
