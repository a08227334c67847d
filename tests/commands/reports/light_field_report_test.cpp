// Tests: commands/reports/light_field_report.
#include "commands/reports/light_field_report.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "coverage/bound/criterion.h"
#include "tests/coverage/session/planar_capture.h"
#include "tests/support/floors.h"

namespace ulf::test::light_field_report_test {
namespace {

using ::testing::HasSubstr;

TEST(LightFieldReport, AngularRangeIsTheCapsOrAWholeTurn) {
  LightField light_field;
  light_field.cameras = {kCamera};
  light_field.subject = kSubject;
  for (const auto& [azimuth, elevation] :
       {std::pair{0.0, 0.0}, {-30.0, 0.0}, {30.0, 0.0}, {0.0, -20.0}, {0.0, 20.0}}) {
    View view;
    view.cam_from_world = PoseAt(azimuth, elevation);
    light_field.views.push_back(view);
  }
  const LightFieldReport cap = Describe(light_field, {});
  EXPECT_NEAR(cap.angular_range_deg->x(), 60, 1e-6);
  EXPECT_NEAR(cap.angular_range_deg->y(), 40, 1e-6);
  light_field.views.clear();
  for (int azimuth = 0; azimuth < 360; azimuth += 10) {
    View view;
    view.cam_from_world = PoseAt(azimuth, 30);
    light_field.views.push_back(view);
  }
  const LightFieldReport ring = Describe(light_field, {});
  EXPECT_NEAR(ring.angular_range_deg->x(), 350, 1e-6);
  EXPECT_NEAR(ring.angular_range_deg->y(), 0, 1e-6);
}

TEST(LightFieldReport, SaysGapsSpacingAndRedundancy) {
  LightField light_field;
  light_field.cameras = {kCamera};
  light_field.subject = kSubject;
  light_field.threshold_px = 7;
  const auto add = [&](double azimuth, double elevation, double distance = 1) {
    View view;
    view.cam_from_world = PoseAt(azimuth, elevation, distance);
    light_field.views.push_back(view);
  };
  add(0, 0);
  for (double elevation = -5; elevation <= 5; ++elevation)
    for (double azimuth = -10; azimuth <= 10; ++azimuth)
      if ((azimuth != 0 || elevation != 0) && std::hypot(azimuth - 5, elevation - 1) > 3)
        add(azimuth, elevation, azimuth < 0 ? 1 : 1.02);
  const LightFieldReport report = Describe(light_field, {.cap = Cap::ParseDegrees("18x8")});
  ASSERT_EQ(report.holes.size(), 1u);
  EXPECT_NEAR(report.holes[0].azimuth_deg, 5, 0.5);
  EXPECT_NEAR(report.holes[0].elevation_deg, 1, 0.5);
  EXPECT_NEAR(report.holes[0].area_deg2, (1 - *report.covered) * 18 * 8, 0.15 * report.holes[0].area_deg2);
  EXPECT_NEAR(report.distances->nearest, 1, 1e-9);
  EXPECT_NEAR(report.distances->farthest, 1.02, 1e-9);
  EXPECT_NE(
      ToText(report).find("gaps           one small gap: right half, 5° right and 1° up of the first view\n"),
      std::string::npos)
      << ToText(report);

  std::size_t covered_by_earlier = 0;
  const std::vector<CriterionView> views = CriterionViews(light_field);
  for (std::size_t i = 0; i < views.size(); ++i) {
    bool covered = false;
    for (std::size_t k = 0; k < i; ++k) covered |= BoundPx(views[k], views[i], kSubject) <= 7;
    covered_by_earlier += covered;
  }
  EXPECT_EQ(report.duplicates, covered_by_earlier);
  EXPECT_GT(report.duplicates, 100u);
}

// Nearest, median, farthest and mean differ.
TEST(LightFieldReport, TextAndJsonTellTheMedianDistance) {
  LightField light_field;
  light_field.cameras = {kCamera};
  light_field.subject = Subject{{1, 2, 3}, 0.2};
  for (const double distance : {4.0, 1.0, 10.0}) {
    View view;
    view.cam_from_world = LookAt({1, 2, 3 - distance}, {1, 2, 3}, {0, -1, 0});
    light_field.views.push_back(view);
  }
  const LightFieldReport report = Describe(light_field, {});
  EXPECT_NEAR(ToJson(report)["distance"]["median"], 4, 1e-9);
  EXPECT_THAT(ToText(report), HasSubstr("distances      1 to 10, median 4 (from 25 to 250 % of it)\n"));
  light_field.views.clear();
  EXPECT_TRUE(ToJson(Describe(light_field, {}))["distance"].is_null()) << "without views";
}

}  // namespace
}  // namespace ulf::test::light_field_report_test
