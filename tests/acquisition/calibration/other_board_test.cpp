// Tests: acquisition/calibration/other_board, acquisition/calibration/layout_fit,
// acquisition/calibration/calibration_capture, commands/calibration/calibrate_command,
// commands/calibration/calibrate_source.
//
// Another board than was said is told by its text; a right one never, however poor its views are.
#include "acquisition/calibration/other_board.h"

#include <gmock/gmock.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "acquisition/calibration/calibration_io.h"
#include "acquisition/simulator/simulated_board.h"
#include "core/geometry/angles.h"
#include "core/video/video_writer.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::other_board_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

// No larger than the markers need: a picture is read with every dictionary that is known.
constexpr int kWidth = 480, kHeight = 360;

std::vector<cv::Mat> PicturesOf(const std::string& board, const char* lens = "barrel", int count = 3,
                                double blur_px = 0.5, int width = kWidth) {
  const BoardScene scene({.board = Board::Parse(board),
                          .camera = SimulatedLens(lens, width, width * kHeight / kWidth),
                          .blur_px = blur_px});
  std::vector<cv::Mat> pictures;
  for (int stop = 0; stop < count; ++stop) {
    const auto at = static_cast<std::uint64_t>(stop);
    pictures.push_back(scene.Render(scene.HeldAt(at, 0), at));
  }
  return pictures;
}

