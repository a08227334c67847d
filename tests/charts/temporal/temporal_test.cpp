// How restless a rendering is: what the number punishes, and the program that measures it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "acquisition/simulator/simulated_camera.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "tests/charts/temporal/step_error.h"
#include "tests/charts/temporal/temporal_error.h"
#include "tests/charts/temporal/temporal_evaluation.h"
#include "tests/measure/provenance.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::test {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using ::testing::HasSubstr;

constexpr int kFrames = 30;

// Texture that moves by a quarter of a pixel from picture to picture, in display levels.
cv::Mat MovingTexture(int frame, double offset_px = 0) {
  cv::Mat levels(48, 64, CV_32FC3);
  for (int y = 0; y < levels.rows; ++y)
    for (int x = 0; x < levels.cols; ++x) {
      const double u = x - 0.25 * frame + offset_px;
      const auto wave = [&](double length_px, double phase) {
        return 128 + 60 * std::sin(2 * M_PI * (u + phase) / length_px) * std::cos(2 * M_PI * y / 17.0);
      };
      levels.at<cv::Vec3f>(y, x) = cv::Vec3f(static_cast<float>(wave(7, 0)), static_cast<float>(wave(11, 2)),
                                             static_cast<float>(wave(19, 5)));
    }
  return levels;
}

// Of what `render(frame)` makes instead of the truth.
template <typename Render>
double ErrorOf(Render&& render) {
  TemporalError error;
  const cv::Mat all(48, 64, CV_8U, cv::Scalar(255));
  for (int frame = 0; frame < kFrames; ++frame) error.Add(render(frame), MovingTexture(frame), all);
  EXPECT_NEAR(error.FrameRms(), error.DiscRms(), 1e-6);
  EXPECT_EQ(error.over_time().size(), kFrames - 2u);
  return error.FrameRms();
}

TEST(TemporalError, IsTheSecondDifferenceOfTheError) {
  EXPECT_EQ(ErrorOf([](int frame) { return MovingTexture(frame); }), 0);
  // An error that stays, or grows evenly, is none; one of s t^2 has 2 s.
  EXPECT_NEAR(ErrorOf([](int frame) { return cv::Mat(MovingTexture(frame) + cv::Scalar::all(9)); }), 0, 1e-3);
  EXPECT_NEAR(ErrorOf([](int frame) { return cv::Mat(MovingTexture(frame) + cv::Scalar::all(0.5 * frame)); }),
              0, 1e-3);
  EXPECT_NEAR(
      ErrorOf([](int frame) { return cv::Mat(MovingTexture(frame) + cv::Scalar::all(0.1 * frame * frame)); }),
      0.2, 1e-3);
  EXPECT_NEAR(ErrorOf([](int frame) { return cv::Mat(MovingTexture(frame) + cv::Scalar::all(frame % 2)); }),
              2, 1e-3);
}

TEST(TemporalError, FlickerIsWorseThanBeingSmoothlyWrong) {
  const double flickers = ErrorOf([](int frame) { return MovingTexture(frame, frame % 2 ? 0.5 : -0.5); });
  const double jumps = ErrorOf([](int frame) { return MovingTexture(frame, frame / 5 % 2 ? 0.5 : -0.5); });
  const double displaced = ErrorOf([](int frame) { return MovingTexture(frame, 0.5); });
  const double drifts = ErrorOf([](int frame) { return MovingTexture(frame, 0.5 - 1.0 * frame / kFrames); });
  EXPECT_GT(flickers, 5 * displaced);
  EXPECT_GT(jumps, 3 * displaced);
  EXPECT_GT(jumps, 3 * drifts);
}

TEST(TemporalError, ABlurDoesNotWin) {
  const auto blurred = [](int frame) {
    cv::Mat blurred;
    cv::GaussianBlur(MovingTexture(frame), blurred, {0, 0}, 4);
    return blurred;
  };
  const auto sharp = [](int frame) { return MovingTexture(frame, 0.3 * std::sin(0.3 * frame)); };
  EXPECT_GT(ErrorOf(blurred), 1.2 * ErrorOf(sharp));
  // The plain second difference of the pictures would have said otherwise.
  const auto restless = [](auto&& render) {
    TemporalError error;
    for (int frame = 0; frame < kFrames; ++frame)
      error.Add(render(frame), cv::Mat(48, 64, CV_32FC3, cv::Scalar::all(128)), {});
    return error.FrameRms();
  };
  EXPECT_LT(restless(blurred), restless(sharp));
}

TEST(TemporalError, TheDiscIsThatOfThePictureInTheMiddle) {
  TemporalError error;
  const cv::Mat black(4, 4, CV_32FC3, cv::Scalar::all(0)), none(4, 4, CV_8U, cv::Scalar(0));
  cv::Mat one = none.clone(), spot = black.clone();
  one.at<std::uint8_t>(1, 1) = 255;
  spot.at<cv::Vec3f>(1, 1) = cv::Vec3f::all(10);
  error.Add(black, black, none);
  error.Add(spot, black, one);
  error.Add(black, black, none);
  EXPECT_NEAR(error.DiscRms(), 20, 1e-6);
  EXPECT_NEAR(error.FrameRms(), 20 / 4.0, 1e-6);
}

