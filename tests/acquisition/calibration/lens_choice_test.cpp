// Tests: acquisition/calibration/lens_choice, acquisition/calibration/lens_fit,
// acquisition/calibration/calibrate, acquisition/calibration/calibration_capture,
// acquisition/calibration/calibration_picture, commands/calibration/calibration_report,
// core/geometry/camera_model.
#include <gmock/gmock.h>

#include <filesystem>

#include "acquisition/calibration/calibrate.h"
#include "acquisition/calibration/calibration_capture.h"
#include "acquisition/calibration/calibration_picture.h"
#include "acquisition/simulator/simulated_board.h"
#include "commands/calibration/calibration_report.h"
#include "tests/acquisition/calibration/synthetic_board_views.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"
#include "tests/support/test_run.h"

namespace ulf::lens_choice_test {
namespace {

using test::MakeViews;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using Synthetic = test::SyntheticBoardViews;

CalibrationResult Calibrate(const Synthetic& s) {
  return CalibrateFromViews(Board(), MakeViews(s), s.camera.width, s.camera.height);
}

std::string Chosen(const CalibrationResult& result) {
  return result.ok() ? result.choice.table[result.choice.chosen].fit.candidate.name
                     : "refused: " + result.refusal;
}

TEST(CameraModel, DerivativesByParametersAreRight) {
  for (const char* lens : {"pinhole", "barrel", "wide", "fisheye"}) {
    CameraModel camera = SimulatedLens(lens, 640, 480);
    for (const Eigen::Vector3d& point : {Eigen::Vector3d(0.3, -0.2, 1), Eigen::Vector3d(-0.5, 0.4, 1.2)}) {
      Eigen::Matrix<double, 2, 3> by_point;
      Eigen::Matrix<double, 2, 9> by_parameters;
      ASSERT_TRUE(camera.ImgFromCam(point, &by_point, &by_parameters));
      double* const parameters[9] = {&camera.fx,
                                     &camera.fy,
                                     &camera.cx,
                                     &camera.cy,
                                     &camera.coefficients[0],
                                     &camera.coefficients[1],
                                     &camera.coefficients[2],
                                     &camera.coefficients[3],
                                     &camera.coefficients[4]};
      for (int i = 0; i < 9; ++i) {
        const double before = *parameters[i], step = 1e-6 * std::max(1.0, std::abs(before));
        *parameters[i] = before + step;
        const Eigen::Vector2d more = *camera.ImgFromCam(point);
        *parameters[i] = before - step;
        const Eigen::Vector2d less = *camera.ImgFromCam(point);
        *parameters[i] = before;
        EXPECT_LT((by_parameters.col(i) - (more - less) / (2 * step)).norm(), 1e-4)
            << lens << " parameter " << i;
      }
    }
  }
}

TEST(LensChoice, TakesWhatTheLensNeedsAndNoMore) {
  struct Case {
    const char* lens;
    Distortion distortion;
    int least, most;  // parameters
  };
  for (const Case& c :
       {Case{"pinhole", Distortion::kNone, 3, 3}, Case{"barrel", Distortion::kRadialTangential, 4, 4},
        Case{"wide", Distortion::kRadialTangential, 7, 7}, Case{"fisheye", Distortion::kFisheye, 5, 7}})
    for (const unsigned seed : test::SeedsOf({1, 2})) {
      const Synthetic s{
          .camera = SimulatedLens(c.lens, 640, 480), .views = 24, .noise_px = 0.08, .seed = seed};
      const CalibrationResult result = Calibrate(s);
      ASSERT_TRUE(result.ok()) << c.lens << ": " << result.refusal;
      const LensCandidate& chosen = result.choice.table[result.choice.chosen].fit.candidate;
      EXPECT_EQ(chosen.distortion, c.distortion) << c.lens << ", seed " << seed << ": " << chosen.name;
      EXPECT_GE(chosen.Parameters(), c.least) << c.lens << ", seed " << seed << ": " << chosen.name;
      EXPECT_LE(chosen.Parameters(), c.most) << c.lens << ", seed " << seed << ": " << chosen.name;
      EXPECT_LT(LargestDifferencePx(s.camera, result.camera, 0.8), 0.5) << c.lens << ", seed " << seed;
      EXPECT_NEAR(result.rms_px, 0.08 * std::sqrt(2.0), 0.02) << c.lens;
      // The truth lies within the errors that are claimed.
      EXPECT_LT(std::abs(result.camera.fx - s.camera.fx), 4 * result.sigma[0]) << c.lens << ", seed " << seed;
      EXPECT_LT(std::abs(result.camera.cx - s.camera.cx), 4 * result.sigma[2]) << c.lens << ", seed " << seed;
      EXPECT_LT(std::abs(result.camera.cy - s.camera.cy), 4 * result.sigma[3]) << c.lens << ", seed " << seed;
    }
}

// A distortion well below what the views can show is not modelled, one well above is.
TEST(LensChoice, ModelsADistortionOnceItShows) {
  for (const auto& [k1, shows] :
       {std::pair{0.0, false}, std::pair{-2e-4, false}, std::pair{-0.01, true}, std::pair{0.03, true}}) {
    CameraModel camera = SimulatedLens("pinhole", 640, 480);
    camera.distortion = Distortion::kRadialTangential;
    camera.coefficients[0] = k1;
    const CalibrationResult result = Calibrate({.camera = camera, .views = 12, .noise_px = 0.1});
    ASSERT_TRUE(result.ok()) << result.refusal;
    EXPECT_EQ(result.camera.distortion != Distortion::kNone, shows) << k1 << ": " << Chosen(result);
    EXPECT_EQ(result.camera.fx, result.camera.fy) << k1 << ": " << Chosen(result);
  }
  // Pixels that are not square.
  for (const auto& [ratio, shows] : {std::pair{1.00002, false}, std::pair{1.01, true}}) {
    CameraModel camera = SimulatedLens("pinhole", 640, 480);
    camera.fy *= ratio;
    const CalibrationResult result = Calibrate({.camera = camera, .views = 12, .noise_px = 0.1});
    ASSERT_TRUE(result.ok()) << result.refusal;
    EXPECT_EQ(result.camera.fx != result.camera.fy, shows) << ratio << ": " << Chosen(result);
  }
}

TEST(LensChoice, PredictedErrorsMatchTrueErrors) {
  // Over many draws of the noise the errors scatter as the standard deviations say.
  double normalized = 0;
  constexpr int kDraws = 10;
  for (int draw = 0; draw < kDraws; ++draw) {
    const Synthetic s{.camera = SimulatedLens("pinhole", 640, 480),
                      .views = 12,
                      .noise_px = 0.2,
                      .seed = static_cast<unsigned>(100 + draw)};
    const auto views = MakeViews(s);
    const LensFit fit = FitLens(Board().Points(), views, LensCandidates()[0], s.camera);
    ASSERT_TRUE(fit.usable);
    normalized += std::pow((fit.camera.fx - s.camera.fx) / fit.sigma[0], 2) / kDraws;
  }
  EXPECT_GT(normalized, 0.2);
  EXPECT_LT(normalized, 3);
}

TEST(Calibrate, OutliersAreTakenOut) {
  const Synthetic s{
      .camera = SimulatedLens("barrel", 640, 480), .views = 14, .noise_px = 0.1, .outlier_share = 0.05};
  const CalibrationResult result = Calibrate(s);
  ASSERT_TRUE(result.ok()) << result.refusal;
  EXPECT_GT(result.outliers, 10u);
  EXPECT_LT(result.rms_px, 0.2);
  EXPECT_LT(LargestDifferencePx(s.camera, result.camera, 0.8), 1.0);
  // Left in, each would pull by pixels; taken out, the claimed errors hold.
  EXPECT_LT(std::abs(result.camera.fx - s.camera.fx), 4 * result.sigma[0]);
  EXPECT_LT(std::abs(result.camera.cx - s.camera.cx), 4 * result.sigma[2]);
}

TEST(Calibrate, RefusesUninformativeViews) {
  const CameraModel camera = SimulatedLens("pinhole", 640, 480);
  // The board never moves.
  EXPECT_THAT(Calibrate({.camera = camera, .views = 14, .moves = false}).refusal, HasSubstr("same place"));
  // It moves, never tilted.
  EXPECT_THAT(Calibrate({.camera = camera, .views = 14, .largest_tilt = 0}).refusal,
              HasSubstr("orientation"));
  EXPECT_THAT(Calibrate({.camera = camera, .views = 3}).refusal, HasSubstr("at least 4"));
  EXPECT_THAT(CalibrateFromViews(Board(), {{"a", {}, {}}, {"b", {}, {}}}, 640, 480).refusal,
              HasSubstr("not found"));
}

TEST(Calibrate, WarnsOfPoorSets) {
  // The board in a quarter of the image, tilted to one side only.
  const Synthetic s{.camera = SimulatedLens("barrel", 640, 480), .views = 24, .noise_px = 0.1};
  std::vector<BoardView> views = MakeViews(s);
  std::erase_if(views, [&](const BoardView& view) {
    return std::any_of(view.img.begin(), view.img.end(),
                       [](const Eigen::Vector2d& img) { return img.x() > 380; });
  });
  ASSERT_GE(views.size(), 4u);
  const CalibrationResult result = CalibrateFromViews(Board(), views, 640, 480);
  const std::string all = result.refusal + (result.warnings.empty() ? "" : result.warnings[0]) +
                          (result.warnings.size() > 1 ? result.warnings[1] : "");
  EXPECT_TRUE(!result.ok() || !result.warnings.empty());
  EXPECT_THAT(all, ::testing::AnyOf(HasSubstr("cover"), HasSubstr("determine"))) << all;
}

TEST(Calibrate, FindsTheLensOfRenderedPictures) {
  for (const char* lens : {"barrel", "fisheye"}) {
    const BoardScene scene({.board = Board(), .camera = SimulatedLens(lens, 640, 480)});
    std::vector<BoardView> views;
    for (std::uint64_t stop = 0; stop < 14; ++stop) {
      views.push_back(DetectBoard(Board(), scene.Render(scene.HeldAt(stop, 0), stop)));
      views.back().name = std::to_string(stop);
    }
    const CalibrationResult result = CalibrateFromViews(Board(), views, 640, 480);
    ASSERT_TRUE(result.ok()) << lens << ": " << result.refusal;
    EXPECT_EQ(result.camera.distortion, scene.options().camera.distortion) << Chosen(result);
    EXPECT_LT(LargestDifferencePx(scene.options().camera, result.camera, 0.8), 1.0) << lens;
    EXPECT_LT(result.rms_px, 0.2) << lens;
    const cv::Mat picture = DrawCalibration(result);
    EXPECT_GT(picture.cols, 1200);
    EXPECT_THAT(ReportText(result, scene.options().camera), HasSubstr("truth"));
  }
}

CalibrationResult OfFolder(const std::filesystem::path& folder, const char* board) {
  const Board parsed = Board::Parse(board);
  const CollectedViews collected = CollectViews(ImagesIn({folder.string()}), parsed, {});
  return CalibrateFromViews(parsed, collected.views, collected.width, collected.height);
}

TEST(CalibrateReal, FindsTheLensOfAnArucoBoard) {
  ULF_NEED_TEST_DATA(folder, "aruco_board");
  const CalibrationResult result = OfFolder(folder / "aruco_data", "aruco:4x5:37.5:5:DICT_6X6_1000");
  ASSERT_TRUE(result.ok()) << result.refusal;
  EXPECT_LE(result.rms_px, 1.0);
  EXPECT_GT(result.views.size(), 35u);
  EXPECT_LT(result.sigma[2], 15);
  EXPECT_NEAR(result.camera.fx, 813, 40) << "what OpenCV's own calibration of the set gave";
}

TEST(CalibrateReal, WebcamSetComesOutWithAWarning) {
  ULF_NEED_TEST_DATA(folder, "chessboard_webcam");
  const CalibrationResult result = OfFolder(folder, "chessboard:8x8:25");
  ASSERT_TRUE(result.ok()) << result.refusal;
  EXPECT_THAT(result.warnings, Not(IsEmpty()));
}

TEST(CalibrateReal, BoardThatNeverMovesIsRefused) {
  ULF_NEED_TEST_DATA(folder, "chessboard_degenerate");
  EXPECT_THAT(OfFolder(folder, "chessboard:8x6:25").refusal, HasSubstr("same place"));
}

}  // namespace
}  // namespace ulf::lens_choice_test
