#include "core/fiducials/board.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <opencv2/core.hpp>
#include <sstream>

#include "core/base/error.h"
#include "core/fiducials/aruco_calls.h"

namespace ulf {
namespace {

// The order is that of OpenCV's numbers.
constexpr std::array<std::string_view, 21> kDictionaries = {
    "DICT_4X4_50",         "DICT_4X4_100",       "DICT_4X4_250",       "DICT_4X4_1000",
    "DICT_5X5_50",         "DICT_5X5_100",       "DICT_5X5_250",       "DICT_5X5_1000",
    "DICT_6X6_50",         "DICT_6X6_100",       "DICT_6X6_250",       "DICT_6X6_1000",
    "DICT_7X7_50",         "DICT_7X7_100",       "DICT_7X7_250",       "DICT_7X7_1000",
    "DICT_ARUCO_ORIGINAL", "DICT_APRILTAG_16h5", "DICT_APRILTAG_25h9", "DICT_APRILTAG_36h10",
    "DICT_APRILTAG_36h11"};
static_assert(cv::aruco::DICT_4X4_50 == 0 && cv::aruco::DICT_APRILTAG_36h11 == kDictionaries.size() - 1);

constexpr MarkerOrder kAprilGridOrder{.upwards = true};
std::vector<MarkerOrder> AllOrders() {
  std::vector<MarkerOrder> orders;
  for (const bool by_columns : {false, true})
    for (const bool leftwards : {false, true})
      for (const bool upwards : {false, true}) orders.push_back({by_columns, leftwards, upwards});
  return orders;
}

std::vector<std::string> SplitAtColons(const std::string& text) {
  std::vector<std::string> parts;
  std::istringstream stream(text + ":");  // a colon behind each part
  for (std::string part; std::getline(stream, part, ':');) parts.push_back(part);
  return parts;
}

std::string Quoted(const std::string& text) { return "'" + text + "'"; }

double LengthMm(const std::string& word, const char* what, const std::string& board) {
  std::size_t used = 0;
  double value = 0;
  try {
    value = std::stod(word, &used);
  } catch (const std::exception&) {
    used = 0;
  }
  if (used == 0 || used != word.size() || !(value > 0) || value > 1e5)
    throw Refusal("board", Quoted(board), fmt::format("'{}' is no {} in millimetres", word, what), "");
  return value;
}

void ParseCounts(const std::string& word, const std::string& text, Board& board) {
  char x = 0, rest = 0;
  const bool counts = std::sscanf(word.c_str(), "%d%c%d%c", &board.columns, &x, &board.rows, &rest) == 3;
  if (!counts || x != 'x' || board.columns < 1 || board.rows < 1 || board.columns > 200 || board.rows > 200)
    throw Refusal("board", Quoted(text), fmt::format("'{}' is not COLUMNSxROWS, as 7x5", word), "");
}

// Refuses lengths in metres, and Kalibr's gap as a share of the tag, if they can be nothing else.
void RefuseMetres(const Board& board, const std::string& text) {
  constexpr double kLeastMm = 1, kMmPerM = 1000;
  const double length = board.IsMarkerGrid() ? board.marker_mm : board.square_mm;
  if (length >= kLeastMm) return;
  const auto rounded = [](double mm) { return std::round(1e4 * mm) / 1e4; };
  const bool is_share = board.kind == BoardKind::kAprilGrid && board.gap_mm > 0.5 * length;
  Board meant = board;
  meant.square_mm = rounded(kMmPerM * board.square_mm);
  meant.marker_mm = rounded(kMmPerM * board.marker_mm);
  meant.gap_mm = rounded(is_share ? kMmPerM * board.gap_mm * board.marker_mm : kMmPerM * board.gap_mm);
  throw Refusal(
      "board", Quoted(text), fmt::format("{} of {} mm", board.IsMarkerGrid() ? "markers" : "squares", length),
      fmt::format("lengths are in millimetres. If these are metres{}, give {}",
                  is_share ? " and the gap a share of the tag, as Kalibr has it" : "", meant.Text()));
}

bool IsDarkSquare(const Board& board, int column, int row) {
  return (column + row) % 2 == (board.white_corner ? 1 : 0);
}

// Adds the dark cells of one marker with its dark border, as runs along its rows.
void AddMarker(const Board& board, const cv::aruco::Dictionary& dictionary, int id, double x_mm, double y_mm,
               std::vector<RectangleMm>& dark) {
  const int bits = dictionary.markerSize, border = board.BorderCells(), cells = bits + 2 * border;
  cv::Mat white = cv::aruco::Dictionary::getBitsFromByteList(dictionary.bytesList.rowRange(id, id + 1), bits);
  // OpenCV draws the tags upside down.
  if (board.kind == BoardKind::kAprilGrid) cv::flip(white.clone(), white, -1);
  const double cell = board.marker_mm / cells;
  const auto is_dark = [&](int column, int row) {
    const int x = column - border, y = row - border;
    return x < 0 || y < 0 || x >= bits || y >= bits || white.at<unsigned char>(y, x) == 0;
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

// Parses the words behind a board's lengths and dictionary.
void ParseWords(const std::vector<std::string>& words, const std::string& text, Board& board) {
  for (const std::string& word : words) {
    char rest = 0;
    if (std::sscanf(word.c_str(), "first=%d%c", &board.first_marker, &rest) == 1 && board.first_marker >= 0 &&
        board.first_marker < 100000)
      continue;
    if (word == "white-corner" && board.kind == BoardKind::kCharuco) {
      board.white_corner = true;
      continue;
    }
    const std::vector<MarkerOrder> known = AllOrders();
    const auto named = std::ranges::find(known, word, &MarkerOrder::Text);
    if (named == known.end()) {
      std::vector<std::string> orders;
      std::ranges::transform(known, std::back_inserter(orders), &MarkerOrder::Text);
      throw Refusal("board", Quoted(text),
                    fmt::format("what is '{}'? Behind the board there may be first=N, the way of numbering "
                                "({}) and, of a ChArUco board, white-corner",
                                word, fmt::join(orders, ", ")),
                    "");
    }
    board.order = *named;
  }
}

// Returns the length of so many squares, or markers with the gaps between them, and around them if there are
// squares in the gaps.
double LengthOf(const Board& board, int count) {
  if (!board.IsMarkerGrid()) return count * board.square_mm;
  const int gaps = board.kind == BoardKind::kAprilGrid ? count + 1 : count - 1;
  return count * board.marker_mm + gaps * board.gap_mm;
}

}  // namespace

int DictionaryNumber(const std::string& name) {
  const auto found = std::ranges::find(kDictionaries, name);
  if (found == kDictionaries.end())
    throw Refusal("", name, fmt::format("there is no marker dictionary '{}'", name),
                  fmt::format("there are {}", fmt::join(kDictionaries, ", ")));
  return static_cast<int>(found - kDictionaries.begin());
}

std::string MarkerOrder::Text() const {
  const char *across = leftwards ? "left" : "right", *along = upwards ? "up" : "down";
  return fmt::format("{}-{}", by_columns ? along : across, by_columns ? across : along);
}

Board Board::Parse(const std::string& text) {
  const std::vector<std::string> parts = SplitAtColons(text);
  Board board;
  const std::string& kind = parts[0];
  const auto require_parts = [&](std::size_t count, const char* form) {
    const bool words = board.kind != BoardKind::kChessboard && parts.size() > count;
    if (parts.size() != count && !words)
      throw Refusal("board", Quoted(text), fmt::format("a {} is written as {}", kind, form), "");
    if (words) ParseWords({parts.begin() + static_cast<std::ptrdiff_t>(count), parts.end()}, text, board);
  };
  if (kind == "charuco") {
    require_parts(5,
                  "charuco:7x5:30:22:DICT_5X5_100 (columns x rows of squares, square, marker, dictionary)");
    board.square_mm = LengthMm(parts[2], "square", text);
    board.marker_mm = LengthMm(parts[3], "marker", text);
    if (board.marker_mm >= board.square_mm)
      throw Refusal("board", Quoted(text),
                    fmt::format("the marker ({} mm) must be smaller than the square ({} mm)", board.marker_mm,
                                board.square_mm),
                    "");
    board.dictionary = parts[4];
  } else if (kind == "aruco") {
    board.kind = BoardKind::kArucoGrid;
    require_parts(5, "aruco:4x5:37.5:5:DICT_6X6_1000 (columns x rows of markers, marker, gap, dictionary)");
    board.square_mm = 0;
    board.marker_mm = LengthMm(parts[2], "marker", text);
    board.gap_mm = LengthMm(parts[3], "gap", text);
    board.dictionary = parts[4];
  } else if (kind == "aprilgrid") {
    board.kind = BoardKind::kAprilGrid;
    board.order = kAprilGridOrder;
    require_parts(4, "aprilgrid:6x6:30:9 (columns x rows of tags, tag, gap in mm)");
    board.square_mm = 0;
    board.marker_mm = LengthMm(parts[2], "tag", text);
    board.gap_mm = LengthMm(parts[3], "gap", text);
    board.dictionary = "DICT_APRILTAG_36h11";
  } else if (kind == "chessboard") {
    board.kind = BoardKind::kChessboard;
    require_parts(3, "chessboard:8x6:25 (columns x rows of squares, square)");
    board.square_mm = LengthMm(parts[2], "square", text);
    board.marker_mm = 0;
    board.dictionary.clear();
  } else {
    throw Refusal("board", Quoted(text), fmt::format("there is no kind of board '{}'", kind),
                  "there are charuco, aruco, aprilgrid and chessboard");
  }
  ParseCounts(parts[1], text, board);
  RefuseMetres(board, text);
  const int least = board.IsMarkerGrid() ? 1 : 3;
  if (board.columns < least || board.rows < least)
    throw Refusal(
        "board", Quoted(text),
        fmt::format("needs at least {}x{} squares (counted are squares, not inner corners)", least, least),
        "");
  if (board.kind != BoardKind::kChessboard) {
    const auto dictionary = ArucoDictionary(DictionaryNumber(board.dictionary));
    const int markers = board.first_marker + static_cast<int>(board.MarkerPlaces().size());
    if (markers > dictionary->bytesList.rows)
      throw Refusal(
          "board", Quoted(text),
          fmt::format("needs {} markers, {} has {}", markers, board.dictionary, dictionary->bytesList.rows),
          "");
  }
  return board;
}

std::string Board::Text() const {
  std::string text;
  switch (kind) {
    case BoardKind::kCharuco:
      text = fmt::format("charuco:{}x{}:{}:{}:{}", columns, rows, square_mm, marker_mm, dictionary);
      break;
    case BoardKind::kArucoGrid:
      text = fmt::format("aruco:{}x{}:{}:{}:{}", columns, rows, marker_mm, gap_mm, dictionary);
      break;
    case BoardKind::kAprilGrid:
      text = fmt::format("aprilgrid:{}x{}:{}:{}", columns, rows, marker_mm, gap_mm);
      break;
    case BoardKind::kChessboard:
      return fmt::format("chessboard:{}x{}:{}", columns, rows, square_mm);
  }
  if (white_corner) text += ":white-corner";
  if (order != (kind == BoardKind::kAprilGrid ? kAprilGridOrder : MarkerOrder{}))
    text += fmt::format(":{}", order.Text());
  if (first_marker != 0) text += fmt::format(":first={}", first_marker);
  return text;
}

double Board::WidthMm() const { return LengthOf(*this, columns); }

double Board::HeightMm() const { return LengthOf(*this, rows); }

std::vector<Eigen::Vector2i> Board::MarkerPlaces() const {
  std::vector<Eigen::Vector2i> places;
  if (kind == BoardKind::kChessboard) return places;
  const int along = order.by_columns ? rows : columns, across = order.by_columns ? columns : rows;
  for (int j = 0; j < across; ++j)
    for (int i = 0; i < along; ++i) {
      Eigen::Vector2i place(order.by_columns ? j : i, order.by_columns ? i : j);
      if (order.leftwards) place.x() = columns - 1 - place.x();
      if (order.upwards) place.y() = rows - 1 - place.y();
      if (IsMarkerGrid() || !IsDarkSquare(*this, place.x(), place.y())) places.push_back(place);
    }
  return places;
}

std::vector<Eigen::Vector3d> Board::MarkerPoints() const {
  std::vector<Eigen::Vector3d> points;
  const double step = IsMarkerGrid() ? marker_mm + gap_mm : square_mm;
  const double margin = kind == BoardKind::kArucoGrid   ? 0
                        : kind == BoardKind::kAprilGrid ? gap_mm
                                                        : 0.5 * (square_mm - marker_mm);
  for (const Eigen::Vector2i& place : MarkerPlaces()) {
    const double x = place.x() * step + margin, y = place.y() * step + margin;
    points.insert(
        points.end(),
        {{x, y, 0}, {x + marker_mm, y, 0}, {x + marker_mm, y + marker_mm, 0}, {x, y + marker_mm, 0}});
  }
  return points;
}

std::vector<Eigen::Vector3d> Board::Points() const {
  if (IsMarkerGrid()) return MarkerPoints();
  std::vector<Eigen::Vector3d> points;
  for (int row = 1; row < rows; ++row)
    for (int column = 1; column < columns; ++column)
      points.emplace_back(column * square_mm, row * square_mm, 0);
  return points;
}

std::vector<RectangleMm> Board::Dark() const {
  std::vector<RectangleMm> dark;
  if (!IsMarkerGrid())
    for (int row = 0; row < rows; ++row)
      for (int column = 0; column < columns; ++column)
        if (IsDarkSquare(*this, column, row))
          dark.push_back({column * square_mm, row * square_mm, square_mm, square_mm});
  if (kind == BoardKind::kChessboard) return dark;
  const auto markers = ArucoDictionary(DictionaryNumber(dictionary));
  const auto corners = MarkerPoints();
  for (std::size_t i = 0; 4 * i < corners.size(); ++i)
    AddMarker(*this, *markers, first_marker + static_cast<int>(i), corners[4 * i].x(), corners[4 * i].y(),
              dark);
  if (kind == BoardKind::kAprilGrid)
    for (int row = 0; row <= rows; ++row)
      for (int column = 0; column <= columns; ++column)
        dark.push_back({column * (marker_mm + gap_mm), row * (marker_mm + gap_mm), gap_mm, gap_mm});
  return dark;
}

}  // namespace ulf
