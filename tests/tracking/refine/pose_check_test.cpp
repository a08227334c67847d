// Tests: tracking/refine/pose_check.
#include "tracking/refine/pose_check.h"

#include <gmock/gmock.h>

#include <algorithm>

#include "core/light_field/light_field_io.h"
#include "tests/support/test_paths.h"
#include "tests/tracking/refine/refine_views.h"
#include "tracking/refine/light_field_input.h"

namespace ulf::test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::vector<std::string> NamesOf(const RefineInput& input) {
  std::vector<std::string> names;
  for (const RefineInput::View& view : input.views) names.push_back(view.name);
  return names;
}

TEST(PoseCheck, RightPosesAgreeAlsoWhereTheyAreALittleOff) {
  for (const double shift : {0.0, 0.005}) {
    const auto views = MakeViews(12, shift, 20 * shift, 3);
    const PoseCheck check = CheckPoses(views->input);
    EXPECT_THAT(check.disagree, IsEmpty()) << shift;
    EXPECT_GE(check.agree, 11) << shift;
    EXPECT_EQ(InWords(check, NamesOf(views->input)), "");
    EXPECT_EQ(check.error_px < 0.5, shift == 0) << check.error_px;
  }
}

TEST(PoseCheck, PosesOfOtherPhotographsAreNamed) {
  const auto views = MakeViews(12, 0, 0, 4);
  std::swap(views->images[3], views->images[7]);
  const PoseCheck swapped = CheckPoses(views->input);
  EXPECT_THAT(swapped.disagree, ElementsAre(3, 7));
  EXPECT_THAT(InWords(swapped, NamesOf(views->input)), HasSubstr("2 of 12 views"));
  EXPECT_THAT(InWords(swapped, NamesOf(views->input)), HasSubstr("view 3, view 7"));

  std::ranges::reverse(views->images);
  const PoseCheck turned = CheckPoses(views->input);
  EXPECT_GE(turned.disagree.size(), 8u);
  EXPECT_THAT(InWords(turned, NamesOf(views->input)), HasSubstr("in another order"));
}

TEST(PoseCheck, WhatCannotBeToldIsNotBlamed) {
  const auto views = MakeViews(8, 0, 0, 5);
  for (Image& image : views->images) image.pixels.setTo(cv::Scalar::all(90));
  const PoseCheck plain = CheckPoses(views->input);
  EXPECT_THAT(plain.disagree, IsEmpty());
  EXPECT_EQ(plain.untold, 8);
  views->input.read = [](int) -> Image { throw std::runtime_error("gone"); };
  EXPECT_EQ(CheckPoses(views->input).unread.size(), 8u);
}

TEST(PoseCheck, RealSetsAgree) {
  ULF_NEED_TEST_DATA(fox, "fox_half");
  const LightField light_field = ReadLightField(fox);
  const PoseCheck check = CheckPoses(tracking::RefineInputOf(light_field));
  EXPECT_THAT(check.disagree, IsEmpty());
  EXPECT_GE(check.agree, 48);
}

}  // namespace
}  // namespace ulf::test
