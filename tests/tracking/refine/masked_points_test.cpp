// Tests: tracking/refine/refine_input.
//
// Points that are measured under poses, and masks.
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "core/base/error.h"
#include "tests/support/test_paths.h"
#include "tracking/refine/refine_input.h"

namespace ulf::test::masked_points_test {
namespace {

TEST(WithoutMasked, ObservationsInMaskedPixelsAreLeftOut) {
  const ScratchFolder scratch;
  LightField light_field;
  light_field.root = scratch.path();
  light_field.cameras = {CameraModel::Pinhole(64, 48, 60)};
  cv::Mat mask(48, 64, CV_8UC1, cv::Scalar(255));
  mask(cv::Rect(0, 0, 32, 48)) = 0;
  cv::imwrite((scratch / "mask.png").string(), mask);
  for (const int id : {7, 8, 9}) {
    View view;
    view.id = id;
    view.image_path = std::to_string(id) + ".png";
    if (id != 9) view.mask_path = "mask.png";
    cv::imwrite((scratch / view.image_path).string(), cv::Mat(48, 64, CV_8UC3, cv::Scalar::all(90)));
    light_field.views.push_back(view);
  }
  const auto seen = [](double x) {
    ScenePoint point;
    for (const int id : {7, 8, 9}) point.track.push_back({id, {x, 20.5}});
    return point;
  };
  ScenePoint twice = seen(31.9);
  twice.track[1].in_img.x() = 32;  // outside of the mask's edge by nothing
  const auto left = tracking::WithoutMasked({seen(10), seen(50), twice}, light_field);
  ASSERT_EQ(left.size(), 2u) << "one view alone shows the first";
  EXPECT_EQ(left[0].track.size(), 3u);
  ASSERT_EQ(left[1].track.size(), 2u);
  EXPECT_EQ(left[1].track[0].view_id, 8);
  EXPECT_EQ(left[1].track[1].view_id, 9);

  // Of a light field's own points not all are known to be seen by views.
  EXPECT_EQ(tracking::WithoutMasked({ScenePoint{}}, light_field).size(), 1u);

  light_field.views[0].mask_path = "gone.png";
  EXPECT_THROW(tracking::WithoutMasked({seen(10)}, light_field), Error);
}

}  // namespace
}  // namespace ulf::test::masked_points_test