TEST(OtherBoard, IsToldByItsText) {
  struct Case {
    const char *said, *shown, *told, *what;
  };
  for (const Case& c : {
           Case{"charuco:7x5:30:22:DICT_5X5_100", "charuco:5x7:30:22:DICT_5X5_100", "", "exchanged"},
           {"charuco:6x4:30:22:DICT_5X5_100", "charuco:6x4:30:22:DICT_5X5_100:white-corner", "",
            "before 4.6"},
           {"charuco:5x6:30:22:DICT_5X5_100", "charuco:5x6:30:22:DICT_5X5_100:white-corner", "",
            "before 4.6"},
           {"charuco:7x5:30:22:DICT_5X5_100", "charuco:7x5:30:22:DICT_5X5_100:first=17", "", "begin with 17"},
           {"charuco:7x5:30:22:DICT_5X5_50", "charuco:7x5:30:22:DICT_5X5_250:first=60",
            "charuco:7x5:30:22:DICT_5X5_100:first=60", "markers of DICT_5X5_100"},
           {"charuco:7x5:30:22:DICT_5X5_100", "charuco:7x5:30:22:DICT_4X4_50", "", "DICT_4X4_50"},
           {"charuco:7x5:30:22:DICT_5X5_100", "charuco:6x8:30:22:DICT_5X5_100", "", "6 x 8 instead of 7 x 5"},
           {"charuco:9x7:30:22:DICT_5X5_100", "charuco:7x5:30:22:DICT_5X5_100", "", "7 x 5 instead of 9 x 7"},
           {"aruco:5x4:30:9:DICT_6X6_250", "aruco:4x5:30:9:DICT_6X6_250", "", "exchanged"},
           {"aruco:5x4:30:9:DICT_6X6_250", "aruco:5x4:30:9:DICT_6X6_250:right-up", "", "numbered right-up"},
           {"aruco:4x4:30:9:DICT_6X6_250", "aruco:4x4:30:9:DICT_6X6_250:down-right", "", "down-right"},
           {"aruco:5x4:30:9:DICT_6X6_250", "aruco:5x4:30:9:DICT_6X6_250:first=36", "", "begin with 36"},
           {"aruco:5x4:30:15:DICT_6X6_250", "aruco:5x4:30:9:DICT_6X6_250", "", "of the marker, not 0.50"},
           {"aruco:6x6:30:9:DICT_APRILTAG_36h11", "aprilgrid:6x6:30:9", "", "Kalibr"},
           {"aprilgrid:6x6:30:9", "aruco:6x6:30:9:DICT_APRILTAG_36h11", "", "ArUco"},
           {"aprilgrid:5x6:30:9", "aprilgrid:6x5:30:9", "", "exchanged"},
           {"aprilgrid:6x6:30:0.3", "aprilgrid:6x6:30:9", "", "of the marker, not 0.01"},
           {"aprilgrid:6x6:30:9", "aprilgrid:6x6:30:9:first=36", "", "begin with 36"},
           {"aruco:5x4:30:9:DICT_5X5_100", "charuco:7x5:40:30:DICT_5X5_100", "charuco:7x5:40:30:DICT_5X5_100",
            "measure its lengths"},
           {"aruco:6x4:30:9:DICT_6X6_250:right-up:first=1", "aruco:6x4:30:9:DICT_6X6_250:right-up", "",
            "begin with 0"},
           {"chessboard:7x5:30", "charuco:7x5:30:20:DICT_4X4_50", "", "ChArUco"},
       }) {
    const Board said = Board::Parse(c.said);
    // A board whose numbers begin late is told apart only if whole rows are read.
    const int width = Board::Parse(c.shown).first_marker > 0 ? 640 : kWidth;
    const auto other = BoardInPictures(said, PicturesOf(c.shown, "barrel", 3, 0.5, width));
    ASSERT_TRUE(other) << c.said << " for " << c.shown;
    // Gaps are measured: to a few hundredths of the marker.
    const Board told = Board::Parse(*c.told ? c.told : c.shown);
    Board as_told = other->board;
    EXPECT_NEAR(as_told.gap_mm, told.gap_mm, 0.02 * told.marker_mm) << c.said << " for " << c.shown;
    EXPECT_NEAR(as_told.square_mm, told.square_mm, 0.03 * told.marker_mm) << c.said << " for " << c.shown;
    EXPECT_NEAR(as_told.marker_mm, told.marker_mm, 0.03 * told.marker_mm) << c.said << " for " << c.shown;
    if (told.kind == BoardKind::kAprilGrid) {
      EXPECT_NEAR(as_told.gap_mm, 0.3 * as_told.marker_mm, 0.051) << "Kalibr's own gap, rounded";
    }
    as_told.gap_mm = told.gap_mm;
    as_told.marker_mm = told.marker_mm;
    as_told.square_mm = told.square_mm;
    EXPECT_EQ(as_told.Text(), told.Text()) << "said " << c.said << ": " << other->what;
    EXPECT_THAT(other->what, HasSubstr(c.what)) << c.said << " for " << c.shown;
    const std::string text = DescribeOtherBoard(said, *other);
    EXPECT_THAT(text, AllOf(HasSubstr(std::string("do not lie as on ") + c.said),
                            HasSubstr("give board " + other->board.Text())));
  }
}

TEST(OtherBoard, MirroredPicturesAreSaidToBeMirrored) {
  const Board said = Board::Parse("charuco:7x5:30:22:DICT_5X5_100");
  std::vector<cv::Mat> pictures = PicturesOf(said.Text());
  for (cv::Mat& picture : pictures) cv::flip(picture.clone(), picture, 1);
  const auto other = BoardInPictures(said, pictures);
  ASSERT_TRUE(other);
  EXPECT_EQ(other->board, said);
  EXPECT_THAT(DescribeOtherBoard(said, *other), AllOf(HasSubstr("mirrored"), Not(HasSubstr("give board"))));
}

