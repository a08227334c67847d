// Tests: render/stereo/bracket_merge.
#include "render/stereo/bracket_merge.h"

#include <gmock/gmock.h>

#include <fstream>
#include <memory>

#include "acquisition/simulator/simulated_camera.h"
#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/image/exr_file.h"
#include "core/light_field/light_field_io.h"
#include "core/light_field/view_exposures.h"
#include "render/proxy/points_proxy.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double kBetweenS = 0.1;  // exposures; the hand moves on

SimulatedCamera LightboxCamera() {
  return SimulatedCamera(SimulationOptions::FromUri(DeviceUri::Parse(
      "sim:lightbox?width=240&height=180&format=bayerrg12&exposure_us=1000&speed_deg_s=5&look_away=0")));
}

Frame Taken(const SimulatedCamera& camera, double open_s, double stops, std::uint64_t id) {
  return camera.Capture(Shot{.open_s = open_s,
                             .exposure_s = 0.001 * std::exp2(stops),
                             .gain = 1,
                             .format = SensorFormat::kBayerRg12,
                             .id = id});
}

// One view with other exposures, taken while the hand moves on.
LightField Bracket(const SimulatedCamera& camera, const fs::path& dir, const std::vector<double>& stops) {
  LightFieldWriter writer = LightFieldWriter::Create(dir, {.camera = camera.camera()});
  const Frame reference = Taken(camera, 1, 0, 1);
  View view;
  view.cam_from_world = *reference.known_cam_from_world;
  writer.AddView(reference, view);
  for (std::size_t i = 0; i < stops.size(); ++i) {
    const Frame frame = Taken(camera, 1 + kBetweenS * static_cast<double>(i + 1), stops[i], i + 2);
    writer.AddExposure(1, frame, *frame.known_cam_from_world * view.cam_from_world.Inverse(), false);
  }
  writer.SetSubject(camera.scene().subject());
  writer.Close(1);
  return ReadLightField(dir);
}

// Points of what the camera sees.
std::shared_ptr<const Proxy> Geometry(const SimulatedCamera& camera, const Rigid3& cam_from_world) {
  std::vector<ScenePoint> points;
  cv::RNG random(17);
  const Rigid3 world_from_cam = cam_from_world.Inverse();
  for (int i = 0; i < 6000; ++i) {
    const auto ray = camera.camera().RayFromImg({random.uniform(-0.1, 1.1) * camera.camera().width,
                                                 random.uniform(-0.1, 1.1) * camera.camera().height});
    if (!ray) continue;
    const Eigen::Vector3d direction = (world_from_cam.rotation * *ray).normalized();
    ScenePoint point;
    point.position_in_world = world_from_cam.translation +
                              camera.scene().DepthAlong(world_from_cam.translation, direction) * direction;
    points.push_back(point);
  }
  return std::make_shared<PointsProxy>(camera.scene().subject(), points);
}

double MedianError(const cv::Mat& light, const cv::Mat& truth) {
  std::vector<float> errors;
  for (int y = 0; y < light.rows; ++y)
    for (int x = 0; x < light.cols; ++x) {
      const float is = light.at<cv::Vec3f>(y, x)[1], should = truth.at<cv::Vec3f>(y, x)[1];
      if (should > 0) errors.push_back(std::abs(is / should - 1));
    }
  std::ranges::nth_element(errors, errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2));
  return errors[errors.size() / 2];
}

// Pixels beyond full scale of the view's own exposure, by their share within a tenth of the truth.
double ShareOfHighlightsRight(const cv::Mat& light, const cv::Mat& truth) {
  int right = 0, all = 0;
  for (int y = 0; y < light.rows; ++y)
    for (int x = 0; x < light.cols; ++x) {
      const float is = light.at<cv::Vec3f>(y, x)[1], should = truth.at<cv::Vec3f>(y, x)[1];
      if (should < 1.2) continue;
      ++all;
      right += std::abs(is / should - 1) < 0.1;
    }
  return all > 0 ? right / static_cast<double>(all) : 0;
}

