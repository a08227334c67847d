// Tests: core/fiducials/board, core/fiducials/board_detector, core/fiducials/marker_detector,
// core/fiducials/aruco_calls, acquisition/calibration/board_sheet, acquisition/simulator/simulated_board,
// commands/calibration/board_command.
#include "core/fiducials/board.h"

#include <gmock/gmock.h>

#include <opencv2/aruco.hpp>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>

#include "acquisition/calibration/board_sheet.h"
#include "acquisition/simulator/simulated_board.h"
#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/fiducials/board_detector.h"
#include "core/fiducials/marker_detector.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::board_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kBoards[] = {"charuco:7x5:30:22:DICT_5X5_100",        "charuco:6x8:20:15.5:DICT_4X4_50",
                                   "aruco:4x5:37.5:5:DICT_6X6_1000",        "chessboard:8x6:25",
                                   "charuco:5x5:36:27:DICT_APRILTAG_36h11", "aprilgrid:4x5:36:9"};

cv::Mat Raster(const std::vector<RectangleMm>& dark, double width_mm, double height_mm, double px_per_mm) {
  cv::Mat image(static_cast<int>(std::lround(height_mm * px_per_mm)),
                static_cast<int>(std::lround(width_mm * px_per_mm)), CV_8UC1, cv::Scalar(255));
  const auto px = [&](double mm) { return static_cast<int>(std::lround(mm * px_per_mm)); };
  for (const RectangleMm& r : dark)
    image(cv::Rect({px(r.x), px(r.y)}, cv::Point(px(r.x + r.width), px(r.y + r.height)))) = 0;
  return image;
}

TEST(Board, TextComesBack) {
  for (const char* text : kBoards) EXPECT_EQ(Board::Parse(text).Text(), text);
}

TEST(Board, RefusesWhatCannotBePrinted) {
  const std::pair<const char*, const char*> kCases[] = {
      {"dots:3x3:5", "dots"},
      {"charuco:7x5:30:22", "charuco:7x5:30:22:DICT_5X5_100"},
      {"charuco:7x5:30:31:DICT_5X5_100", "smaller"},
      {"charuco:7x5:30:22:DICT_9X9", "DICT_9X9"},
      {"charuco:7by5:30:22:DICT_5X5_100", "7by5"},
      {"charuco:2x2:30:22:DICT_5X5_100", "squares"},
      {"charuco:20x20:30:22:DICT_5X5_100", "200 markers"},
      {"chessboard:8x6:-25", "-25"},
      {"chessboard:8x6:25mm", "25mm"},
  };
  for (const auto& [text, mentioned] : kCases) {
    EXPECT_THAT([&text = text] { Board::Parse(text); }, testing::ThrowsMessage<Refusal>(HasSubstr(mentioned)))
        << text;
  }
}

// What is drawn here is what OpenCV draws and looks for.
TEST(Board, MetresAreAskedAbout) {
  for (const auto& [text, meant] :
       {std::pair{"aprilgrid:6x6:0.03:0.3", "aprilgrid:6x6:30:9"},
        {"aprilgrid:6x6:0.088:0.0264", "aprilgrid:6x6:88:26.4"},
        {"charuco:7x5:0.03:0.022:DICT_5X5_100", "charuco:7x5:30:22:DICT_5X5_100"},
        {"aruco:4x5:0.0375:0.005:DICT_6X6_1000", "aruco:4x5:37.5:5:DICT_6X6_1000"},
        {"chessboard:8x6:0.025", "chessboard:8x6:25"}}) {
    const auto result = test::RunUlf(std::string("board ") + text + " -o /nowhere/board.pdf");
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_THAT(result.errors,
                AllOf(HasSubstr("millimetres"), HasSubstr(std::string("give ") + meant + "\n")));
    EXPECT_EQ(Board::Parse(meant).Text(), meant);
  }
  EXPECT_EQ(Board::Parse("chessboard:8x6:1").square_mm, 1);
}