// Few views, small, half out of sight, blurred, through any lens, or of something else.
TEST(OtherBoard, ARightBoardIsNeverRenamed) {
  for (const char* text :
       {"charuco:7x5:30:22:DICT_5X5_100", "aruco:4x5:37.5:5:DICT_6X6_1000", "aprilgrid:6x6:30:9",
        "charuco:5x6:30:22:DICT_5X5_100:white-corner", "chessboard:8x6:25"}) {
    const Board said = Board::Parse(text);
    for (const auto& [lens, blur_px] : {std::pair{"pinhole", 1.5}, std::pair{"fisheye", 0.5}}) {
      const auto pictures = PicturesOf(text, lens, 2, blur_px);
      EXPECT_FALSE(BoardInPictures(said, pictures)) << text << ", " << lens;
      for (const cv::Rect& part : {cv::Rect(0, 0, kWidth / 2, kHeight), cv::Rect(0, 0, kWidth, kHeight / 2)})
        for (const cv::Mat& picture : pictures)
          EXPECT_FALSE(BoardInPictures(said, {picture(part).clone()})) << text << ", " << lens << ", a part";
    }
    cv::Mat nothing(kHeight, kWidth, CV_8UC1);
    cv::randu(nothing, 0, 255);
    EXPECT_FALSE(BoardInPictures(said, {nothing}));
    EXPECT_FALSE(BoardInPictures(said, {}));
  }
}

// Squares are counted, inner corners are often said; a board may have more of them than was said, or less.
TEST(OtherBoard, AChessboardIsToldByItsSquares) {
  struct Case {
    const char *said, *shown, *what;
  };
  // Whole, over six tenths of the picture, tilted to several sides.
  const auto pictures_of = [](const std::string& text, int count) {
    const Board board = Board::Parse(text);
    const CameraModel camera = SimulatedLens("pinhole", 400, 300);
    const BoardScene scene({.board = board, .camera = camera});
    const double z = camera.fx / 0.6 * std::max(board.WidthMm() / 400, board.HeightMm() / 300);
    std::vector<cv::Mat> pictures;
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector3d axis(i % 2, 1 - i % 2, 0.2), middle(board.WidthMm() / 2, board.HeightMm() / 2, 0);
      const Eigen::Quaterniond turn(Eigen::AngleAxisd(i % 4 < 2 ? 0.3 : -0.3, axis.normalized()));
      pictures.push_back(
          scene.Render({turn, Eigen::Vector3d(0, 0, z) - turn * middle}, static_cast<std::uint64_t>(i)));
    }
    return pictures;
  };
  for (const Case& c : {Case{"chessboard:9x6:25", "chessboard:10x7:25",
                             "9 x 6 counts inner corners, the text counts squares"},
                        {"chessboard:5x6:25", "chessboard:6x7:25", "5 x 6 counts inner corners"},
                        {"chessboard:9x6:25", "chessboard:9x7:25", "9 x 7 instead of 9 x 6"},
                        {"chessboard:9x6:25", "chessboard:10x6:25", "10 x 6 instead of 9 x 6"},
                        {"chessboard:8x5:25", "chessboard:11x8:25", "11 x 8 instead of 8 x 5"},
                        {"chessboard:9x6:25", "chessboard:8x6:25", "8 x 6 instead of 9 x 6"},
                        {"chessboard:9x6:25", "chessboard:8x5:25", "8 x 5 instead of 9 x 6"}}) {
    const Board said = Board::Parse(c.said);
    const auto other = BoardInPictures(said, pictures_of(c.shown, 3));
    EXPECT_TRUE(other) << c.said << " for " << c.shown;
    if (!other) continue;
    EXPECT_THAT(DescribeOtherBoard(said, *other),
                AllOf(HasSubstr(c.what), HasSubstr(std::string("give board ") + c.shown)));
  }
  // Of another kind, too; the same counts are no hint that it is right.
  for (const char* text :
       {"charuco:7x5:30:22:DICT_5X5_100", "charuco:9x6:30:22:DICT_5X5_100", "aprilgrid:6x6:30:9"}) {
    const Board of_markers = Board::Parse(text);
    const auto other = BoardInPictures(of_markers, pictures_of("chessboard:9x6:25", 3));
    ASSERT_TRUE(other) << text;
    EXPECT_THAT(DescribeOtherBoard(of_markers, *other),
                AllOf(HasSubstr("a chessboard; measure"), HasSubstr("give board chessboard:9x6:30")));
    EXPECT_FALSE(BoardInPictures(of_markers, pictures_of("chessboard:9x6:25", 1)));
  }
  // A hand over a column, a single picture of something larger, and parts are no other board.
  const Board said = Board::Parse("chessboard:9x6:25");
  EXPECT_FALSE(BoardInPictures(said, pictures_of("chessboard:8x6:25", 1)));
  EXPECT_FALSE(BoardInPictures(said, pictures_of("chessboard:12x9:25", 1)));
  std::vector<cv::Mat> pictures = pictures_of(said.Text(), 2);
  EXPECT_FALSE(BoardInPictures(said, pictures));
  for (cv::Mat& picture : pictures) picture = picture(cv::Rect(0, 0, 250, 300)).clone();
  EXPECT_FALSE(BoardInPictures(said, pictures));
}

