// Tests: coverage/measured/cover_by, coverage/measured/error_map, coverage/measured/error_meter.
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"
#include "coverage/bound/coverage_map.h"
#include "coverage/measured/cover_by.h"
#include "coverage/measured/error_map.h"
#include "coverage/measured/error_meter.h"
#include "tests/render/stereo/stereo_scenes.h"
#include "tests/support/floors.h"

namespace ulf {
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
    EXPECT_THROW(CoverGoal::Parse(wrong), UsageError) << wrong;
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
  EXPECT_NEAR(map.At(Direction(0))->DbNow(), 30 + 20 * std::log10(2), 1e-6);
  EXPECT_EQ(map.At(Direction(30))->DbNow(), 30);
  map.AddView(Direction(0));
  EXPECT_LT(map.At(Direction(0))->DbNow(), 30 + 20 * std::log10(8) + 1e-6) << "never without error";
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

TEST(Verdict, FollowsTheMeasurementAndItsLimits) {
  const double goal = 32, disc = Radians(3);
  EXPECT_EQ(VerdictOf(Frame(0, 33), goal, disc), MeasuredVerdict::kGood);
  EXPECT_EQ(VerdictOf(Frame(0, 31), goal, disc), MeasuredVerdict::kBad);
  EXPECT_EQ(VerdictOf(Frame(0, 31, 0.5), goal, disc), MeasuredVerdict::kGood)
      << "a view so near helps no more";
  EXPECT_EQ(VerdictOf(Frame(0, 45, 20), goal, disc), MeasuredVerdict::kBad) << "geometry needs neighbours";
  MeasuredFrame blind = Frame(0, 20);
  blind.measurable = false;
  EXPECT_EQ(VerdictOf(blind, goal, disc), MeasuredVerdict::kUnknown);
  for (const auto cause : {render::ErrorCause::kPose, render::ErrorCause::kLight, render::ErrorCause::kFocus,
                           render::ErrorCause::kMoved}) {
    MeasuredFrame frame = Frame(0, 20);
    frame.cause = cause;
    EXPECT_EQ(VerdictOf(frame, goal, disc), MeasuredVerdict::kUnknown) << Name(cause);
  }
}

TEST(Verdict, GoalOutOfReachIsLeftToTheBound) {
  const double goal = 32, disc = Radians(3);
  EXPECT_EQ(VerdictOf(Frame(0, 28, 4), goal, disc, {.db_per_halving = 3}), MeasuredVerdict::kBad);
  EXPECT_EQ(VerdictOf(Frame(0, 28, 4), goal, disc, {.db_per_halving = 1}), MeasuredVerdict::kUnknown);
}

TEST(ErrorMap, TellsWhatNearerViewsBring) {
  ErrorMap map;
  for (int i = 0; i < 30; ++i) map.Add(Frame(3 * i, 30 - 2 * std::log2(1 + i % 8), 1 + i % 8));
  EXPECT_FALSE(map.DbPerHalving()) << "too few";
  for (int i = 30; i < 80; ++i) map.Add(Frame(3 * i, 30 - 2 * std::log2(1 + i % 8), 1 + i % 8));
  ASSERT_TRUE(map.DbPerHalving());
  EXPECT_NEAR(*map.DbPerHalving(), 2, 0.01);
  ErrorMap alike;
  for (int i = 0; i < 80; ++i) alike.Add(Frame(3 * i, 30, 4));
  EXPECT_FALSE(alike.DbPerHalving()) << "all at one distance";
}

TEST(Verdict, FrameBeyondTheViewsWaitsForTheOtherSide) {
  const double goal = 32, disc = Radians(3);
  MeasuredFrame frame = Frame(0, 28);
  frame.one_sided = 0.9;
  EXPECT_EQ(VerdictOf(frame, goal, disc), MeasuredVerdict::kWait);
  frame.db = 25;
  EXPECT_EQ(VerdictOf(frame, goal, disc), MeasuredVerdict::kBad) << "half way to it would not be good either";
  frame.db = 33;
  EXPECT_EQ(VerdictOf(frame, goal, disc), MeasuredVerdict::kGood);
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

TEST_F(MeterTest, FrameIsMeasuredAgainWhenAViewIsRecordedNearIt) {
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
  meter.RemoveView(1);
  EXPECT_FALSE(MeasureAt(meter, -0.25)) << "no views";
}

TEST(Verdict, GoodFrameSpeaksForOthersAsFarAsTheErrorAllows) {
  EXPECT_EQ(GoodRadius(Frame(0, 32), 32), 0);
  EXPECT_NEAR(GoodRadius(Frame(0, 32 + 20 * std::log10(1.5)), 32), Radians(2), 1e-9);
  EXPECT_NEAR(GoodRadius(Frame(0, 50), 32), Radians(4), 1e-9) << "not beyond the nearest view";
  EXPECT_EQ(GoodRadius(Frame(0, 30), 32), 0);
}

// What is measured outdoes the bound on the map, and lasts when it is painted anew.
TEST(MeasuredDiscs, ArePaintedAndTakenAway) {
  const Subject subject{{0.4, -1.2, 0.7}, 0.3};
  CriterionView camera;
  camera.fx = camera.fy = 600;
  camera.width = 640, camera.height = 480;
  camera.cx = 320, camera.cy = 240;
  const auto view_at = [&](double azimuth_deg) {
    return camera.AimedAt(subject.center_in_world, subject.center_in_world + 2 * Direction(azimuth_deg),
                          Vector3d::UnitZ());
  };
  CoverageMap map(subject,
                  {.cap = Cap::ParseDegrees("40x20"), .up_in_world = Vector3d::UnitZ(), .threshold_px = 12});
  map.Add(view_at(0));
  const double before = map.CoveredShare();
  ASSERT_GT(before, 0.005);
  EXPECT_LT(map.At(Direction(12))->index, 0);
  map.Mark({Direction(12), Radians(4), true});
  EXPECT_EQ(map.At(Direction(12))->index, 0) << "by the nearest view";
  EXPECT_EQ(map.At(Direction(9))->index, 0);
  EXPECT_LT(map.At(Direction(17))->index, 0);
  EXPECT_GT(map.CoveredShare(), before + 0.03);
  EXPECT_GE(map.At(Direction(0))->index, 0);
  map.Mark({Direction(0), Radians(1), false});
  EXPECT_LT(map.At(Direction(0))->index, 0);
  const double with_hole = map.CoveredShare();
  // Views at another distance paint everything anew.
  map.Add(camera.AimedAt(subject.center_in_world, subject.center_in_world + 2.4 * Direction(-12),
                         Vector3d::UnitZ()));
  EXPECT_EQ(map.At(Direction(12))->index, 0);
  EXPECT_LT(map.At(Direction(0))->index, 0);
  EXPECT_GT(map.CoveredShare(), with_hole);
  map.Add(view_at(0.2));
  EXPECT_GE(map.At(Direction(0))->index, 0) << "a view was recorded where it was missing";
  map.ForgetMeasured(Direction(10), Radians(5));
  EXPECT_LT(map.At(Direction(12))->index, 0);
  EXPECT_TRUE(map.measured().empty());
  // One disc for each place.
  for (int i = 0; i < 50; ++i) map.Mark({Direction(12 + 0.001 * i), Radians(1), i % 2 == 0});
  EXPECT_EQ(map.measured().size(), 1u);
}

}  // namespace
}  // namespace ulf
