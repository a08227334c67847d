// Tests: core/fiducials/marker_detector, core/fiducials/board, core/fiducials/board_detector,
// commands/calibration/board_command.
//
// Kalibr's AprilGrid, and boards of other makers by the words behind their text.
#include <gmock/gmock.h>

#include <algorithm>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/imgproc.hpp>

#include "acquisition/simulator/simulated_board.h"
#include "core/base/error.h"
#include "core/fiducials/board_detector.h"
#include "core/fiducials/marker_detector.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::april_grid_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

cv::Mat Drawn(const Board& board, double px_per_mm, double margin_mm) {
  const auto px = [&](double mm) { return static_cast<int>(std::lround((mm + margin_mm) * px_per_mm)); };
  cv::Mat image(px(board.HeightMm() + margin_mm), px(board.WidthMm() + margin_mm), CV_8UC1, cv::Scalar(255));
  for (const RectangleMm& r : board.Dark())
    image(cv::Rect({px(r.x), px(r.y)}, cv::Point(px(r.x + r.width), px(r.y + r.height)))) = 0;
  return image;
}

// The rule of Kalibr's pages, written down anew: the lower left corner of tag i is at (i % columns) (size +
// gap) and (i / columns) (size + gap), x to the right, y up; on a sheet whose y runs down, and which begins
// with the squares of the rim.
TEST(AprilGrid, LiesAsKalibrsRuleSays) {
  const Board board = Board::Parse("aprilgrid:5x3:30:9");
  EXPECT_EQ(board.Text(), "aprilgrid:5x3:30:9");
  const auto points = board.Points();
  ASSERT_EQ(points.size(), 4u * 15u);
  EXPECT_DOUBLE_EQ(board.WidthMm(), 5 * 30 + 6 * 9);
  EXPECT_DOUBLE_EQ(board.HeightMm(), 3 * 30 + 4 * 9);
  const double spacing = 9.0 / 30;
  for (std::size_t i = 0; i < 15; ++i) {
    const double right = static_cast<double>(i % 5) * 30 * (1 + spacing),
                 up = static_cast<double>(i / 5) * 30 * (1 + spacing);
    const Eigen::Vector3d lower_left(9 + right, board.HeightMm() - 9 - up, 0);
    EXPECT_LT((points[4 * i + 3] - lower_left).norm(), 1e-9) << i;
    EXPECT_LT((points[4 * i + 1] - lower_left - Eigen::Vector3d(30, -30, 0)).norm(), 1e-9) << i;
  }
}

// The first code of AprilTag's family 36h11 is d5d628584: its bits from the upper left row by row, 1 is
// white, two cells of border around. The square at the tag's corner is as large as the gap.
TEST(AprilGrid, TagsStandAsTheAprilTagLibraryDrawsThem) {
  const Board board = Board::Parse("aprilgrid:2x2:30:9");
  const cv::Mat sheet = Drawn(board, 4, 0);
  const std::uint64_t code = 0xd5d628584;
  // Tag 0 is the lower left one.
  const double x0 = 9, y0 = 9 + 30 + 9, cell = 3;
  for (int row = 0; row < 10; ++row)
    for (int column = 0; column < 10; ++column) {
      const bool inside = row >= 2 && row < 8 && column >= 2 && column < 8;
      const bool white = inside && (code >> (35 - 6 * (row - 2) - (column - 2)) & 1) != 0;
      const auto at = [&](double mm) { return static_cast<int>(mm * 4); };
      EXPECT_EQ(sheet.at<std::uint8_t>(at(y0 + (row + 0.5) * cell), at(x0 + (column + 0.5) * cell)),
                white ? 255 : 0)
          << row << ", " << column;
    }
  const auto is_dark = [&](double x, double y) {
    return sheet.at<std::uint8_t>(static_cast<int>(4 * y), static_cast<int>(4 * x)) == 0;
  };
  for (const double x : {0.5, 8.5, 39.5, 47.5, 78.5, 86.5})
    for (const double y : {0.5, 8.5, 39.5, 47.5, 78.5, 86.5}) EXPECT_TRUE(is_dark(x, y)) << x << ", " << y;
  EXPECT_FALSE(is_dark(4.5, 20));
  EXPECT_FALSE(is_dark(20, 4.5));
  EXPECT_FALSE(is_dark(43.5, 20));
}

