#include "core/fiducials/board.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>

#include "core/base/error.h"
#include "core/fiducials/aruco_calls.h"

namespace ulf {
namespace {

// By OpenCV's number.
constexpr std::array<std::string_view, 21> kDictionaries = {
    "DICT_4X4_50",         "DICT_4X4_100",       "DICT_4X4_250",       "DICT_4X4_1000",
    "DICT_5X5_50",         "DICT_5X5_100",       "DICT_5X5_250",       "DICT_5X5_1000",
    "DICT_6X6_50",         "DICT_6X6_100",       "DICT_6X6_250",       "DICT_6X6_1000",
    "DICT_7X7_50",         "DICT_7X7_100",       "DICT_7X7_250",       "DICT_7X7_1000",
    "DICT_ARUCO_ORIGINAL", "DICT_APRILTAG_16h5", "DICT_APRILTAG_25h9", "DICT_APRILTAG_36h10",
    "DICT_APRILTAG_36h11"};
static_assert(cv::aruco::DICT_4X4_50 == 0 && cv::aruco::DICT_APRILTAG_36h11 == kDictionaries.size() - 1);

std::vector<std::string> SplitAtColons(const std::string& text) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == ':')
      parts.emplace_back();
    else
      parts.back() += c;
  }
  return parts;
}

double LengthMm(const std::string& word, const char* what, const std::string& board) {
  std::size_t used = 0;
  double value = 0;
  try {
    value = std::stod(word, &used);
  } catch (const std::exception&) {
    used = 0;
  }
  if (used == 0 || used != word.size() || !(value > 0) || value > 1e5)
    throw UsageError("board '{}': '{}' is no {} in millimetres", board, word, what);
  return value;
}

void ParseCounts(const std::string& word, const std::string& text, Board& board) {
  char x = 0, rest = 0;
  const bool counts = std::sscanf(word.c_str(), "%d%c%d%c", &board.columns, &x, &board.rows, &rest) == 3;
  if (!counts || x != 'x' || board.columns < 1 || board.rows < 1 || board.columns > 200 || board.rows > 200)
    throw UsageError("board '{}': '{}' is not COLUMNSxROWS, as 7x5", text, word);
}

bool IsDarkSquare(int column, int row) { return (column + row) % 2 == 0; }

// The dark cells of one marker with its dark border, as runs along its rows.
void AddMarker(const cv::aruco::Dictionary& dictionary, int id, double x_mm, double y_mm, double side_mm,
               std::vector<RectangleMm>& dark) {
  const int bits = dictionary.markerSize, cells = bits + 2;
  const cv::Mat white =
      cv::aruco::Dictionary::getBitsFromByteList(dictionary.bytesList.rowRange(id, id + 1), bits);
  const double cell = side_mm / cells;
  const auto is_dark = [&](int column, int row) {
    const bool border = column == 0 || row == 0 || column == cells - 1 || row == cells - 1;
    return border || white.at<unsigned char>(row - 1, column - 1) == 0;
  };
  for (int row = 0; row < cells; ++row)
    for (int column = 0; column < cells;) {
      int end = column;
      while (end < cells && is_dark(end, row)) ++end;
      if (end > column)
        dark.push_back({x_mm + column * cell, y_mm + row * cell, (end - column) * cell, cell});
      column = std::max(end, column + 1);
    }
}

}  // namespace

int DictionaryNumber(const std::string& name) {
  const auto found = std::ranges::find(kDictionaries, name);
  if (found == kDictionaries.end())
    throw UsageError("there is no marker dictionary '{}'; there are {}", name,
                     fmt::join(kDictionaries, ", "));
  return static_cast<int>(found - kDictionaries.begin());
}