TEST(OtherBoard, AVideoOfTheBoardCalibrates) {
  const test::ScratchFolder scratch;
  const std::string film = (scratch / "board.mp4").string(), file = (scratch / "camera.json").string();
  {
    const BoardScene scene(
        {.board = Board::Parse("chessboard:8x6:25"), .camera = SimulatedLens("pinhole", 400, 300)});
    VideoWriter video(film, {400, 300}, 30);
    for (std::uint64_t i = 0; i < 56; ++i) {
      cv::Mat bgr;
      cv::cvtColor(scene.Render(scene.HeldAt(i / 4, 0), i), bgr, cv::COLOR_GRAY2BGR);
      video.Add(bgr);
    }
    video.Close();
  }
  const auto right = test::RunUlf("calibrate " + film + " --views 8 --board chessboard:8x6:25 -o " + file);
  ASSERT_EQ(right.exit_code, 0) << right.errors;
  EXPECT_NEAR(ReadCalibration(file).fx, SimulatedLens("pinhole", 400, 300).fx, 10);
  const auto corners = test::RunUlf("calibrate " + film + " --board chessboard:7x5:25 -o " + file + "2");
  EXPECT_EQ(corners.exit_code, 1);
  EXPECT_THAT(corners.errors, AllOf(HasSubstr("7 x 5 counts inner corners"), HasSubstr("chessboard:8x6:25")));
  const auto two = test::RunUlf("calibrate " + film + " " + film + " -o " + file + "2");
  EXPECT_EQ(two.exit_code, 2);
  EXPECT_THAT(two.errors, HasSubstr("one video"));
  // A file of another program is not replaced.
  const std::string chain = (scratch / "camchain.yaml").string();
  std::ofstream(chain) << "cam0:\n";
  const auto kept = test::RunUlf("calibrate " + film + " --board chessboard:8x6:25 -o " + chain);
  EXPECT_EQ(kept.exit_code, 2);
  EXPECT_THAT(kept.errors, AllOf(HasSubstr("no calibration file of ulf"), HasSubstr("choose another name")));
  const std::string picture = (scratch / "shot.png").string();
  cv::imwrite(picture, cv::Mat(16, 16, CV_8U, cv::Scalar(90)));
  const auto shot = test::RunUlf("calibrate " + film + " --board chessboard:8x6:25 -o " + picture);
  EXPECT_EQ(shot.exit_code, 2);
  EXPECT_THAT(shot.errors, AllOf(HasSubstr("choose another name"), Not(HasSubstr("convert"))));
  const auto found = test::RunUlf("track sim:studio --intrinsics refine --calibration-out " + chain);
  EXPECT_EQ(found.exit_code, 2);
  EXPECT_THAT(found.errors, HasSubstr("no calibration file of ulf"));
  std::ofstream(scratch / "notes.txt") << "no picture\n";
  EXPECT_THAT(test::RunUlf("calibrate " + (scratch / "notes.txt").string() + " -o " + file + "2").errors,
              AllOf(HasSubstr("notes.txt"), HasSubstr("video")));
}

