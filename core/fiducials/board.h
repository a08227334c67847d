// Calibration targets: what is printed on the sheet, and where the corners are.
//
// Lengths are millimetres. The board's frame has its origin at the pattern's upper left corner, x to the
// right, y down, z into the sheet; every point lies at z = 0. Patterns are OpenCV's (4.6): a ChArUco board
// has a dark square in its upper left corner and its markers in the white squares, row by row.
//
// One text describes a board; it is printed on the sheet, too:
//   charuco:7x5:30:22:DICT_5X5_100    columns x rows of squares, square, marker, dictionary
//   aruco:4x5:37.5:5:DICT_6X6_1000    columns x rows of markers, marker, gap, dictionary
//   chessboard:8x6:25                 columns x rows of squares, square
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace ulf {

enum class BoardKind { kCharuco, kArucoGrid, kChessboard };

struct RectangleMm {
  double x = 0, y = 0, width = 0, height = 0;
};

struct Board {
  BoardKind kind = BoardKind::kCharuco;
  int columns = 7, rows = 5;  // squares; markers of an ArUco grid
  double square_mm = 30;      // 0 for an ArUco grid
  double marker_mm = 22;      // 0 for a chessboard
  double gap_mm = 0;          // between the markers of an ArUco grid
  std::string dictionary = "DICT_5X5_100";

  static Board Parse(const std::string& text);  // throws UsageError that names the right form
  std::string Text() const;

  double WidthMm() const;
  double HeightMm() const;
  // The points that are detected, by id: the inner corners of a ChArUco board or chessboard row by row; the
  // four corners of each marker of an ArUco grid, clockwise from its upper left one.
  std::vector<Eigen::Vector3d> Points() const;
  // The corners of the markers of a ChArUco board or an ArUco grid, four for each marker number, clockwise from
  // its upper left one.
  std::vector<Eigen::Vector3d> MarkerPoints() const;
  // The dark areas of the sheet. Rectangles may touch but do not overlap.
  std::vector<RectangleMm> Dark() const;

  bool operator==(const Board&) const = default;
};

// OpenCV's number of the dictionary with this name; throws UsageError that lists the names.
int DictionaryNumber(const std::string& name);

}  // namespace ulf
