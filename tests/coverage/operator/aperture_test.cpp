// Tests: coverage/operator/posed_pictures, coverage/operator/reprojection.
//
// The augmented aperture: sharp at the subject, of pictures from places far apart.
#include <opencv2/imgproc.hpp>

#include "coverage/operator/posed_pictures.h"
#include "coverage/operator/reprojection.h"
#include "tests/coverage/operator/display_stage.h"
#include "tests/coverage/session/planar_capture.h"
#include "tests/support/floors.h"

namespace ulf::test::aperture_test {
namespace {

double Sharpness(const cv::Mat& picture, const cv::Rect& where) {
  cv::Mat gray, edges;
  cv::cvtColor(picture(where), gray, cv::COLOR_BGR2GRAY);
  cv::Laplacian(gray, edges, CV_32F);
  cv::Scalar mean, deviation;
  cv::meanStdDev(edges, mean, deviation);
  return deviation[0];
}

TEST(AugmentedAperture, IsSharpestWhereTheSubjectIs) {
  const OffscreenSurface surface({64, 64});
  const StagedCapture capture(kRendered);
  SpreadPictures spread;
  for (const double elevation : {-4.0, 0.0, 4.0})
    for (const double azimuth : {-6.0, -3.0, 3.0, 6.0})
      spread.Offer(*capture.At(capture.CameraAt(azimuth, elevation)));
  ASSERT_EQ(spread.pictures().size(), 12u);
  Reprojection reprojection;
  const Rigid3 pose = capture.CameraAt(0, 0);
  const CameraModel camera = capture.camera().ScaledTo(480, 360);
  const Eigen::Vector3d from = pose.OriginInSource(), to = capture.subject().center_in_world;
  std::map<double, double> sharpness;
  for (int i = 0; i <= 13; ++i) {
    const double distance = 0.5 + 0.1 * i;
    reprojection.Draw(camera, pose, from + distance * (to - from), spread.pictures());
    sharpness[distance] = Sharpness(reprojection.Read(), cv::Rect(200, 140, 80, 80));
  }
  const auto sharpest = std::max_element(sharpness.begin(), sharpness.end(),
                                         [](const auto& a, const auto& b) { return a.second < b.second; });
  // What is seen of a thing is its front.
  EXPECT_GE(sharpest->first, 1 - capture.subject().radius);
  EXPECT_LE(sharpest->first, 1.001);
  for (const auto& [distance, value] : sharpness) {
    if (distance > 0.7 && distance < 1.3) continue;
    EXPECT_GT(sharpest->second, 1.3 * value) << "focused at " << distance;
  }
}

// A picture on a wall is seen through the aperture as it is, where the aperture is focused on the wall and
// nowhere else.
TEST(AugmentedAperture, ShowsAPlaneAsItIs) {
  const OffscreenSurface surface({64, 64});
  std::vector<PlanarShot> shots{{PoseAt(0, 0)}};
  for (const double elevation : {-5.0, 5.0})
    for (const double azimuth : {-9.0, -3.0, 3.0, 9.0}) shots.push_back({PoseAt(azimuth, elevation)});
  PlanarDevice device(shots);
  device.Start();
  SpreadPictures spread;
  cv::Mat seen;
  while (const auto frame = device.Next(std::chrono::milliseconds(0))) {
    CaptureState state;
    state.live = frame->image;
    state.camera = kCamera;
    state.cam_from_world = frame->known_cam_from_world;
    state.points = {{Vector3d::Zero(), {160, 120}, 1}};
    if (seen.empty())
      seen = Srgb8(frame->image);
    else
      spread.Offer(state);
  }
  ASSERT_EQ(spread.pictures().size(), 8u);
  Reprojection reprojection;
  const cv::Rect middle(60, 50, 200, 140);
  const auto likeness_at = [&](double distance) {
    reprojection.Draw(kCamera, PoseAt(0, 0), {0, 0, 1 - distance}, spread.pictures());
    return Likeness(reprojection.Read(), seen, middle);
  };
  const double focused = likeness_at(1);
  EXPECT_GT(focused, 24);
  for (const double off : {0.7, 0.85, 0.93, 1.08, 1.2, 1.5})
    EXPECT_GT(focused, likeness_at(off) + 4) << "focused at " << off;
}

TEST(AugmentedAperture, IsOnTheScreenWhereTheDraftIs) {
  Stage stage(kSmall, 1, kRendered);
  for (const double elevation : {-4.0, 0.0, 4.0})
    for (const double azimuth : {-6.0, -3.0, 3.0, 6.0})
      stage.Show(stage.capture.At(stage.capture.CameraAt(azimuth, elevation)));
  const auto state = stage.capture.At(stage.capture.CameraAt(0, 0));
  stage.Type('s');
  const cv::Mat focused = stage.Show(state);
  // The sphere's image stays as it is: only the plane moves.
  for (int i = 0; i < 3; ++i) stage.Press(Key::kPageUp);
  const cv::Mat behind = stage.Show(state);
  stage.Type('a');
  const cv::Mat without = stage.Show(state);
  const cv::Rect wall(60, 30, 500, 110);
  EXPECT_GT(Likeness(focused, without), Likeness(behind, without) + 2);
  EXPECT_GT(Likeness(behind, without, wall), Likeness(focused, without, wall) + 2);
  EXPECT_LT(cv::norm(without(wall), state->live.pixels(wall), cv::NORM_INF), 2);
}

TEST(AugmentedAperture, UsesRecordedViewsUntilTakenBack) {
  StagedCapture capture;
  SpreadPictures spread;
  spread.Offer(*capture.At(capture.CameraAt(0, 0)));
  spread.Offer(*capture.Record(capture.CameraAt(0.2, 0)));  // as good as the same place
  spread.Offer(*capture.Record(capture.CameraAt(8, 0)));
  spread.Offer(*capture.At(capture.CameraAt(16, 0)));
  ASSERT_EQ(spread.pictures().size(), 3u);
  capture.TakeBack(1);
  auto lost = capture.Lost();  // at once, wherever the camera is
  spread.Offer(*lost);
  EXPECT_EQ(spread.pictures().size(), 2u);
  capture.TakeBack(2);
  spread.Offer(*capture.Lost());
  ASSERT_EQ(spread.pictures().size(), 1u);
  EXPECT_LT((spread.pictures()[0].picture->cam_from_world.OriginInSource() -
             capture.CameraAt(16, 0).OriginInSource())
                .norm(),
            1e-9);
}

TEST(SpreadPictures, StayFewAndFarApart) {
  StagedCapture capture;
  SpreadPictures spread(12);
  for (int i = 0; i < 400; ++i)
    spread.Offer(*capture.At(capture.CameraAt(-30 + 0.15 * i, 10 * std::sin(0.05 * i))));
  EXPECT_LE(spread.pictures().size(), 12u);
  EXPECT_GE(spread.pictures().size(), 6u);
}

}  // namespace
}  // namespace ulf::test::aperture_test