// The camera of MovingTexture(): it moves past a wall three metres away, by a quarter of a pixel a picture.
TrueDepth WallAt(int frame) {
  constexpr double kDepth = 3;
  TrueDepth wall{.camera = {}, .cam_from_world = {}, .depth = cv::Mat(48, 64, CV_32F, cv::Scalar(kDepth))};
  wall.camera.width = 64;
  wall.camera.height = 48;
  wall.camera.fx = wall.camera.fy = 60;
  wall.camera.cx = 32;
  wall.camera.cy = 24;
  wall.cam_from_world.translation.x() = 0.25 * frame * kDepth / wall.camera.fx;
  return wall;
}

template <typename Render>
double StepErrorOf(Render&& render) {
  StepError error;
  const cv::Mat all(48, 64, CV_8U, cv::Scalar(255));
  for (int frame = 0; frame < kFrames; ++frame)
    error.Add(render(frame), MovingTexture(frame), WallAt(frame), all);
  EXPECT_NEAR(error.FrameRms(), error.DiscRms(), 1e-6);
  EXPECT_EQ(error.over_time().size(), kFrames - 2u);
  return error.FrameRms();
}

// How much of a fault that is painted on the wall each picture has, when views that have more or less of it
// stand six pictures apart.
enum class Follow { kInSteps, kLinearly, kSmoothly };
double ShareAt(int frame, Follow follow) {
  constexpr int kApart = 6;
  constexpr std::array kOfViews{0.2, 0.9, 0.1, 0.6, 0.4, 1.0, 0.0, 0.7};
  const int k = frame / kApart;
  const double x = static_cast<double>(frame % kApart) / kApart, y = 1 - x;
  const auto view = [&](int i) { return kOfViews[static_cast<std::size_t>(i)]; };
  if (follow == Follow::kInSteps) return view(k);
  if (follow == Follow::kLinearly) return y * view(k) + x * view(k + 1);
  return (y * y * y * view(k) + (4 - 6 * x * x + 3 * x * x * x) * view(k + 1) +
          (4 - 6 * y * y + 3 * y * y * y) * view(k + 2) + x * x * x * view(k + 3)) /
         6;
}

TEST(StepError, TellsStepsKinksAndSmoothChangeApart) {
  const auto of = [](Follow follow) {
    return StepErrorOf([&](int frame) -> cv::Mat {
      const cv::Mat truth = MovingTexture(frame);
      return truth + 0.3 * ShareAt(frame, follow) * (truth - cv::Scalar::all(128));
    });
  };
  const double steps = of(Follow::kInSteps), kinks = of(Follow::kLinearly), smooth = of(Follow::kSmoothly);
  EXPECT_GT(steps, 3 * kinks);
  EXPECT_GT(kinks, 2 * smooth);
  EXPECT_GT(smooth, 0);
}

TEST(StepError, ABlurThatMovesWithItsPointsIsNone) {
  // Waves keep a share of their height, by their length; what is beyond the picture's edge is
  // blurred in, too.
  const auto blurred = [](int frame) {
    constexpr double kSigmaPx = 3;
    cv::Mat levels = MovingTexture(frame);
    std::array<float, 3> kept{};
    for (std::size_t c = 0; c < 3; ++c) {
      const double length_px = std::array{7.0, 11.0, 19.0}[c];
      kept[c] = static_cast<float>(
          std::exp(-2 * std::pow(M_PI * kSigmaPx, 2) * (1 / (length_px * length_px) + 1 / (17.0 * 17.0))));
    }
    levels.forEach<cv::Vec3f>([&](cv::Vec3f& pixel, const int*) {
      for (int c = 0; c < 3; ++c) pixel[c] = 128 + kept[static_cast<std::size_t>(c)] * (pixel[c] - 128);
    });
    return levels;
  };
  const auto steps = [](int frame) -> cv::Mat {
    const cv::Mat truth = MovingTexture(frame);
    return truth + 0.3 * ShareAt(frame, Follow::kInSteps) * (truth - cv::Scalar::all(128));
  };
  EXPECT_LT(StepErrorOf(blurred), 0.1 * StepErrorOf(steps));
  // Pixel by pixel it is as bad as the steps are.
  EXPECT_GT(ErrorOf(blurred), 0.3 * ErrorOf(steps));
}

TEST(StepError, FollowsPointsUntilTheyArePassed) {
  const TrueDepth here = WallAt(0);
  TrueDepth there = WallAt(8);        // two pixels to the right
  there.depth.at<float>(10, 22) = 1;  // something stands before the wall
  const cv::Mat places = PlacesIn(here, there);
  EXPECT_NEAR(places.at<cv::Vec2f>(10, 30)[0], 32, 1e-4);
  EXPECT_NEAR(places.at<cv::Vec2f>(10, 30)[1], 10, 1e-4);
  EXPECT_EQ(places.at<cv::Vec2f>(10, 20)[0], -1) << "hidden";
  EXPECT_EQ(places.at<cv::Vec2f>(10, 63)[0], -1) << "outside";
}

