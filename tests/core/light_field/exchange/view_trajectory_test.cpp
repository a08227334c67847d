// Tests: core/light_field/exchange/view_trajectory.
#include "core/light_field/exchange/view_trajectory.h"

#include <gtest/gtest.h>

#include <vector>

namespace ulf::view_trajectory_test {
namespace {

struct Times {
  double device_s = 0, host_s = 0;
};

LightField TakenAt(const std::vector<Times>& times) {
  LightField light_field;
  for (const Times& each : times) {
    View view;
    view.id = static_cast<int>(light_field.views.size()) + 3;
    view.device_time_s = each.device_s;
    view.host_time_s = each.host_s;
    view.cam_from_world.translation.x() = view.id;
    light_field.views.push_back(view);
  }
  return light_field;
}

std::vector<double> TimesOf(const ViewTrajectory& trajectory) {
  std::vector<double> times_s;
  for (const TimedPose& pose : trajectory.poses) times_s.push_back(pose.time_s);
  return times_s;
}

TEST(ViewTrajectory, HasTheTimesOfTheCamera) {
  const ViewTrajectory trajectory = TrajectoryOf(TakenAt({{0, 1000}, {0.5, 1000.4}, {2, 1002}}));
  EXPECT_EQ(trajectory.times, TrajectoryTimes::kDevice);
  EXPECT_EQ(TimesOf(trajectory), (std::vector{0.0, 0.5, 2.0}));
  EXPECT_EQ(trajectory.poses[1].cam_from_world.translation.x(), 4);
}

// The camera was switched off between two sessions, and its clock began at 0 again.
TEST(ViewTrajectory, HasTimesThatGrowOverSessions) {
  const ViewTrajectory trajectory = TrajectoryOf(TakenAt({{1, 1000}, {9, 1008}, {1, 5000}, {9.5, 5008}}));
  EXPECT_EQ(trajectory.times, TrajectoryTimes::kHost);
  EXPECT_EQ(TimesOf(trajectory), (std::vector{1000.0, 1008.0, 5000.0, 5008.0}));
}

TEST(ViewTrajectory, CountsViewsWhereNoTimesAreKnown) {
  for (const LightField& light_field :
       {TakenAt({{}, {}, {}}), TakenAt({{1, 0}, {1, 1000}, {2, 1001}}), TakenAt({{2, 7}, {1, 7}, {3, 8}})}) {
    const ViewTrajectory trajectory = TrajectoryOf(light_field);
    EXPECT_EQ(trajectory.times, TrajectoryTimes::kNumbers);
    EXPECT_EQ(TimesOf(trajectory), (std::vector{3.0, 4.0, 5.0}));
  }
  EXPECT_EQ(TimesOf(TrajectoryOf(TakenAt({{}}))), std::vector{3.0});
  EXPECT_EQ(TimesOf(TrajectoryOf(TakenAt({{5, 0}}))), std::vector{5.0});
}

}  // namespace
}  // namespace ulf::view_trajectory_test
