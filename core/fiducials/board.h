// Describes calibration targets: what is printed on the sheet, and where the corners are.
//
// Lengths are millimetres. The board's frame has its origin at the pattern's upper left corner, x to the
// right, y down, z into the sheet; every point lies at z = 0. Patterns are OpenCV's (4.6): a ChArUco board
// has a dark square in its upper left corner and its markers in the white squares, row by row.
//
// Kalibr's AprilGrid has a square of the gap's size at every crossing of its gaps, on its rim too, so that
// the corners of the tags are saddle points. Its tags have a border of two cells, stand as the AprilTag
// library draws them (half a turn from OpenCV's DICT_APRILTAG_36h11), and are numbered from the lower left
// row by row upwards: the lower left corner of tag i is at ((i % columns) (tag + gap), (i / columns) (tag +
// gap)), x to the right and y up.
//
// One text describes a board; it is printed on the sheet, too:
//   charuco:7x5:30:22:DICT_5X5_100    columns x rows of squares, square, marker, dictionary
//   aruco:4x5:37.5:5:DICT_6X6_1000    columns x rows of markers, marker, gap, dictionary
//   aprilgrid:6x6:30:9                columns x rows of tags, tag, gap
//   chessboard:8x6:25                 columns x rows of squares, square
// Boards of other makers have further words behind colons, in any order: `first=36`, the least number of a
// marker; `right-up`, how markers are numbered (right, left, up or down to the next one, then to the next row
// or column); `white-corner`, a ChArUco board with a marker in its upper left corner, as OpenCV before 4.6
// drew boards with an even number of rows.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace ulf {

enum class BoardKind { kCharuco, kArucoGrid, kAprilGrid, kChessboard };

// Says where the marker with the next number is; "right-down" means to the right, then the next row below.
struct MarkerOrder {
  bool by_columns = false;  // the next marker is in the same column
  bool leftwards = false, upwards = false;
  std::string Text() const;
  bool operator==(const MarkerOrder&) const = default;
};

struct RectangleMm {
  double x = 0, y = 0, width = 0, height = 0;
};

struct Board {
  BoardKind kind = BoardKind::kCharuco;
  int columns = 7, rows = 5;  // squares; markers of a grid
  double square_mm = 30;      // 0 for a grid of markers
  double marker_mm = 22;      // 0 for a chessboard
  double gap_mm = 0;          // between the markers of a grid
  std::string dictionary = "DICT_5X5_100";
  int first_marker = 0;  // the least number
  MarkerOrder order = {};
  bool white_corner = false;

  static Board Parse(const std::string& text);  // throws a Refusal that names the right form
  std::string Text() const;

  // Returns whether the points are the markers' corners: for an ArUco grid or an AprilGrid.
  bool IsMarkerGrid() const { return kind == BoardKind::kArucoGrid || kind == BoardKind::kAprilGrid; }
  // Returns the width of a marker's dark border in cells.
  int BorderCells() const { return kind == BoardKind::kAprilGrid ? 2 : 1; }
  // Returns column and row of each marker, in the order of their numbers; empty for a chessboard.
  std::vector<Eigen::Vector2i> MarkerPlaces() const;

  double WidthMm() const;
  double HeightMm() const;
  // Returns the points that are detected, by id, in mm: the inner corners of a ChArUco board or chessboard
  // row by row; for a grid, MarkerPoints().
  std::vector<Eigen::Vector3d> Points() const;
  // Returns the corners of the markers of a ChArUco board or a grid in mm, four for each marker number from
  // first_marker on, clockwise from its upper left one.
  std::vector<Eigen::Vector3d> MarkerPoints() const;
  // Returns the dark areas of the sheet. Rectangles may touch but do not overlap.
  std::vector<RectangleMm> Dark() const;

  bool operator==(const Board&) const = default;
};

// Returns OpenCV's number of the dictionary with this name. Throws a Refusal with all names if there is none.
int DictionaryNumber(const std::string& name);

}  // namespace ulf