TEST(OtherBoard, AVideoOfABoardThatNeverRestsSaysSo) {
  const test::ScratchFolder scratch;
  const std::string film = (scratch / "board.mp4").string();
  {
    const BoardScene scene(
        {.board = Board::Parse("chessboard:8x6:25"), .camera = SimulatedLens("pinhole", 320, 240)});
    VideoWriter video(film, {320, 240}, 30);
    for (std::uint64_t i = 0; i < 12; ++i) {
      cv::Mat bgr;
      cv::cvtColor(scene.Render(scene.HeldAt(i / 6, static_cast<double>(i % 6) / 6), i), bgr,
                   cv::COLOR_GRAY2BGR);
      video.Add(bgr);
    }
    video.Close();
  }
  const auto result =
      test::RunUlf("calibrate " + film + " --board chessboard:8x6:25 -o " + (scratch / "c.json").string());
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.errors, AllOf(HasSubstr("no calibration: the board chessboard:8x6:25 was seen in"),
                                   HasSubstr("pictures, and moved in all of them"),
                                   HasSubstr("ulf calibrate FOLDER"), Not(HasSubstr("not found"))));
}

// Markers of another sheet have numbers that the board does not have, but do not lie on its grid.
TEST(OtherBoard, AnotherSheetChangesNothing) {
  const Board said = Board::Parse("aprilgrid:6x6:30:9");
  const std::vector<cv::Mat> of_said = PicturesOf(said.Text(), "barrel", 5),
                             of_other = PicturesOf("aprilgrid:6x6:30:9:first=36", "barrel", 2);
  // In place of it.
  std::vector<cv::Mat> pictures = of_said;
  std::ranges::copy(of_other, pictures.begin() + 2);
  EXPECT_TRUE(MarkersContradict(said, pictures));
  EXPECT_FALSE(BoardInPictures(said, pictures));
  EXPECT_FALSE(MarkersContradict(said, of_said));
  EXPECT_TRUE(MarkersContradict(said, of_other));
  // Beside it.
  for (std::size_t i = 0; i < of_other.size(); ++i) cv::hconcat(of_said[i], of_other[i], pictures[i]);
  pictures.resize(of_other.size());
  EXPECT_FALSE(BoardInPictures(said, pictures));
}

// Most corners agree with these boards, and those that do not would be left out.
TEST(OtherBoard, IsNamedThoughMostCornersAgree) {
  struct Case {
    const char *shown, *said, *what;
  };
  const test::ScratchFolder scratch;
  const std::string file = (scratch / "camera.json").string();
  for (const Case& c :
       {Case{"aprilgrid:6x6:30:9", ":first=1", "numbers begin with 0"},
        {"aprilgrid:6x6:30:9", ":first=6", "numbers begin with 0"},
        {"charuco:5x7:30:22:DICT_5X5_100", ":white-corner", "the upper left corner is dark"}}) {
    const test::ScratchFolder images;
    const auto pictures = PicturesOf(c.shown, "pinhole", 4);
    for (std::size_t i = 0; i < pictures.size(); ++i)
      cv::imwrite((images / (std::to_string(i) + ".png")).string(), pictures[i]);
    const auto wrong =
        test::RunUlf("calibrate " + images.path().string() + " --board " + c.shown + c.said + " -o " + file);
    EXPECT_EQ(wrong.exit_code, 1) << c.said;
    EXPECT_THAT(wrong.errors, AllOf(HasSubstr(std::string("they lie as on ") + c.shown + " (" + c.what),
                                    HasSubstr(std::string("give --board ") + c.shown + "\n")))
        << c.said;
    EXPECT_FALSE(std::filesystem::exists(file)) << c.said;
  }
}