// ---- The program ----

// A few clean photographs of the simulator's studio, from a small cap.
void CaptureStudio(const fs::path& dir, const std::string& uri) {
  const SimulatedCamera simulator(SimulationOptions::FromUri(DeviceUri::Parse(uri)));
  const Scene& scene = simulator.scene();
  CaptureHeader header;
  header.camera = simulator.camera();
  header.device_uri = uri;
  header.units = "metres";
  auto writer = LightFieldWriter::Create(dir, header);
  const Vector3d center = scene.subject().center_in_world, first = scene.FirstDirection();
  const Vector3d side = first.cross(scene.UpInWorld()).normalized(), up = side.cross(first);
  std::uint64_t id = 0;
  for (int row = -2; row <= 2; ++row)
    for (int column = -2; column <= 2; ++column) {
      View view;
      view.cam_from_world = LookAt(center + (first + 0.08 * column * side + 0.08 * row * up).normalized(),
                                   center, scene.UpInWorld());
      Frame frame;
      frame.image = {.pixels = simulator.CleanSrgb(view.cam_from_world), .transfer = Transfer::kSrgb};
      frame.id = id++;
      writer.AddView(frame, view);
    }
  writer.SetSubject(scene.subject());
  writer.Close(1.0);
}

TEST(TemporalQuality, ComparesFieldsWithTheTruth) {
  test::ScratchFolder scratch;
  const std::string dir = (scratch / "lf").string(), out = scratch.path().string();
  setenv(kMeasureChanged, "1", 1);  // pictures of a test are nobody's figures
  CaptureStudio(dir, "sim:studio?width=96&height=72&noise=0");
  const auto result =
      RunProgram(TEMPORAL_QUALITY, dir + " --path orbit --frames 60 --fields nearest,subdivision --strips " +
                                       out + "/strips.png --plot " + out + "/restless.svg --json");
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  const auto report = JsonFromText(result.output);
  EXPECT_EQ(report["truth"], "sim:studio?width=96&height=72&noise=0");
  ASSERT_EQ(report["results"].size(), 2u);
  const auto& nearest = report["results"][0];
  const auto& subdivision = report["results"][1];
  EXPECT_EQ(subdivision["over_time"].size(), 58u);
  EXPECT_GT(subdivision["temporal_error"], 0);
  // The nearest photograph jumps.
  EXPECT_GT(nearest["temporal_error_disc"], 1.5 * subdivision["temporal_error_disc"].get<double>());
  // It does at points of the scene, too, more so than pixel by pixel.
  EXPECT_GT(nearest["step_error_disc"], 1.5 * subdivision["step_error_disc"].get<double>());
  EXPECT_NEAR(nearest["step_energy"], std::pow(nearest["step_error"].get<double>(), 2), 1e-9);
  EXPECT_TRUE(fs::exists(out + "/restless.svg"));
  const cv::Mat strips = cv::imread(out + "/strips.png");
  EXPECT_EQ(strips.cols, 480);
  EXPECT_EQ(strips.rows, 3 * (22 + 36));
}

TEST(TemporalQuality, SaysWhatItNeeds) {
  test::ScratchFolder scratch;
  const std::string dir = (scratch / "lf").string(), truth = (scratch / "truth").string();
  test::WriteLightField(dir, {.viewpoints = test::GridViewpoints(4, 4, 0.2, 2.0)}, true);
  const std::string arguments = dir + " --fields linear --path ";
  const auto expect = [&](const std::string& options, const std::string& says) {
    const auto result = RunProgram(TEMPORAL_QUALITY, arguments + options);
    EXPECT_EQ(result.exit_code, 1) << options << result.errors;
    EXPECT_THAT(result.errors, HasSubstr(says)) << options;
  };
  expect("orbit", "--truth");
  expect("orbit --truth " + truth, "frame_00000.png");
  expect("orbit --truth sim:studio", "does not look like this scene");
  expect("orbit --truth " + truth + " --strips strips.gif", ".png");
  fs::create_directory(truth);
  expect("orbit --truth " + truth, "frame_00000.png");
  // Its own pictures as truth: what is drawn again is no error, what differs is.
  ASSERT_EQ(RunUlf("render " + dir +
                   " --path spiral --frames 4 --zoom 1 --field linear --proxy plane --format exr -o " + truth)
                .exit_code,
            0);
  const auto same = RunProgram(TEMPORAL_QUALITY,
                               arguments + "spiral --frames 4 --fields nearest --truth " + truth + " --json");
  ASSERT_EQ(same.exit_code, 0) << same.errors;
  const auto report = JsonFromText(same.output);
  EXPECT_LT(report["results"][0]["temporal_error"], 0.2) << "EXR rounds to half floats";
  EXPECT_GT(report["results"][1]["temporal_error"], 1);
  EXPECT_TRUE(report["results"][1]["step_error"].is_null()) << "pictures have no depth";
  expect("spiral --frames 5 --truth " + truth, "frame_00004.png");
}

}  // namespace
}  // namespace ulf::test