TEST(Board, MatchesOpenCvs) {
  for (const char* text : kBoards) {
    const Board board = Board::Parse(text);
    // OpenCV has no AprilGrid (april_grid_test).
    if (board.kind == BoardKind::kChessboard || board.kind == BoardKind::kAprilGrid) continue;
    const auto dictionary = cv::aruco::getPredefinedDictionary(DictionaryNumber(board.dictionary));
    const cv::Size size(static_cast<int>(board.WidthMm() * 8), static_cast<int>(board.HeightMm() * 8));
    cv::Mat theirs;
    if (board.kind == BoardKind::kCharuco) {
      const auto charuco =
          cv::aruco::CharucoBoard::create(board.columns, board.rows, static_cast<float>(board.square_mm),
                                          static_cast<float>(board.marker_mm), dictionary);
      charuco->draw(size, theirs, 0, 1);
      const auto points = board.Points();
      ASSERT_EQ(points.size(), charuco->chessboardCorners.size());
      for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_FLOAT_EQ(static_cast<float>(points[i].x()), charuco->chessboardCorners[i].x);
        EXPECT_FLOAT_EQ(static_cast<float>(points[i].y()), charuco->chessboardCorners[i].y);
      }
      const auto markers = board.MarkerPoints();
      ASSERT_EQ(markers.size(), 4 * charuco->objPoints.size());
      for (std::size_t i = 0; i < markers.size(); ++i) {
        EXPECT_FLOAT_EQ(static_cast<float>(markers[i].x()), charuco->objPoints[i / 4][i % 4].x);
        EXPECT_FLOAT_EQ(static_cast<float>(markers[i].y()), charuco->objPoints[i / 4][i % 4].y);
      }
    } else {
      const auto grid =
          cv::aruco::GridBoard::create(board.columns, board.rows, static_cast<float>(board.marker_mm),
                                       static_cast<float>(board.gap_mm), dictionary);
      grid->draw(size, theirs, 0, 1);
      for (std::size_t i = 0; i < grid->objPoints.size(); ++i)
        for (std::size_t k = 0; k < 4; ++k) {
          EXPECT_FLOAT_EQ(static_cast<float>(board.Points()[4 * i + k].x()), grid->objPoints[i][k].x);
          EXPECT_FLOAT_EQ(static_cast<float>(board.Points()[4 * i + k].y()), grid->objPoints[i][k].y);
        }
    }
    const cv::Mat ours = Raster(board.Dark(), board.WidthMm(), board.HeightMm(), 8);
    ASSERT_EQ(ours.size(), theirs.size());
    // OpenCV rounds markers to whole cells: a rim of a few pixels may differ, never a cell.
    cv::Mat differ = ours != theirs;
    cv::erode(differ, differ, cv::Mat::ones(7, 7, CV_8U));
    EXPECT_EQ(cv::countNonZero(differ), 0) << text;
  }
}

// The numbers in the file itself, read back and drawn: every corner where the layout says.
std::vector<RectangleMm> PdfRectangles(const std::string& pdf, double page_height_mm) {
  std::vector<RectangleMm> found;
  std::istringstream lines(pdf);
  for (std::string line; std::getline(lines, line);) {
    RectangleMm r;
    if (line.ends_with(" re") &&
        std::sscanf(line.c_str(), "%lf %lf %lf %lf", &r.x, &r.y, &r.width, &r.height) == 4) {
      r.y = page_height_mm - r.y - r.height;
      found.push_back(r);
    }
  }
  return found;
}

std::vector<RectangleMm> SvgRectangles(const std::string& svg) {
  std::vector<RectangleMm> found;
  for (std::size_t at = svg.find(" d=\"") + 4; svg[at] == 'M';) {
    RectangleMm r;
    int used = 0;
    if (std::sscanf(svg.c_str() + at, "M%lf %lfh%lfv%lfh%*fz%n", &r.x, &r.y, &r.width, &r.height, &used) != 4)
      break;
    found.push_back(r);
    at += static_cast<std::size_t>(used);
  }
  return found;
}