// Views through a lens that is known, of which every tag in sight must be found where the lens puts
// it. The squares touch the tags' corners: these are found far better than those of ArUco markers, and
// not a cell off.
TEST(AprilGrid, IsFoundWhereTheLensPutsIt) {
  const Board board = Board::Parse("aprilgrid:6x6:30:9");
  const auto points = board.Points();
  for (const char* lens : {"pinhole", "barrel", "wide"}) {
    const BoardScene scene({.board = board, .camera = SimulatedLens(lens, 640, 480)});
    std::vector<double> errors;
    std::size_t whole = 0, found = 0;
    for (std::uint64_t stop = 0; stop < 4; ++stop) {
      const Rigid3 pose = scene.HeldAt(stop, 0);
      const auto seen_at = [&](std::size_t id) {
        return scene.options().camera.ImgFromCam(pose * points[id]);
      };
      for (std::size_t tag = 0; tag < 36; ++tag) {
        bool in_sight = true;
        for (std::size_t k = 0; k < 4; ++k) {
          const auto img = seen_at(4 * tag + k);
          in_sight = in_sight && img && img->x() > 8 && img->y() > 8 && img->x() < 632 && img->y() < 472;
        }
        whole += in_sight;
      }
      const BoardView view = DetectBoard(board, scene.Render(pose, stop));
      found += view.ids.size() / 4;
      for (std::size_t i = 0; i < view.ids.size(); ++i)
        errors.push_back((view.img[i] - *seen_at(static_cast<std::size_t>(view.ids[i]))).norm());
    }
    ASSERT_GT(whole, 40u) << lens;
    EXPECT_GT(static_cast<double>(found), 0.9 * static_cast<double>(whole)) << lens;
    std::ranges::sort(errors);
    EXPECT_LT(errors[errors.size() / 2], 0.15) << lens;
    EXPECT_LT(errors.back(), 0.8) << lens
                                  << ": a tag that the edge of the picture cuts has corners that are none";
  }
}

// Boards that were drawn with OpenCV's dictionary have their tags half a turn round, each on its place.
TEST(AprilGrid, TagsOnTheirHeadsAreTheSameBoard) {
  const Board board = Board::Parse("aprilgrid:4x3:30:9");
  cv::Mat sheet = Drawn(board, 3, 12);
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column) {
      cv::Mat tag = sheet(cv::Rect(3 * (12 + 9 + 39 * column), 3 * (12 + 9 + 39 * row), 90, 90));
      cv::flip(tag.clone(), tag, -1);
    }
  for (int quarter = 0; quarter < 4; ++quarter) {
    const BoardView view = DetectBoard(board, sheet);
    ASSERT_EQ(view.ids.size(), 48u) << quarter;
    for (std::size_t i = 0; i < view.ids.size(); ++i) {
      const Eigen::Vector3d point = board.Points()[static_cast<std::size_t>(view.ids[i])];
      Eigen::Vector2d expected = 3 * (point.head<2>() + Eigen::Vector2d(12, 12));
      double width = 3 * (board.WidthMm() + 24), height = 3 * (board.HeightMm() + 24);
      for (int turn = 0; turn < quarter; ++turn) {
        expected = {height - expected.y(), expected.x()};
        std::swap(width, height);
      }
      EXPECT_LT((view.img[i] - expected).norm(), 0.3) << view.ids[i] << " turned " << quarter;
    }
    cv::rotate(sheet, sheet, cv::ROTATE_90_CLOCKWISE);
  }
}

// A grid of ArUco markers with squares between: OpenCV's detector takes both for one outline.
TEST(BoardDetector, FindsMarkersWhoseCornersTouchSquares) {
  const Board board = Board::Parse("aruco:5x4:30:9:DICT_6X6_250");
  cv::Mat sheet = Drawn(board, 1.6, 20);
  for (int row = 0; row <= 4; ++row)
    for (int column = 0; column <= 5; ++column)
      cv::rectangle(sheet,
                    cv::Rect(static_cast<int>(std::lround(1.6 * (20 - 9 + 39 * column))),
                             static_cast<int>(std::lround(1.6 * (20 - 9 + 39 * row))), 14, 14),
                    cv::Scalar(0), cv::FILLED);
  cv::GaussianBlur(sheet, sheet, {}, 0.8);
  const BoardView view = DetectBoard(board, sheet);
  EXPECT_GE(view.ids.size(), 72u);
  for (std::size_t i = 0; i < view.ids.size(); ++i) {
    const Eigen::Vector3d point = board.Points()[static_cast<std::size_t>(view.ids[i])];
    EXPECT_LT((view.img[i] - 1.6 * (point.head<2>() + Eigen::Vector2d(20, 20))).norm(), 1.0) << view.ids[i];
  }
}