TEST(BracketMerge, PosesAndGeometryAlignWhatAMovingHandTook) {
  const ScratchFolder scratch;
  const SimulatedCamera camera = LightboxCamera();
  const LightField light_field = Bracket(camera, scratch / "lf", {-2, 2, -4, 4});
  const View& view = light_field.views.at(0);
  const cv::Mat truth = camera.CleanLinear(view.cam_from_world);
  const auto geometry = Geometry(camera, view.cam_from_world);
  const MergedView aligned = MergeExposuresOf(light_field, view, *geometry);
  const MergedView lying = MergeExposuresOf(light_field, view, *geometry, {.align = false});
  View alone = view;
  alone.exposures.clear();
  const MergedView single = MergeExposuresOf(light_field, alone, *geometry);
  EXPECT_EQ(aligned.exposures, 5);
  EXPECT_THAT(aligned.left_out, IsEmpty());
  EXPECT_NEAR(aligned.longest / aligned.shortest, 256, 12);
  const double of_aligned = MedianError(aligned.merged.light, truth),
               of_lying = MedianError(lying.merged.light, truth),
               of_single = MedianError(single.merged.light, truth);
  EXPECT_LT(of_aligned, 0.5 * of_single) << "less noise";
  EXPECT_LT(of_aligned, 0.7 * of_lying);
  EXPECT_LT(aligned.merged.ghost_share, 0.6 * lying.merged.ghost_share);
  EXPECT_GT(ShareOfHighlightsRight(aligned.merged.light, truth), 0.6);
  EXPECT_LT(ShareOfHighlightsRight(single.merged.light, truth), 0.1) << "clipped";
}

// A shutter that did not do what it says.
TEST(BracketMerge, AnExposureWhoseLightIsNotWhatItsTimeTellsIsLeftOut) {
  const ScratchFolder scratch;
  const SimulatedCamera camera = LightboxCamera();
  LightField light_field = Bracket(camera, scratch / "lf", {-2, 2});
  const auto geometry = Geometry(camera, light_field.views[0].cam_from_world);
  light_field.views[0].exposures[1].exposure_s *= 2;
  const MergedView merged = MergeExposuresOf(light_field, light_field.views[0], *geometry);
  EXPECT_EQ(merged.exposures, 2);
  ASSERT_EQ(merged.left_out.size(), 1u);
  EXPECT_THAT(merged.left_out[0], HasSubstr("0.5"));
  // A little is measured: nothing is lost by it.
  light_field.views[0].exposures[1].exposure_s *= 0.5 * 1.1;
  EXPECT_EQ(MergeExposuresOf(light_field, light_field.views[0], *geometry).exposures, 3);
  EXPECT_NEAR(MergeExposuresOf(light_field, light_field.views[0], *geometry).longest, 4, 0.08);
  light_field.views[0].exposure_s = 0;
  EXPECT_THROW(MergeExposuresOf(light_field, light_field.views[0], *geometry), UsageError);
}

TEST(BracketMerge, TheFileHoldsLightAndWhereItIsNotSure) {
  const ScratchFolder scratch;
  const SimulatedCamera camera = LightboxCamera();
  const LightField light_field = Bracket(camera, scratch / "lf", {-2, 2});
  const View& view = light_field.views.at(0);
  const MergedView merged = MergeExposuresOf(light_field, view, *ProxyForBrackets(light_field));
  const std::string file = scratch / "merged.exr";
  WriteFileAtomically(file, MergedExr(view, merged));
  cv::Mat difference;
  cv::absdiff(ReadExr(file), merged.merged.light, difference);
  EXPECT_EQ(cv::norm(difference, cv::NORM_INF), 0);
  EXPECT_EQ(cv::countNonZero(ReadExrChannel(file, kGhostsChannel)), cv::countNonZero(merged.merged.ghosts));
  EXPECT_EQ(cv::countNonZero(ReadExrChannel(file, kClippedChannel)), cv::countNonZero(merged.merged.clipped));
  EXPECT_TRUE(ReadExrChannel(file, "Z").empty());
  EXPECT_THAT(ExrAttribute(file, "ulfExposures"), HasSubstr("3 from 0.25 to 4"));
}

}  // namespace
}  // namespace ulf::test