// A view that is blurred and one of another board are left out; the others tell which board it is.
TEST(OtherBoard, ARightBoardWithBadViewsCalibrates) {
  const test::ScratchFolder scratch, images;
  const std::string file = (scratch / "camera.json").string(), board = "aprilgrid:6x6:30:9";
  std::vector<cv::Mat> pictures = PicturesOf(board, "pinhole", 8);
  cv::GaussianBlur(pictures[3].clone(), pictures[3], {}, 4);
  pictures[6] = PicturesOf("aprilgrid:6x6:30:9:first=1", "pinhole", 7).back();
  for (std::size_t i = 0; i < pictures.size(); ++i)
    cv::imwrite((images / (std::to_string(i) + ".png")).string(), pictures[i]);
  const auto result =
      test::RunUlf("calibrate " + images.path().string() + " --board " + board + " -o " + file);
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, AllOf(HasSubstr("left out         6.png"), Not(HasSubstr("do not lie"))));
  EXPECT_NEAR(ReadCalibration(file).fx, SimulatedLens("pinhole", kWidth, kHeight).fx, 5);
}

TEST(OtherBoard, TheCommandNamesItAndItThenCalibrates) {
  const test::ScratchFolder scratch, images;
  const BoardScene scene({.board = Board::Parse("charuco:5x7:30:22:DICT_5X5_100"),
                          .camera = SimulatedLens("barrel", kWidth, kHeight)});
  for (std::uint64_t i = 0; i < 8; ++i)
    cv::imwrite((images / (std::to_string(i) + ".png")).string(), scene.Render(scene.HeldAt(i, 0), i));
  const std::string file = (scratch / "camera.json").string(), folder = images.path().string();
  const auto wrong =
      test::RunUlf("calibrate " + folder + " --board charuco:7x5:30:22:DICT_5X5_100 -o " + file);
  EXPECT_EQ(wrong.exit_code, 1);
  EXPECT_THAT(wrong.errors, AllOf(HasSubstr("do not lie as on charuco:7x5:30:22:DICT_5X5_100"),
                                  HasSubstr("give --board charuco:5x7:30:22:DICT_5X5_100"),
                                  Not(HasSubstr("more views")), Not(HasSubstr("take others"))));
  EXPECT_FALSE(std::filesystem::exists(file));
  const auto right =
      test::RunUlf("calibrate " + folder + " --board charuco:5x7:30:22:DICT_5X5_100 -o " + file);
  ASSERT_EQ(right.exit_code, 0) << right.errors;
  EXPECT_NEAR(ReadCalibration(file).fx, 0.875 * kWidth, 10);
  // A device says so after its first views, and where the board is not found at all.
  for (const char* said : {"charuco:7x5:30:22:DICT_5X5_100", "aruco:5x7:30:9:DICT_6X6_250"}) {
    const auto live = test::RunUlf(
        "calibrate 'sim:board?width=480&height=360&board=charuco:5x7:30:22:DICT_5X5_100' --board " +
        std::string(said) + " -o " + file + "2");
    EXPECT_EQ(live.exit_code, 1) << said;
    EXPECT_THAT(live.errors, HasSubstr("give --board charuco:5x7")) << said;
  }
}

// Views of a right board that determine nothing are said to be that.
TEST(OtherBoard, PoorViewsOfARightBoardAreSaidToBePoor) {
  const test::ScratchFolder scratch, images;
  const Board board = Board::Parse("aprilgrid:6x6:30:9");
  const BoardScene scene({.board = board, .camera = SimulatedLens("barrel", 640, 480)});
  for (int i = 0; i < 5; ++i) {
    // Facing the camera, side by side.
    const Rigid3 pose{Eigen::Quaterniond::Identity(), {-120.0 + 10 * (i - 2), -120.0 + 4 * i, 380}};
    cv::imwrite((images / (std::to_string(i) + ".png")).string(),
                scene.Render(pose, static_cast<std::uint64_t>(i)));
  }
  const auto result = test::RunUlf("calibrate " + images.path().string() + " --board " + board.Text() +
                                   " -o " + (scratch / "camera.json").string());
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.errors, AllOf(HasSubstr("same orientation"), Not(HasSubstr("do not lie"))));
}

}  // namespace
}  // namespace ulf::other_board_test
