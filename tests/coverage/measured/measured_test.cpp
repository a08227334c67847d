// Tests: coverage/measured/cover_by, coverage/measured/error_map, coverage/measured/error_meter,
// coverage/measured/threshold_by_errors.
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"
#include "coverage/bound/coverage_map.h"
#include "coverage/measured/cover_by.h"
#include "coverage/measured/error_map.h"
#include "coverage/measured/error_meter.h"
#include "coverage/measured/threshold_by_errors.h"
#include "tests/render/stereo/stereo_scenes.h"
#include "tests/support/floors.h"

namespace ulf::measured_test {
namespace {

using Eigen::Vector3d;

TEST(CoverGoal, IsReadFromTheCommandLine) {
  EXPECT_EQ(CoverGoal::Parse("bound").by, CoverBy::kBound);
  EXPECT_EQ(CoverGoal::Parse("measured").by, CoverBy::kMeasured);
  EXPECT_EQ(CoverGoal::Parse("measured").db, CoverGoal{}.db);
  EXPECT_EQ(CoverGoal::Parse("both:31.5").by, CoverBy::kBoth);
  EXPECT_EQ(CoverGoal::Parse("both:31.5").db, 31.5);
  for (const CoverBy by : {CoverBy::kBound, CoverBy::kMeasured, CoverBy::kBoth})
    EXPECT_EQ(CoverGoal::Parse(Name(by)).by, by);
  for (const char* wrong : {"", "bounds", "measured:", "measured:x", "measured:33dB", "measured:nan",
                            "both:5", "both:60", "bound:30"})
    EXPECT_THROW(CoverGoal::Parse(wrong), Refusal) << wrong;
}

Vector3d Direction(double azimuth_deg, double elevation_deg = 0) {
  const double azimuth = Radians(azimuth_deg), elevation = Radians(elevation_deg);
  return {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
          std::sin(elevation)};
}

MeasuredFrame Frame(double azimuth_deg, double db, double nearest_deg = 4) {
  MeasuredFrame frame;
  frame.direction = Direction(azimuth_deg);
  frame.nearest_view_angle = Radians(nearest_deg);
  frame.measurable = true;
  frame.db = db;
  frame.misregistration_px = 0.5;
  frame.cause = render::ErrorCause::kGeometry;
  return frame;
}

TEST(ErrorMap, NewestMeasurementOfADirectionCounts) {
  ErrorMap map;
  EXPECT_TRUE(map.empty());
  EXPECT_EQ(map.At(Direction(0)), nullptr);
  map.Add(Frame(0, 30));
  map.Add(Frame(0.1, 34));
  map.Add(Frame(20, 25));
  EXPECT_EQ(map.Parts().size(), 2u);
  ASSERT_NE(map.At(Direction(1)), nullptr);
  EXPECT_EQ(map.At(Direction(1))->DbNow(), 34);
  EXPECT_EQ(map.At(Direction(19))->DbNow(), 25);
  EXPECT_EQ(map.At(Direction(10)), nullptr) << "beyond its reach";
  EXPECT_EQ(map.At(-Direction(0)), nullptr);
}

TEST(ErrorMap, ErrorFallsAroundAViewThatIsRecorded) {
  ErrorMap map;
  map.Add(Frame(0, 30));
  map.Add(Frame(30, 30));
  map.AddView(2 * Direction(2));  // of any length
  EXPECT_NEAR(map.At(Direction(0))->DbNow(), 30 + kDbPerHalving, 1e-6);
  EXPECT_EQ(map.At(Direction(30))->DbNow(), 30);
  map.AddView(Direction(0));
  EXPECT_NEAR(map.At(Direction(0))->DbNow(), 30 + 3 * kDbPerHalving, 1e-6) << "never without error";
  map.Add(Frame(0, 29));
  EXPECT_EQ(map.At(Direction(0))->DbNow(), 29) << "measured again";
}

TEST(ErrorMap, SummaryNamesWhatFails) {
  ErrorMap map;
  for (int i = 0; i < 10; ++i) map.Add(Frame(10 * i, 30 + i));
  MeasuredFrame unknown = Frame(200, 5);
  unknown.measurable = false;
  map.Add(unknown);
  MeasuredFrame surface = Frame(220, 20);
  surface.cause = render::ErrorCause::kSurface;
  map.Add(surface);
  const ErrorSummary summary = Summarize(map, 32.5);
  EXPECT_EQ(summary.directions, 11);
  EXPECT_EQ(summary.failing, 4);
  EXPECT_EQ(summary.causes.at(render::ErrorCause::kGeometry), 3);
  EXPECT_EQ(summary.causes.at(render::ErrorCause::kSurface), 1);
  EXPECT_NEAR(summary.median_db, 34, 1e-9);
  EXPECT_NEAR(summary.worst_tenth_db, 30, 1e-9);
  EXPECT_NEAR(summary.median_px, 0.5, 1e-9);
}

TEST(ErrorMap, ForgetsTheGainOfATakenBackView) {
  ErrorMap map;
  map.Add(Frame(0, 30));
  map.Add(Frame(20, 30));
  map.RemoveView(2 * Direction(3), Radians(8));
  EXPECT_EQ(map.At(Direction(0)), nullptr);
  EXPECT_NE(map.At(Direction(20)), nullptr);
}

TEST(ErrorMap, DropsMeasurementsOfRemovedViews) {
  LightField light_field;
  light_field.subject = Subject{{0.1, 0.2, 0.3}, 0.2};
  for (const double azimuth_deg : {1.0, 20.0}) {
    View& view = light_field.views.emplace_back();
    view.cam_from_world.translation = -(light_field.subject->center_in_world + 2 * Direction(azimuth_deg));
  }
  EXPECT_FALSE(ValidErrors(light_field)) << "nothing was measured";
  light_field.measured = MeasuredErrors{};
  for (const double azimuth_deg : {0.0, 21.0})
    light_field.measured->directions.push_back({.direction = Direction(azimuth_deg),
                                                .nearest_view_angle = Radians(1),
                                                .db = 40,
                                                .cause = Name(render::ErrorCause::kNone)});
  ASSERT_TRUE(ValidErrors(light_field));
  EXPECT_EQ(ValidErrors(light_field)->directions.size(), 2u);
  light_field.views.pop_back();
  ASSERT_TRUE(ValidErrors(light_field));
  ASSERT_EQ(ValidErrors(light_field)->directions.size(), 1u);
  EXPECT_EQ(ValidErrors(light_field)->directions[0].direction, Direction(0));
  light_field.views.clear();
  EXPECT_FALSE(ValidErrors(light_field));
}

TEST(ErrorMap, GoodFrameBelowAHigherGoalIsDetail) {
  ErrorMap map;
  MeasuredFrame good_then = Frame(0, 30);
  good_then.cause = render::ErrorCause::kNone;
  map.Add(good_then);
  EXPECT_EQ(Summarize(map, 33).causes.at(render::ErrorCause::kDetail), 1);
}

constexpr double kThreshold_px = 12, kDisc = Radians(4);
// A frame as far from the nearest view as frames are on average, which misses the goal by `db`.
MeasuredFrame UsualFrame(double azimuth_deg, double db_above_goal, const CoverGoal& goal = {}) {
  return Frame(azimuth_deg, goal.db + db_above_goal, Degrees(kDisc) * ThresholdByErrors::kUsualApart);
}
ErrorMap FramesAround(double azimuth_deg, const MeasuredFrame& like) {
  ErrorMap errors;
  for (int i = -4; i <= 4; ++i)
    for (int j = -4; j <= 4; ++j) {
      MeasuredFrame frame = like;
      frame.direction = Direction(azimuth_deg + 1.6 * i, 1.6 * j);
      errors.Add(frame);
    }
  return errors;
}
double FactorAt(const ErrorMap& errors, double azimuth_deg, CoverBy by = CoverBy::kMeasured) {
  return ThresholdByErrors(errors, {by, CoverGoal{}.db}, kThreshold_px, kDisc)(Direction(azimuth_deg));
}

TEST(ThresholdByErrors, WidensSpacingOfGoodPictures) {
  EXPECT_EQ(FactorAt({}, 0), 1);
  EXPECT_NEAR(FactorAt(FramesAround(0, UsualFrame(0, 0)), 0), 1, 1e-6);
  EXPECT_NEAR(FactorAt(FramesAround(0, UsualFrame(0, kDbPerHalving)), 0), 2, 0.2);
  EXPECT_NEAR(FactorAt(FramesAround(0, UsualFrame(0, -0.5 * kDbPerHalving)), 0), std::sqrt(0.5), 0.05);
  EXPECT_NEAR(FactorAt(FramesAround(0, UsualFrame(0, 30)), 0), ThresholdByErrors::kMost_px / kThreshold_px,
              0.3);
  EXPECT_NEAR(FactorAt(FramesAround(0, UsualFrame(0, -30)), 0), ThresholdByErrors::kLeast_px / kThreshold_px,
              0.1);
  EXPECT_NEAR(FactorAt(FramesAround(0, UsualFrame(0, kDbPerHalving)), 90), 1, 1e-6)
      << "nothing was measured there";
}

TEST(ThresholdByErrors, FartherEqualErrorAsksForFewer) {
  MeasuredFrame far = UsualFrame(0, 0);
  far.nearest_view_angle *= 1.5;
  EXPECT_NEAR(FactorAt(FramesAround(0, far), 0), 1.5, 0.1);
}

TEST(ThresholdByErrors, GeometryKeepsItsNeighbours) {
  const double wide_disc = Radians(10);
  MeasuredFrame frame = UsualFrame(0, 30);
  frame.nearest_view_angle = 0.6 * wide_disc;
  EXPECT_NEAR(
      ThresholdByErrors(FramesAround(0, frame), {CoverBy::kMeasured}, kThreshold_px, wide_disc)(Direction(0)),
      ThresholdByErrors::kMostApart / wide_disc, 0.03);
}

TEST(ThresholdByErrors, IgnoresUninformativeErrors) {
  MeasuredFrame blind = UsualFrame(0, -10), beyond = blind, beside_view = blind;
  blind.measurable = false;
  beyond.one_sided = 0.9;
  beside_view.nearest_view_angle = 0.1 * kDisc;
  for (const MeasuredFrame& frame : {blind, beyond, beside_view})
    EXPECT_EQ(FactorAt(FramesAround(0, frame), 0), 1);
  for (const auto cause : {render::ErrorCause::kPose, render::ErrorCause::kLight, render::ErrorCause::kFocus,
                           render::ErrorCause::kMoved}) {
    MeasuredFrame frame = UsualFrame(0, -10);
    frame.cause = cause;
    EXPECT_EQ(FactorAt(FramesAround(0, frame), 0), 1) << Name(cause);
  }
}

TEST(ThresholdByErrors, AlsoMeetsTheBoundWithBoth) {
  EXPECT_EQ(FactorAt(FramesAround(0, UsualFrame(0, 10)), 0, CoverBy::kBoth), 1);
  EXPECT_LT(FactorAt(FramesAround(0, UsualFrame(0, -10)), 0, CoverBy::kBoth), 0.7);
}

// Views of two planes from a row of places, as a capture has them.
class MeterTest : public testing::Test {
 protected:
  static constexpr int kWidth = 240, kHeight = 180;
  const Subject subject_{{0, 0, 3}, 0.4};
  const CameraModel camera_ = CameraModel::Pinhole(kWidth, kHeight, 220);

