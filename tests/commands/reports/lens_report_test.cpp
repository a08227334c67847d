// Tests: commands/reports/lens_report.
#include "commands/reports/lens_report.h"

#include <gmock/gmock.h>

namespace ulf::commands::lens_report_test {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

tracking::LensEstimate Fit(const CameraModel& lens) {
  return {.free = {.principal_point = true}, .lens = lens, .gain = 40, .principal_point_sigma_px = 0.04};
}

// Evidence can be strong for a difference that no picture shows.
TEST(LensFitText, AdvisesOnlyWhatThePicturesShow) {
  const CameraModel given = CameraModel::Pinhole(640, 480, 560);
  CameraModel near = given, far = given;
  near.cy += 0.4;
  far.cy += 3;
  EXPECT_THAT(LensFitText(Fit(near), given, false), StartsWith("the intrinsics are right within 0.4 px"));
  EXPECT_THAT(LensFitText(Fit(far), given, false), testing::AllOf(HasSubstr("--intrinsics takes them over"),
                                                                  HasSubstr("320.00 243.00 px (± 0.04)")));
  EXPECT_THAT(LensFitText(Fit(near), given, true), StartsWith("new intrinsics: "));
}

// Two lenses must not contradict each other silently.
TEST(LensApartText, NamesBothAndWhichIsKept) {
  const CameraModel given = CameraModel::Pinhole(640, 480, 511.5);
  tracking::LensEstimate fit{.free = {.focal = true},
                             .lens = CameraModel::Pinhole(640, 480, 516.6),
                             .gain = 1200,
                             .focal_sigma_px = 0.25};
  const std::string source = "the images of the capture (± 1.6 px)";
  EXPECT_THAT(
      LensApartText(fit, given, source, true),
      testing::AllOf(HasSubstr("5.1 px (1.0 %) longer than the 511.5 px of before (from: " + source + ")"),
                     HasSubstr("the new one is kept, because")));
  EXPECT_THAT(LensApartText(fit, given, "", false), HasSubstr("the one of before is kept, because"));
  fit.focal_sigma_px = 2;
  EXPECT_EQ(LensApartText(fit, given, source, true), "") << "within the deviations";
}

}  // namespace
}  // namespace ulf::commands::lens_report_test