TEST(Board, WordsBehindItComeBackAndAreChecked) {
  for (const char* text :
       {"charuco:6x8:20:15:DICT_4X4_50:white-corner", "aruco:4x5:37.5:5:DICT_6X6_1000:right-up:first=36",
        "aprilgrid:6x6:30:9:right-down", "charuco:7x5:30:22:DICT_5X5_100:up-left"})
    EXPECT_EQ(Board::Parse(text).Text(), text);
  EXPECT_EQ(Board::Parse("aprilgrid:6x6:30:9:right-up").Text(), "aprilgrid:6x6:30:9") << "the usual way";
  for (const auto& [text, mentioned] : {std::pair{"aprilgrid:6x6:30", "aprilgrid:6x6:30:9"},
                                        std::pair{"aprilgrid:6x6:30:9:DICT_5X5_50", "first=N"},
                                        std::pair{"aprilgrid:30x30:30:9", "900 markers"},
                                        std::pair{"aruco:4x5:37:5:DICT_5X5_50:first=31", "51 markers"},
                                        std::pair{"aruco:4x5:37:5:DICT_5X5_50:white-corner", "white-corner"},
                                        std::pair{"aruco:4x5:37:5:DICT_5X5_50:first=-1", "first=-1"},
                                        std::pair{"chessboard:8x6:25:right-up", "chessboard:8x6:25"}}) {
    EXPECT_THAT([&text = text] { Board::Parse(text); }, testing::ThrowsMessage<Refusal>(HasSubstr(mentioned)))
        << text;
  }
}

// Each is drawn by its own text, and found with every point at its place; with the text of another it is not.
TEST(BoardDetector, FindsBoardsOfOtherMakers) {
  for (const char* text :
       {"charuco:6x4:30:22:DICT_5X5_100:white-corner", "charuco:7x4:30:22:DICT_5X5_100:white-corner",
        "charuco:5x6:30:22:DICT_5X5_100:first=20", "charuco:6x5:30:22:DICT_5X5_100:left-up",
        "aruco:4x3:30:9:DICT_6X6_250:right-up", "aruco:4x3:30:9:DICT_6X6_250:down-right:first=100",
        "aprilgrid:4x3:30:9:first=50"}) {
    const Board board = Board::Parse(text);
    const BoardView view = DetectBoard(board, Drawn(board, 3, 15));
    const auto points = board.Points();
    ASSERT_EQ(view.ids.size(), points.size()) << text;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector2d expected =
          3 * (points[static_cast<std::size_t>(view.ids[i])].head<2>() + Eigen::Vector2d(15, 15));
      EXPECT_LT((view.img[i] - expected).norm(), 1.0) << text << ", point " << view.ids[i];
    }
  }
}

// Below 4.6 OpenCV counted a ChArUco board's rows from below: with an even number of them a marker was in the
// upper left corner.
TEST(Board, TheWhiteCornerIsThatOfOpenCvBefore46) {
  const Board board = Board::Parse("charuco:5x4:30:22:DICT_5X5_100:white-corner");
  const auto places = board.MarkerPlaces();
  std::vector<Eigen::Vector2i> expected;
  for (int from_below = 3; from_below >= 0; --from_below)
    for (int column = 0; column < 5; ++column)
      if (from_below % 2 != column % 2) expected.emplace_back(column, 3 - from_below);
  EXPECT_EQ(places, expected);
}

TEST(BoardCommand, PrintsAnAprilGrid) {
  const test::ScratchFolder scratch;
  const std::string file = (scratch / "grid.svg").string();
  const auto result = test::RunUlf("board aprilgrid:5x6:24:7.2 --page a4 -o " + file);
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, AllOf(HasSubstr("aprilgrid:5x6:24:7.2"), HasSubstr("ulf calibrate")));
}

}  // namespace
}  // namespace ulf::april_grid_test