  StereoView From(double x) const {
    const std::vector<test::Patch> patches{
        {{-8, -6, 4.5}, {16, 0, 0}, {0, 12, 0}, test::Mottled(0.04, 1)},
        {{-0.45, -0.45, 3}, {0.9, 0, 0}, {0, 0.9, 0}, test::Mottled(0.15, 2)}};
    return test::Draw(patches, {x, 0, 0}, subject_.center_in_world, kWidth, kHeight, 220).view;
  }
  static cv::Mat Bgr(const StereoView& view) {
    cv::Mat grey, bgr;
    view.grey.convertTo(grey, CV_8U);
    cv::cvtColor(grey, bgr, cv::COLOR_GRAY2BGR);
    return bgr;
  }
  // The wall and the slab, the slab `off` too far away: what is predicted is wrong.
  static std::shared_ptr<const TriangleMesh> Mesh(float off) {
    auto mesh = std::make_shared<TriangleMesh>();
    const auto square = [&](float half_x, float half_y, float z) {
      const auto first = static_cast<std::uint32_t>(mesh->vertices.size());
      for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}})
        mesh->vertices.push_back({static_cast<float>(x) * half_x, static_cast<float>(y) * half_y, z});
      mesh->triangles.push_back({first, first + 1, first + 2});
      mesh->triangles.push_back({first, first + 2, first + 3});
    };
    square(8, 6, 4.5f);
    square(0.45f, 0.45f, 3 + off);
    return mesh;
  }
  std::optional<MeasuredFrame> MeasureAt(ErrorMeter& meter, double x) const {
    const StereoView frame = From(x);
    const Image image{Bgr(frame)};
    return meter.Measure({.image = image,
                          .camera = camera_,
                          .cam_from_world = frame.cam_from_world,
                          .center_sigma = 0.0,
                          .time_s = x});
  }
  void Add(ErrorMeter& meter, int id, double x) const {
    const StereoView view = From(x);
    meter.AddView(id, Image{Bgr(view)}, camera_, view.cam_from_world);
  }
};

