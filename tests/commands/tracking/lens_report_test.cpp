// Tests: commands/tracking/lens_report.
#include "commands/tracking/lens_report.h"

#include <gmock/gmock.h>

namespace ulf::commands {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

tracking::LensEstimate Fit(const CameraModel& lens) {
  return {.free = {.principal_point = true}, .lens = lens, .gain = 40, .principal_point_sigma_px = 0.04};
}

// Evidence can be strong for a difference that no picture shows.
TEST(LensFitText, OnlyWhatPicturesShowIsAReasonToTakeOver) {
  const CameraModel given = CameraModel::Pinhole(640, 480, 560);
  CameraModel near = given, far = given;
  near.cy += 0.4;
  far.cy += 3;
  EXPECT_THAT(LensFitText(Fit(near), std::vector{given}, false),
              StartsWith("the intrinsics are right within 0.4 px"));
  EXPECT_THAT(
      LensFitText(Fit(far), std::vector{given}, false),
      testing::AllOf(HasSubstr("--intrinsics takes them over"), HasSubstr("320.00 243.00 px (± 0.04)")));
  EXPECT_THAT(LensFitText(Fit(near), std::vector{given}, true), StartsWith("new intrinsics: "));
}

// The lens that is nearest counts: a light field may have several, of several sizes.
TEST(LensFitText, IsComparedWithTheLensThatItIsOf) {
  CameraModel distorted = CameraModel::Pinhole(640, 480, 560);
  distorted.distortion = Distortion::kRadialTangential;
  distorted.coefficients[0] = -0.2;
  const std::vector lenses{CameraModel::Pinhole(320, 240, 280), distorted};
  EXPECT_THAT(LensFitText(Fit(distorted), lenses, false),
              StartsWith("the intrinsics are right within 0.0 px"));
  EXPECT_THAT(LensFitText(Fit(CameraModel::Pinhole(640, 480, 560)), lenses, false),
              StartsWith("the images support other intrinsics"));
}

}  // namespace
}  // namespace ulf::commands
