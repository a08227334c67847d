// Tests: acquisition/simulator/hand.
//
// The simulated hand: smooth, within its promises, and everywhere on the cap sooner or later.
#include <gmock/gmock.h>

#include "acquisition/simulator/hand.h"
#include "core/geometry/camera_model.h"
#include "tests/support/floors.h"

namespace ulf::simulator_hand_test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
constexpr double kDegree = M_PI / 180;

HandOptions Studio(std::uint64_t seed) {
  HandOptions options;
  options.subject_in_world = {0.1, -0.2, 0.07};
  options.first_direction = Vector3d(0.2, -0.8, 0.5).normalized();
  options.seed = seed;
  return options;
}

TEST(Hand, PositionAndVelocityAreContinuous) {
  for (const std::uint64_t seed : {1u, 7u}) {
    const Hand hand(Studio(seed));
    constexpr double kStep = 1e-3;
    double fastest_push = 0, fastest_twist = 0;
    for (double t = 0.01; t < 60; t += 0.0053) {
      const Rigid3 a = hand.CamFromWorld(t - kStep), b = hand.CamFromWorld(t),
                   c = hand.CamFromWorld(t + kStep);
      const Vector3d push =
          (a.OriginInSource() - 2 * b.OriginInSource() + c.OriginInSource()) / (kStep * kStep);
      const auto turn = [](const Rigid3& from, const Rigid3& to) {
        const Eigen::AngleAxisd angle_axis(to.rotation * from.rotation.conjugate());
        return Vector3d(angle_axis.angle() * angle_axis.axis());
      };
      fastest_push = std::max(fastest_push, push.norm());
      fastest_twist = std::max(fastest_twist, (turn(b, c) - turn(a, b)).norm() / (kStep * kStep));
    }
    // A jump of the velocity by v would show as v / kStep: 10 m/s^2 is a jump of 1 cm/s.
    EXPECT_LT(fastest_push, 10) << "seed " << seed;
    EXPECT_LT(fastest_twist, 40) << "seed " << seed;
  }
}

TEST(Hand, CoversTheCapAndThenFillsWhatIsLeft) {
  for (const std::uint64_t seed : {7u, 8u, 9u}) {
    const HandOptions options = Studio(seed);
    const Hand hand(options);
    const double first_end_s = hand.FirstPassEndS();
    EXPECT_GT(first_end_s, 60);
    EXPECT_LT(first_end_s, 200);
    std::vector<Vector2d> visited;
    const auto uncovered = [&](double radius) {
      int missed = 0, all = 0;
      for (double azimuth = -30; azimuth <= 30; azimuth += 1)
        for (double elevation = -20; elevation <= 20; elevation += 1, ++all) {
          const bool near = std::any_of(visited.begin(), visited.end(), [&](const Vector2d& angles) {
            return std::hypot((angles.x() - azimuth * kDegree) * std::cos(elevation * kDegree),
                              angles.y() - elevation * kDegree) < radius;
          });
          if (!near) ++missed;
        }
      return static_cast<double>(missed) / all;
    };
    const auto sweep = [&](double from_s, double to_s) {
      for (double t = from_s; t < to_s; t += 1 / 15.0)
        if (!hand.LooksAway(t)) visited.push_back(hand.CapAngles(hand.CamFromWorld(t).OriginInSource()));
    };
    sweep(0, first_end_s);
    EXPECT_LT(uncovered(1.5 * kDegree), 0.03) << "seed " << seed;
    const double once = uncovered(0.9 * kDegree);
    sweep(first_end_s, 2 * first_end_s);
    EXPECT_LT(uncovered(0.9 * kDegree), 0.5 * once)
        << "the second pass runs between the rows of the first, seed " << seed;
    EXPECT_LT(uncovered(1.3 * kDegree), 0.005) << "seed " << seed;
  }
}

TEST(Hand, MovesLikeAPersonWhoScans) {
  const HandOptions options = Studio(7);
  const Hand hand(options);
  std::vector<double> steps_deg;
  double nearest = 10, farthest = 0;
  for (double t = 8; t < 80; t += 1 / 15.0) {
    const Rigid3 pose = hand.CamFromWorld(t), next = hand.CamFromWorld(t + 1 / 15.0);
    const Vector2d step = hand.CapAngles(next.OriginInSource()) - hand.CapAngles(pose.OriginInSource());
    steps_deg.push_back(std::abs(step.x()) / kDegree);
    const double distance = (pose.OriginInSource() - options.subject_in_world).norm();
    nearest = std::min(nearest, distance);
    farthest = std::max(farthest, distance);
  }
  std::nth_element(steps_deg.begin(), steps_deg.begin() + static_cast<std::ptrdiff_t>(steps_deg.size() / 2),
                   steps_deg.end());
  EXPECT_GT(steps_deg[steps_deg.size() / 2], 0.5);
  EXPECT_LT(steps_deg[steps_deg.size() / 2], 1.0);
  EXPECT_GT(nearest, 0.93);
  EXPECT_LT(farthest, 1.07);
  EXPECT_GT(farthest - nearest, 0.03) << "the distance changes";
  // Sideways translation before anything else, so that one camera can initialise.
  EXPECT_GT((hand.CamFromWorld(1.8).OriginInSource() - hand.CamFromWorld(0).OriginInSource()).norm(), 0.04);
}

TEST(Hand, LooksAwayNowAndThenAndComesBackToWhereItWas) {
  const HandOptions options = Studio(7);
  const Hand hand(options);
  const CameraModel camera = CameraModel::Pinhole(640, 480, 560);
  const auto subject_in_frame = [&](double t) {
    const auto img = camera.ImgFromCam(hand.CamFromWorld(t) * options.subject_in_world);
    return img && camera.Contains(*img);
  };
  int glances = 0, out_of_frame = 0, lost_without_glance = 0;
  double since_s = 0;
  for (double t = 0; t < 120; t += 0.05) {
    const bool away = hand.LooksAway(t);
    if (away && !hand.LooksAway(t - 0.05)) {
      ++glances;
      since_s = t;
    }
    if (!away && hand.LooksAway(t - 0.05)) {
      EXPECT_LT(t - since_s, 2) << "about a second";
      const Vector2d before = hand.CapAngles(hand.CamFromWorld(since_s).OriginInSource());
      const Vector2d after = hand.CapAngles(hand.CamFromWorld(t).OriginInSource());
      EXPECT_LT((after - before).norm(), 2.5 * kDegree) << "the hand rests while the head turns";
    }
    if (!subject_in_frame(t)) ++(away ? out_of_frame : lost_without_glance);
  }
  EXPECT_GE(glances, 3);
  EXPECT_GT(out_of_frame, 3 * glances);
  EXPECT_EQ(lost_without_glance, 0);

  HandOptions steady = options;
  steady.looks_away = false;
  const Hand without(steady);
  for (double t = 0; t < 120; t += 0.5) EXPECT_FALSE(without.LooksAway(t));
}

TEST(Hand, GoesOnForHoursAndThenRests) {
  const Hand hand(Studio(7));
  for (const double t : {3600.0, 7200.0, 20000.0}) {
    const Vector2d angles = hand.CapAngles(hand.CamFromWorld(t).OriginInSource());
    EXPECT_TRUE(angles.allFinite()) << t;
    EXPECT_LT(std::abs(angles.x()), 36 * kDegree) << t;
    EXPECT_LT(std::abs(angles.y()), 26 * kDegree) << t;
  }
}

}  // namespace
}  // namespace ulf::simulator_hand_test