TEST_F(MeterTest, MeasuresOverGeometryAlone) {
  ErrorMeter meter({.size_px = kWidth, .every_frame = true});
  Add(meter, 1, -0.3);
  Add(meter, 2, 0.3);
  EXPECT_FALSE(MeasureAt(meter, 0)) << "no geometry yet";
  meter.SetGeometry(subject_, Mesh(0));
  const auto measured = MeasureAt(meter, 0);
  ASSERT_TRUE(measured);
  EXPECT_TRUE(measured->measurable);
  EXPECT_GT(measured->db, 38);
  EXPECT_LT(measured->one_sided, 0.2);
  EXPECT_NEAR(measured->nearest_view_angle, std::atan(0.1), 1e-3);
  EXPECT_GT(measured->processor_ms, 0);
  const auto beyond = MeasureAt(meter, 0.8);
  ASSERT_TRUE(beyond);
  EXPECT_GT(beyond->one_sided, 0.9);
  meter.SetGeometry(subject_, Mesh(0.3f));
  const auto over_wrong = MeasureAt(meter, 0);
  ASSERT_TRUE(over_wrong);
  EXPECT_LT(over_wrong->db, measured->db - 6);
}

TEST_F(MeterTest, RemeasuresAFrameWhenANearViewIsAdded) {
  ErrorMeter meter({.size_px = kWidth, .every_frame = true});
  Add(meter, 1, -0.3);
  Add(meter, 2, 0.3);
  meter.SetGeometry(subject_, Mesh(0.3f));
  const auto before = MeasureAt(meter, 0);
  ASSERT_TRUE(before);
  EXPECT_FALSE(meter.MeasureAgain()) << "nothing has changed";
  Add(meter, 3, 0.05);
  const auto again = meter.MeasureAgain();
  ASSERT_TRUE(again);
  EXPECT_EQ(again->time_s, before->time_s);
  EXPECT_GT(again->db, before->db + 3);
  EXPECT_FALSE(meter.MeasureAgain());
  // Corrected poses: what the kept frames' poses would be now nobody knows.
  Add(meter, 4, -0.05);
  meter.MoveViews({{1, From(-0.3).cam_from_world}});
  EXPECT_FALSE(meter.MeasureAgain());
}