Board Board::Parse(const std::string& text) {
  const std::vector<std::string> parts = SplitAtColons(text);
  Board board;
  const std::string& kind = parts[0];
  const auto require_parts = [&](std::size_t count, const char* form) {
    if (parts.size() != count) throw UsageError("board '{}': a {} is written as {}", text, kind, form);
  };
  if (kind == "charuco") {
    require_parts(5,
                  "charuco:7x5:30:22:DICT_5X5_100 (columns x rows of squares, square, marker, dictionary)");
    board.square_mm = LengthMm(parts[2], "square", text);
    board.marker_mm = LengthMm(parts[3], "marker", text);
    if (board.marker_mm >= board.square_mm)
      throw UsageError("board '{}': the marker ({} mm) must be smaller than the square ({} mm)", text,
                       board.marker_mm, board.square_mm);
    board.dictionary = parts[4];
  } else if (kind == "aruco") {
    require_parts(5, "aruco:4x5:37.5:5:DICT_6X6_1000 (columns x rows of markers, marker, gap, dictionary)");
    board.kind = BoardKind::kArucoGrid;
    board.square_mm = 0;
    board.marker_mm = LengthMm(parts[2], "marker", text);
    board.gap_mm = LengthMm(parts[3], "gap", text);
    board.dictionary = parts[4];
  } else if (kind == "chessboard") {
    require_parts(3, "chessboard:8x6:25 (columns x rows of squares, square)");
    board.kind = BoardKind::kChessboard;
    board.square_mm = LengthMm(parts[2], "square", text);
    board.marker_mm = 0;
    board.dictionary.clear();
  } else {
    throw UsageError("board '{}': there is no kind of board '{}'; there are charuco, aruco and chessboard",
                     text, kind);
  }
  ParseCounts(parts[1], text, board);
  const int least = board.kind == BoardKind::kArucoGrid ? 1 : 3;
  if (board.columns < least || board.rows < least)
    throw UsageError("board '{}': needs at least {}x{} squares (counted are squares, not inner corners)",
                     text, least, least);
  if (board.kind != BoardKind::kChessboard) {
    const auto dictionary = ArucoDictionary(DictionaryNumber(board.dictionary));
    const int all = board.columns * board.rows;
    const int markers = board.kind == BoardKind::kArucoGrid ? all : all / 2;
    if (markers > dictionary->bytesList.rows)
      throw UsageError("board '{}': needs {} markers, {} has {}", text, markers, board.dictionary,
                       dictionary->bytesList.rows);
  }
  return board;
}

std::string Board::Text() const {
  switch (kind) {
    case BoardKind::kCharuco:
      return fmt::format("charuco:{}x{}:{}:{}:{}", columns, rows, square_mm, marker_mm, dictionary);
    case BoardKind::kArucoGrid:
      return fmt::format("aruco:{}x{}:{}:{}:{}", columns, rows, marker_mm, gap_mm, dictionary);
    default:
      return fmt::format("chessboard:{}x{}:{}", columns, rows, square_mm);
  }
}

double Board::WidthMm() const {
  return kind == BoardKind::kArucoGrid ? columns * marker_mm + (columns - 1) * gap_mm : columns * square_mm;
}

double Board::HeightMm() const {
  return kind == BoardKind::kArucoGrid ? rows * marker_mm + (rows - 1) * gap_mm : rows * square_mm;
}

std::vector<Eigen::Vector3d> Board::MarkerPoints() const {
  std::vector<Eigen::Vector3d> points;
  if (kind == BoardKind::kChessboard) return points;
  const bool grid = kind == BoardKind::kArucoGrid;
  const double step = grid ? marker_mm + gap_mm : square_mm,
               margin = grid ? 0 : 0.5 * (square_mm - marker_mm);
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      if (!grid && IsDarkSquare(column, row)) continue;
      const double x = column * step + margin, y = row * step + margin;
      points.insert(
          points.end(),
          {{x, y, 0}, {x + marker_mm, y, 0}, {x + marker_mm, y + marker_mm, 0}, {x, y + marker_mm, 0}});
    }
  return points;
}

std::vector<Eigen::Vector3d> Board::Points() const {
  if (kind == BoardKind::kArucoGrid) return MarkerPoints();
  std::vector<Eigen::Vector3d> points;
  for (int row = 1; row < rows; ++row)
    for (int column = 1; column < columns; ++column)
      points.emplace_back(column * square_mm, row * square_mm, 0);
  return points;
}

std::vector<RectangleMm> Board::Dark() const {
  std::vector<RectangleMm> dark;
  cv::Ptr<cv::aruco::Dictionary> markers;
  if (kind != BoardKind::kChessboard) markers = ArucoDictionary(DictionaryNumber(dictionary));
  int id = 0;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      if (kind == BoardKind::kArucoGrid) {
        AddMarker(*markers, id++, column * (marker_mm + gap_mm), row * (marker_mm + gap_mm), marker_mm, dark);
      } else if (IsDarkSquare(column, row)) {
        dark.push_back({column * square_mm, row * square_mm, square_mm, square_mm});
      } else if (kind == BoardKind::kCharuco) {
        const double margin = 0.5 * (square_mm - marker_mm);
        AddMarker(*markers, id++, column * square_mm + margin, row * square_mm + margin, marker_mm, dark);
      }
    }
  return dark;
}

}  // namespace ulf