TEST(BoardSheet, IsTrueInSizeAndDetected) {
  for (const char* text : kBoards) {
    const Board board = Board::Parse(text);
    const SheetLayout layout = LayOutSheet(board, "a4");
    const std::string pdf = SheetPdf(board, layout), svg = SheetSvg(board, layout);
    EXPECT_THAT(pdf, HasSubstr(board.Text()));
    EXPECT_THAT(svg, HasSubstr(board.Text()));
    EXPECT_THAT(svg, HasSubstr(fmt::format("width=\"{:g}mm\"", layout.page_width_mm)));
    EXPECT_THAT(pdf, HasSubstr(fmt::format("{:.9f} 0 0 {:.9f} 0 0 cm", 72 / 25.4, 72 / 25.4)));
    const auto rectangles = PdfRectangles(pdf, layout.page_height_mm), of_svg = SvgRectangles(svg);
    ASSERT_EQ(of_svg.size(), rectangles.size()) << text;
    for (std::size_t i = 0; i < rectangles.size(); ++i) {
      EXPECT_NEAR(of_svg[i].x, rectangles[i].x, 1e-3) << text << " rectangle " << i;
      EXPECT_NEAR(of_svg[i].y, rectangles[i].y, 1e-3) << text << " rectangle " << i;
      EXPECT_NEAR(of_svg[i].width, rectangles[i].width, 1e-3) << text << " rectangle " << i;
      EXPECT_NEAR(of_svg[i].height, rectangles[i].height, 1e-3) << text << " rectangle " << i;
    }
    ASSERT_EQ(rectangles.size(), board.Dark().size() + 3) << text;  // and the scale bar
    EXPECT_NEAR(rectangles[1].x + rectangles[1].width - rectangles[0].x, layout.bar_mm, 1e-3);
    constexpr double kPxPerMm = 4;
    const cv::Mat page = Raster(rectangles, layout.page_width_mm, layout.page_height_mm, kPxPerMm);
    const BoardView view = DetectBoard(board, page);
    const auto points = board.Points();
    ASSERT_EQ(view.ids.size(), points.size()) << text;
    for (std::size_t i = 0; i < view.ids.size(); ++i) {
      const auto& point = points[static_cast<std::size_t>(view.ids[i])];
      const Eigen::Vector2d expected =
          kPxPerMm * Eigen::Vector2d(layout.board_x_mm + point.x(), layout.board_y_mm + point.y());
      // Marker corners are rounded to whole pixels when drawn; a chessboard may be counted from its other
      // end.
      const Eigen::Vector2d other =
          kPxPerMm * Eigen::Vector2d(layout.board_x_mm + board.WidthMm() - point.x(),
                                     layout.board_y_mm + board.HeightMm() - point.y());
      const double miss = (view.img[i] - expected).norm();
      EXPECT_LT(board.kind == BoardKind::kChessboard ? std::min(miss, (view.img[i] - other).norm()) : miss,
                1.0)
          << text << " point " << view.ids[i];
    }
  }
}

TEST(BoardSheet, RefusesWhatDoesNotFit) {
  const Board board = Board::Parse("chessboard:8x6:60");
  EXPECT_THROW(LayOutSheet(board, "a4"), Refusal);
  EXPECT_THROW(LayOutSheet(board, "a5"), Refusal);
  const SheetLayout own = LayOutSheet(board, "board");
  EXPECT_GE(own.page_width_mm, 8 * 60 + 20);
}

TEST(BoardSheet, PdfTableOfObjectsIsRight) {
  const Board board;
  const std::string pdf = SheetPdf(board, LayOutSheet(board, "a4"));
  const std::size_t start = static_cast<std::size_t>(std::stoul(pdf.substr(pdf.rfind("startxref\n") + 10)));
  ASSERT_EQ(pdf.substr(start, 5), "xref\n");
  for (int object = 1; object <= 5; ++object) {
    const std::size_t entry = start + 5 + 4 + 20 * static_cast<std::size_t>(object);
    const std::size_t offset = static_cast<std::size_t>(std::stoul(pdf.substr(entry, 10)));
    EXPECT_EQ(pdf.substr(offset, 7), fmt::format("{} 0 obj", object));
  }
}

TEST(BoardCommand, WritesBothAndRefusesOthers) {
  const test::ScratchFolder scratch;
  const auto pdf = (scratch / "b.pdf").string(), svg = (scratch / "b.svg").string();
  const auto result = test::RunUlf("board chessboard:9x6:20 -o " + pdf + " -o " + svg + " --json");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, HasSubstr("chessboard:9x6:20"));
  EXPECT_TRUE(ReadWholeFile(pdf).starts_with("%PDF-"));
  EXPECT_TRUE(ReadWholeFile(svg).starts_with("<?xml"));
  const std::string sheet = ReadWholeFile(pdf);
  EXPECT_EQ(test::RunUlf("board chessboard:9x6:20 -o " + pdf).exit_code, 0) << "the same again";
  const auto other =
      test::RunUlf("board chessboard:8x6:20 -o " + (scratch / "new.svg").string() + " -o " + pdf);
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_THAT(other.errors, AllOf(HasSubstr("b.pdf: exists already"), HasSubstr("choose another name")));
  EXPECT_EQ(ReadWholeFile(pdf), sheet);
  EXPECT_FALSE(std::filesystem::exists(scratch / "new.svg"));
  EXPECT_EQ(test::RunUlf("board -o " + (scratch / "b.png").string()).exit_code, 2);
  EXPECT_EQ(test::RunUlf("board chessboard:90x60:20 -o " + pdf).exit_code, 2);
  const auto unknown = test::RunUlf("board foo:1 -o " + pdf);
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_THAT(unknown.errors, AllOf(HasSubstr("board 'foo:1'"), Not(HasSubstr("--board"))));
}