// A large picture, and the mosaic of a machine-vision camera, are measured as the small one is.
TEST_F(MeterTest, LargePicturesAndMosaicsAreReducedFirst) {
  const auto db_of = [&](const Image& image) {
    ErrorMeter meter({.size_px = kWidth, .every_frame = true});
    Add(meter, 1, -0.2);
    Add(meter, 2, 0.2);
    meter.SetGeometry(subject_, Mesh(0));
    const CameraModel camera = camera_.ScaledTo(image.width(), image.height());
    const auto measured = meter.Measure({.image = image,
                                         .camera = camera,
                                         .cam_from_world = From(0).cam_from_world,
                                         .center_sigma = 0.0,
                                         .time_s = 0});
    return measured && measured->measurable ? measured->db : 0.0;
  };
  cv::Mat large;
  cv::resize(Bgr(From(0)), large, {4 * kWidth, 4 * kHeight}, 0, 0, cv::INTER_CUBIC);
  cv::Mat grey;
  cv::cvtColor(large, grey, cv::COLOR_BGR2GRAY);
  const double small_db = db_of({Bgr(From(0))});
  EXPECT_GT(small_db, 36);
  EXPECT_NEAR(db_of({large}), small_db, 3);
  EXPECT_NEAR(db_of({grey, Transfer::kSrgb, Mosaic::kRggb}), small_db, 4) << "all colours alike";
}

TEST_F(MeterTest, KeepsToItsShareOfTheTime) {
  ErrorMeter meter({.size_px = kWidth, .processor_share = 1e-4});
  Add(meter, 1, -0.3);
  Add(meter, 2, 0.3);
  meter.SetGeometry(subject_, Mesh(0));
  EXPECT_TRUE(MeasureAt(meter, 0));
  EXPECT_FALSE(MeasureAt(meter, 0.01))
      << "a frame takes milliseconds, which are rested ten thousand times as long";
}

TEST_F(MeterTest, EarlierViewIsReadWhenAFrameComesNearIt) {
  ErrorMeter meter({.size_px = kWidth, .every_frame = true});
  int read = 0;
  const StereoView earlier = From(-0.3);
  meter.AddEarlierView(
      1,
      [&] {
        ++read;
        return Bgr(earlier);
      },
      camera_, earlier.cam_from_world);
  meter.SetGeometry(subject_, Mesh(0));
  EXPECT_EQ(read, 0);
  ASSERT_TRUE(MeasureAt(meter, -0.25));
  ASSERT_TRUE(MeasureAt(meter, -0.2));
  EXPECT_EQ(read, 1);
  meter.RemoveView(1, earlier.cam_from_world);
  EXPECT_FALSE(MeasureAt(meter, -0.25)) << "no views";
}

TEST_F(MeterTest, ViewThatCannotBeReadIsLeftOut) {
  ErrorMeter meter({.size_px = kWidth, .every_frame = true});
  meter.AddEarlierView(
      1, []() -> cv::Mat { throw Error("the image is truncated"); }, camera_, From(0.02).cam_from_world);
  Add(meter, 2, -0.3);
  Add(meter, 3, 0.3);
  meter.SetGeometry(subject_, Mesh(0));
  const auto measured = MeasureAt(meter, 0);
  ASSERT_TRUE(measured);
  EXPECT_TRUE(measured->measurable);
  EXPECT_GT(measured->db, 36) << "by the other views";
  EXPECT_NEAR(MeasureAt(meter, 0.01)->nearest_view_angle, std::atan(0.29 / 3), 2e-3);
}

TEST_F(MeterTest, RemeasuresAFrameWhenANearViewLeaves) {
  ErrorMeter meter({.size_px = kWidth, .every_frame = true});
  Add(meter, 1, -0.3);
  Add(meter, 2, 0.3);
  Add(meter, 3, 0.05);
  meter.SetGeometry(subject_, Mesh(0.3f));
  const auto before = MeasureAt(meter, 0);
  ASSERT_TRUE(before);
  meter.RemoveView(3, From(0.05).cam_from_world);
  const auto again = meter.MeasureAgain();
  ASSERT_TRUE(again);
  EXPECT_LT(again->db, before->db - 3);
}