// Rendered through each lens from known places: found where the model says.
TEST(BoardDetector, FindsCornersWhereTheLensPutsThem) {
  for (const char* text :
       {"charuco:7x5:30:22:DICT_5X5_100", "aruco:4x3:45:9:DICT_6X6_1000", "chessboard:8x6:25"})
    for (const char* lens : {"pinhole", "barrel", "wide", "fisheye"}) {
      const Board board = Board::Parse(text);
      const BoardScene scene({.board = board, .camera = SimulatedLens(lens, 640, 480)});
      const auto points = board.Points();
      std::size_t seen = 0;
      std::vector<double> errors;
      constexpr std::uint64_t kStops = 5;
      for (std::uint64_t stop = 0; stop < kStops; ++stop) {
        const Rigid3 pose = scene.HeldAt(stop, 0);
        const BoardView view = DetectBoard(board, scene.Render(pose, stop));
        seen += !view.ids.empty();
        // Of a chessboard cut by the image's edge a part may be taken for the whole, one square off.
        const auto& camera = scene.options().camera;
        const auto in_sight = [&](double x, double y) {
          const auto img = camera.ImgFromCam(pose * Eigen::Vector3d(x, y, 0));
          return img && camera.Contains(*img);
        };
        const double w = board.WidthMm(), h = board.HeightMm();
        const bool whole = in_sight(0, 0) && in_sight(w, 0) && in_sight(w, h) && in_sight(0, h);
        if (board.kind == BoardKind::kChessboard && !whole) continue;
        for (std::size_t i = 0; i < view.ids.size(); ++i) {
          const auto id = static_cast<std::size_t>(view.ids[i]);
          const auto expected = scene.options().camera.ImgFromCam(pose * points[id]);
          const auto other = scene.options().camera.ImgFromCam(pose * points[points.size() - 1 - id]);
          ASSERT_TRUE(expected && other);
          double error = (view.img[i] - *expected).norm();
          if (board.kind == BoardKind::kChessboard) error = std::min(error, (view.img[i] - *other).norm());
          errors.push_back(error);
        }
      }
      EXPECT_GE(seen, board.kind == BoardKind::kChessboard ? 2u : 4u) << text << ", " << lens;
      std::sort(errors.begin(), errors.end());
      // Marker corners are found less well than saddle points.
      const double limit = board.kind == BoardKind::kArucoGrid ? 0.6 : 0.12;
      EXPECT_LT(errors[errors.size() / 2], limit) << text << ", " << lens;
      if (board.kind != BoardKind::kArucoGrid) {
        EXPECT_LT(errors[errors.size() * 9 / 10], 3 * limit) << text << ", " << lens;
      }
    }
}

TEST(BoardDetector, SharpnessIsTheBlursWidth) {
  const Board board;
  const BoardScene scene(
      {.board = board, .camera = SimulatedLens("pinhole", 640, 480), .noise_levels = 0, .blur_px = 0});
  const cv::Mat sharp = scene.Render(scene.HeldAt(3, 0), 1);
  const BoardView view = DetectBoard(board, sharp);
  ASSERT_FALSE(view.ids.empty());
  double last = EdgeBlurPx(view, sharp);
  EXPECT_LT(last, 0.8);
  for (const double blur : {1.5, 3.0, 5.0}) {
    cv::Mat blurred;
    cv::GaussianBlur(sharp, blurred, {}, blur);
    const double measured = EdgeBlurPx(view, blurred);
    EXPECT_GT(measured, last) << blur;
    EXPECT_NEAR(measured, blur, 0.45 * blur) << blur;
    last = measured;
  }
}

TEST(MarkerDetector, FindsNumberAndSubpixelCorners) {
  const auto dictionary = cv::aruco::getPredefinedDictionary(cv::aruco::DICT_4X4_50);
  cv::Mat marker, page(240, 320, CV_8UC1, cv::Scalar(255));
  cv::aruco::drawMarker(dictionary, 17, 90, marker);
  marker.copyTo(page(cv::Rect(100, 60, 90, 90)));
  const auto found = DetectMarkers("DICT_4X4_50", page);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].first, 17);
  // Pixel centres are at integer + 0.5: the edges of the marker's pixels are whole numbers.
  const MarkerImage truth{{{100, 60}, {190, 60}, {190, 150}, {100, 150}}};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_LT((found[0].second[i] - truth[i]).norm(), 0.2) << i;
  EXPECT_THROW(DetectMarkers("DICT_9X9", page), Refusal);
  EXPECT_TRUE(DetectMarkers("DICT_4X4_50", cv::Mat(240, 320, CV_8UC1, cv::Scalar(255))).empty());
}

}  // namespace
}  // namespace ulf::board_test