// The map's paint, its share and what a frame is judged by follow the errors; the bound's own map stays.
TEST(ThresholdByErrors, MapFollows) {
  const Subject subject{{0.4, -1.2, 0.7}, 0.3};
  CriterionView camera;
  camera.fx = camera.fy = 600;
  camera.width = 640, camera.height = 480;
  camera.cx = 320, camera.cy = 240;
  const auto view_at = [&](double azimuth_deg, double distance = 2) {
    return camera.AimedAt(subject.center_in_world,
                          subject.center_in_world + distance * Direction(azimuth_deg), Vector3d::UnitZ());
  };
  const auto map_by = [&](CoverBy by) {
    CoverageMap map(
        subject,
        WithAdaptiveThreshold(
            {.cap = Cap::ParseDegrees("60x20"), .up_in_world = Vector3d::UnitZ(), .threshold_px = 12}, {by}));
    map.Add(view_at(0));
    return map;
  };
  CoverageMap map = map_by(CoverBy::kMeasured);
  const double by_bound = map.CoveredShare(), radius_deg = Degrees(map.DiscRadius());
  ASSERT_GT(by_bound, 0.005);
  EXPECT_NEAR(map_by(CoverBy::kBound).CoveredShare(), by_bound, 0.004) << "until something is measured";
  MeasuredFrame good = UsualFrame(0, 30);
  good.nearest_view_angle = map.DiscRadius();
  AdaptThresholds(FramesAround(0, good), {CoverBy::kMeasured}, map);
  const double wide = map.CoveredShare();
  EXPECT_GT(wide, 4 * by_bound);
  EXPECT_EQ(map.At(Direction(2 * radius_deg))->index, 0);
  EXPECT_LT(map.At(Direction(3.5 * radius_deg))->index, 0);
  EXPECT_TRUE(map.Covers(view_at(2 * radius_deg)));
  EXPECT_FALSE(map.Covers(view_at(3.5 * radius_deg)));
  EXPECT_EQ(map.Holes().size(), 1u);
  // Views at another distance paint everything anew.
  map.Add(view_at(0, 2.4));
  EXPECT_GT(map.CoveredShare(), 0.5 * wide);
  MeasuredFrame bad = UsualFrame(0, -30);
  bad.nearest_view_angle = map.DiscRadius();
  AdaptThresholds(FramesAround(0, bad), {CoverBy::kMeasured}, map);
  EXPECT_LT(map.CoveredShare(), by_bound);
  EXPECT_LT(map.At(Direction(0.8 * radius_deg))->index, 0);
  EXPECT_FALSE(map.Covers(view_at(0.8 * radius_deg)));
  // One view after the other, or all at once, painted before or after the thresholds are known: the same map.
  CoverageMap anew = map_by(CoverBy::kMeasured);
  AdaptThresholds(FramesAround(0, bad), {CoverBy::kMeasured}, anew);
  anew.Add(view_at(0, 2.4));
  anew.SetThresholdFactor(map.threshold_factor());
  EXPECT_NEAR(anew.CoveredShare(), map.CoveredShare(), 1e-9);
}

// What is kept with a light field gives the map that its capture ended with.
TEST(ThresholdByErrors, LastsInTheLightField) {
  MeasuredFrame good = UsualFrame(0, 4);
  ErrorMap errors = FramesAround(0, good);
  errors.AddView(Direction(1));
  MeasuredFrame beyond = UsualFrame(12, -10);
  beyond.one_sided = 0.95;
  errors.Add(beyond);
  const ErrorMap kept = ErrorMapOf(ToMeasuredErrors(errors, "measured", CoverGoal{}.db, 100));
  EXPECT_GT(FactorAt(errors, 0), 1.3);
  EXPECT_NEAR(FactorAt(kept, -4), FactorAt(errors, -4), 0.02);
  EXPECT_NEAR(FactorAt(kept, 12), FactorAt(errors, 12), 0.02);
}

}  // namespace
}  // namespace ulf::measured_test
