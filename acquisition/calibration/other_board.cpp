#include "acquisition/calibration/other_board.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <opencv2/calib3d.hpp>

#include "acquisition/calibration/layout_fit.h"
#include "core/base/error.h"
#include "core/base/quantile.h"
#include "core/fiducials/marker_detector.h"

namespace ulf::acquisition {
namespace {

std::string GiveBoard(const Board& board) {
  return fmt::format("give {} {}", Parameter("board"), board.Text());
}

struct DictionaryFamily {
  const char* largest;             // contains the smaller dictionaries as its first markers
  std::vector<const char*> names;  // from the smallest
};
const std::vector<DictionaryFamily>& DictionaryFamilies() {
  static const std::vector<DictionaryFamily> families = {
      {"DICT_4X4_1000", {"DICT_4X4_50", "DICT_4X4_100", "DICT_4X4_250", "DICT_4X4_1000"}},
      {"DICT_5X5_1000", {"DICT_5X5_50", "DICT_5X5_100", "DICT_5X5_250", "DICT_5X5_1000"}},
      {"DICT_6X6_1000", {"DICT_6X6_50", "DICT_6X6_100", "DICT_6X6_250", "DICT_6X6_1000"}},
      {"DICT_7X7_1000", {"DICT_7X7_50", "DICT_7X7_100", "DICT_7X7_250", "DICT_7X7_1000"}},
      {"DICT_ARUCO_ORIGINAL", {"DICT_ARUCO_ORIGINAL"}},
      {"DICT_APRILTAG_16h5", {"DICT_APRILTAG_16h5"}},
      {"DICT_APRILTAG_25h9", {"DICT_APRILTAG_25h9"}},
      {"DICT_APRILTAG_36h10", {"DICT_APRILTAG_36h10"}},
      {"DICT_APRILTAG_36h11", {"DICT_APRILTAG_36h11"}}};
  return families;
}

int SizeOf(const std::string& dictionary) {
  const auto number = dictionary.rfind('_');
  return std::isdigit(static_cast<unsigned char>(dictionary[number + 1])) &&
                 dictionary.find('h', number) == std::string::npos
             ? std::stoi(dictionary.substr(number + 1))
             : 1024;
}

// Describes what was seen in all pictures, of one dictionary with one width of border.
struct Sighting {
  const DictionaryFamily* family = nullptr;
  int border_cells = 1;
  std::vector<SeenMarkers> pictures = {};
  std::size_t Most() const {
    std::size_t most = 0;
    for (const SeenMarkers& seen : pictures) most = std::max(most, seen.size());
    return most;
  }
  int Least() const {
    int least = std::numeric_limits<int>::max();
    for (const SeenMarkers& seen : pictures)
      if (!seen.empty()) least = std::min(least, seen.begin()->first);
    return least;
  }
  int Largest() const {
    int largest = 0;
    for (const SeenMarkers& seen : pictures)
      if (!seen.empty()) largest = std::max(largest, seen.rbegin()->first);
    return largest;
  }
};

// Numbers in a single one of several pictures are read out of something else.
void LeaveOutMisread(Sighting& sighting) {
  constexpr std::size_t kSeveral = 3;
  if (sighting.pictures.size() < kSeveral) return;
  std::map<int, int> times;
  for (const SeenMarkers& seen : sighting.pictures)
    for (const auto& [number, marker] : seen) ++times[number];
  for (SeenMarkers& seen : sighting.pictures)
    std::erase_if(seen, [&](const auto& marker) { return times[marker.first] < 2; });
}

using Quads = std::vector<MarkerImage>;

std::vector<Quads> QuadsIn(const std::vector<cv::Mat>& pictures) {
  std::vector<Quads> quads;
  for (const cv::Mat& picture : pictures) quads.push_back(DarkQuads(picture));
  return quads;
}

Sighting SightingIn(const std::vector<Quads>& quads, const std::vector<cv::Mat>& pictures,
                    const DictionaryFamily& family, const std::string& dictionary, int border_cells) {
  Sighting sighting{&family, border_cells, {}};
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const auto found = MarkersAmong(quads[i], pictures[i], dictionary, border_cells);
    sighting.pictures.emplace_back(found.begin(), found.end());
  }
  LeaveOutMisread(sighting);
  return sighting;
}

Sighting SightingAsSaid(const Board& specified, const std::vector<Quads>& quads,
                        const std::vector<cv::Mat>& pictures) {
  const auto family = std::ranges::find_if(DictionaryFamilies(), [&](const DictionaryFamily& known) {
    return std::ranges::find(known.names, specified.dictionary) != known.names.end();
  });
  return SightingIn(quads, pictures, *family, specified.dictionary, specified.BorderCells());
}

// Fewer markers in the best picture tell no layout. Guessed.
constexpr std::size_t kLeastMarkers = 4;

double StepOf(const Board& board) {
  return board.IsMarkerGrid() ? 1 + board.gap_mm / board.marker_mm : board.square_mm / board.marker_mm;
}

// The share of markers with which a layout is taken for the board's, and by how much that of another must be
// larger. Guessed: right ones reach all but what is misread or bent away; one first number off costs at least
// one marker of each row.
constexpr double kLayoutFits = 0.8, kClearlyBetter = 0.03;
// By which share of a step marker and gap may differ from what was said: of a grid, whose markers' corners
// are the points, and of a ChArUco board, where they only lead to the squares' corners. Guessed.
constexpr double kSameStep = 0.01, kSameSquare = 0.2;

// Returns how far a layout's views are from plane, as shares of their size; infinite where none is seen.
double MeanBend(const Board& layout, const std::vector<BoardView>& views) {
  const auto points = layout.Points();
  double sum = 0;
  int count = 0;
  for (const BoardView& view : views) {
    if (view.ids.empty()) continue;
    sum += PlaneMisfit(points, view);
    ++count;
  }
  return count > 0 ? sum / count : std::numeric_limits<double>::infinity();
}

Board WithStep(const Board& layout, double step) {
  Board other = layout;
  other.gap_mm = (step - 1) * layout.marker_mm;
  return other;
}

// Returns whether marker and gap are other than said; `step` is then what they are.
bool HasOtherStep(const Board& layout, double rough_step, const std::vector<cv::Mat>& pictures,
                  double& step) {
  step = rough_step;
  if (!layout.IsMarkerGrid()) return std::abs(step / StepOf(layout) - 1) > kSameSquare;
  // The corners lie on a plane: under the right step they are flattest, as far as the lens lets them.
  std::vector<BoardView> views;
  for (const cv::Mat& picture : pictures) views.push_back(DetectBoard(layout, picture));
  constexpr double kReach = 0.06, kFine = 0.002;
  double least = std::numeric_limits<double>::infinity();
  for (double share = 1 - kReach; share <= 1 + kReach; share += kFine) {
    if (share * rough_step <= 1) continue;
    const double bend = MeanBend(WithStep(layout, share * rough_step), views);
    if (bend >= least) continue;
    least = bend;
    step = share * rough_step;
  }
  constexpr double kFlatter = 0.5;  // a lens that bends everything leaves more; guessed
  return std::abs(step / StepOf(layout) - 1) > kSameStep && least < kFlatter * MeanBend(layout, views);
}

// The lengths of another kind, or of another ratio, with the marker as wide as was said.
void SetLengths(const Board& specified, double step, Board& board) {
  // Kalibr's own gap, unless the pictures speak against it.
  constexpr double kKalibrStep = 1.3, kNearStep = 0.02;
  if (board.kind == BoardKind::kAprilGrid && std::abs(step / kKalibrStep - 1) < kNearStep) step = kKalibrStep;
  const auto rounded = [](double mm) { return std::round(10 * mm) / 10; };
  if (board.marker_mm <= 0) board.marker_mm = rounded(specified.square_mm / step);
  board.square_mm = board.IsMarkerGrid() ? 0 : rounded(step * board.marker_mm);
  board.gap_mm = board.IsMarkerGrid() ? rounded((step - 1) * board.marker_mm) : 0;
}

// Returns the layout's smallest numbers of rows (or columns, where it is numbered by columns) that hold the
// largest marker seen.
bool Enlarge(int largest, Board& layout) {
  int& across = layout.order.by_columns ? layout.columns : layout.rows;
  const int along = layout.order.by_columns ? layout.rows : layout.columns;
  constexpr int kMost = 60;
  // Each line of a ChArUco board has a marker on every other square.
  const int count = largest - layout.first_marker + 1,
            most_in_line = layout.IsMarkerGrid() ? along : along / 2 + 1;
  across = std::max(across, count / most_in_line);
  while (layout.first_marker + static_cast<int>(layout.MarkerPlaces().size()) <= largest)
    if (++across > kMost) return false;
  return true;
}

// Returns how unlike what was said; of layouts that fit alike, the one that is least so is meant.
int Unlikeness(const Board& specified, const Board& board) {
  const bool same_counts = board.columns == specified.columns && board.rows == specified.rows,
             exchanged = board.columns == specified.rows && board.rows == specified.columns;
  return (board.kind != specified.kind ? 16 : 0) + (board.order != specified.order ? 2 : 0) +
         (same_counts ? 0
          : exchanged ? 1
                      : 4) +
         (board.first_marker != specified.first_marker ? 2 : 0) +
         (board.white_corner != specified.white_corner ? 2 : 0);
}

// All layouts of one kind that hold the numbers seen.
void AddLayouts(const Board& specified, BoardKind kind, const Sighting& sighting,
                std::vector<Board>& layouts) {
  constexpr int kMostAlong = 24;
  const int least = kind == BoardKind::kCharuco ? 3 : 1;
  std::vector<int> firsts = {specified.first_marker, 0, sighting.Least()};
  std::ranges::sort(firsts);
  firsts.erase(std::unique(firsts.begin(), firsts.end()), firsts.end());
  std::erase_if(firsts, [&](int first) { return first > sighting.Least(); });
  Board layout = specified;
  layout.kind = kind;
  for (const int first : firsts)
    for (int way = 0; way < 8; ++way)
      for (const bool white : {false, true}) {
        if (white && kind != BoardKind::kCharuco) continue;
        layout.first_marker = first;
        layout.order = {.by_columns = way >= 4, .leftwards = way % 2 == 1, .upwards = (way / 2) % 2 == 1};
        layout.white_corner = white;
        for (int along = least; along <= kMostAlong; ++along) {
          const auto with_across = [&](int across) {
            Board whole = layout;
            whole.columns = layout.order.by_columns ? across : along;
            whole.rows = layout.order.by_columns ? along : across;
            return whole;
          };
          Board enough = with_across(least);
          if (!Enlarge(sighting.Largest(), enough)) continue;
          layouts.push_back(enough);
          // What was said, and the same exchanged, where that is larger: not all markers need be in sight.
          for (const auto& [columns, rows] :
               {std::pair{specified.columns, specified.rows}, std::pair{specified.rows, specified.columns}}) {
            const int along_said = layout.order.by_columns ? rows : columns,
                      across_said = layout.order.by_columns ? columns : rows;
            const int across_enough = layout.order.by_columns ? enough.columns : enough.rows;
            // A board with exchanged sides may lack at most one line of markers.
            const bool is_said = columns == specified.columns && rows == specified.rows;
            if (along_said == along && across_said > across_enough &&
                (is_said || across_said == across_enough + 1))
              layouts.push_back(with_across(across_said));
          }
        }
      }
}

std::string Differences(const Board& specified, const Board& board, bool other_step) {
  std::vector<std::string> all;
  if (board.kind != specified.kind) {
    constexpr const char* kKinds[] = {"a ChArUco board", "a grid of ArUco markers", "Kalibr's AprilGrid",
                                      "a chessboard"};
    all.emplace_back(kKinds[static_cast<std::size_t>(board.kind)]);
  }
  if (board.dictionary != specified.dictionary && specified.kind != BoardKind::kChessboard)
    all.push_back(fmt::format("markers of {}", board.dictionary));
  if (board.columns == specified.rows && board.rows == specified.columns &&
      specified.rows != specified.columns)
    all.emplace_back("columns and rows are exchanged");
  else if (board.columns != specified.columns || board.rows != specified.rows)
    all.push_back(fmt::format("{} x {} instead of {} x {}", board.columns, board.rows, specified.columns,
                              specified.rows));
  if (board.order != specified.order && board.kind == specified.kind)
    all.push_back(fmt::format("markers are numbered {}, not {}", board.order.Text(), specified.order.Text()));
  if (board.first_marker != specified.first_marker)
    all.push_back(fmt::format("numbers begin with {}", board.first_marker));
  if (board.white_corner != specified.white_corner)
    all.emplace_back(board.white_corner ? "a marker is in the upper left corner, as OpenCV before 4.6 drew it"
                                        : "the upper left corner is dark");
  if (other_step)
    all.push_back(board.IsMarkerGrid()
                      ? fmt::format("the gap is {:.2f} of the marker, not {:.2f}; measure both",
                                    board.gap_mm / board.marker_mm, specified.gap_mm / specified.marker_mm)
                      : fmt::format("the square is {:.2f} of the marker, not {:.2f}; measure both",
                                    board.square_mm / board.marker_mm,
                                    specified.square_mm / specified.marker_mm));
  else if (board.IsMarkerGrid() != specified.IsMarkerGrid() ||
           (specified.kind == BoardKind::kChessboard && board.kind != specified.kind))
    all.emplace_back("measure its lengths");
  return fmt::format("{}", fmt::join(all, "; "));
}

// Returns the board that a sighting fits best; none if no layout is known that does.
std::optional<OtherBoard> LayoutOf(const Board& specified, const Sighting& sighting,
                                   const std::vector<cv::Mat>& pictures, double said_share) {
  const Neighbours neighbours = NeighboursIn(sighting.pictures);
  std::vector<Board> layouts;
  if (sighting.border_cells == 2)
    AddLayouts(specified, BoardKind::kAprilGrid, sighting, layouts);
  else
    for (const BoardKind kind : {BoardKind::kArucoGrid, BoardKind::kCharuco})
      AddLayouts(specified, kind, sighting, layouts);
  // An AprilGrid's tags may be turned: half of the ways of numbering are the others, turned.
  if (sighting.border_cells == 2) std::erase_if(layouts, [](const Board& b) { return b.order.leftwards; });
  constexpr double kAlike = 0.02;
  struct Ranked {
    Board board;
    LayoutFit fit;
  };
  std::vector<Ranked> ranked;
  double best = std::max(kLayoutFits, std::min(1.0, said_share + kClearlyBetter));
  for (const Board& layout : layouts)
    if (const LayoutFit fit = LayoutFitOf(layout, neighbours); fit.share >= best - kAlike) {
      best = std::max(best, fit.share);
      ranked.push_back({layout, fit});
    }
  std::erase_if(ranked, [&](const Ranked& r) { return r.fit.share < best - kAlike; });
  if (ranked.empty()) return std::nullopt;
  const bool said_april = specified.kind == BoardKind::kAprilGrid;
  Board like = specified;
  // What is said of a kind with another usual way of numbering says nothing about this one's.
  if ((sighting.border_cells == 2) != said_april) like.order = {.upwards = sighting.border_cells == 2};
  const auto chosen = std::ranges::min_element(
      ranked, {}, [&](const Ranked& r) { return std::pair(Unlikeness(like, r.board), -r.fit.share); });
  OtherBoard other{.board = chosen->board};
  const auto& names = sighting.family->names;
  const auto holds_all = [&](const std::string& name) {
    return SizeOf(name) >= other.board.first_marker + static_cast<int>(other.board.MarkerPlaces().size());
  };
  if (std::ranges::find(names, specified.dictionary) == names.end() || !holds_all(specified.dictionary))
    other.board.dictionary = *std::ranges::find_if(names.begin(), std::prev(names.end()), holds_all);
  double step = chosen->fit.step;
  bool other_step = false;
  if (other.board.IsMarkerGrid() != specified.IsMarkerGrid() || specified.marker_mm <= 0)
    SetLengths(specified, step, other.board);
  else if ((other_step = HasOtherStep(other.board, chosen->fit.step, pictures, step)))
    SetLengths(specified, step, other.board);
  if (other.board == specified) return std::nullopt;
  Board with_said_lengths = other.board;
  with_said_lengths.square_mm = specified.square_mm;
  with_said_lengths.gap_mm = specified.gap_mm;
  other.other_lengths_only = with_said_lengths == specified;
  other.what = Differences(specified, other.board, other_step);
  const bool is_written = sighting.border_cells == 1 || other.board.dictionary == "DICT_APRILTAG_36h11";
  other.cure = is_written ? GiveBoard(other.board)
                          : fmt::format(
                                "a border of two cells is known with DICT_APRILTAG_36h11 only, not with {}: "
                                "print another board (ulf board)",
                                other.board.dictionary);
  return other;
}

std::optional<OtherBoard> OtherChessboard(const Board& specified, const std::vector<cv::Mat>& pictures) {
  Board counted = specified;
  // The text says another kind of board, and so no counts of a chessboard.
  const bool is_said = specified.kind == BoardKind::kChessboard;
  if (!is_said) counted.columns = counted.rows = 0;
  const auto squares = OtherChessboardIn(counted, pictures);
  if (!squares) return std::nullopt;
  if (!is_said) {
    OtherBoard other{.board = Board::Parse(
                         fmt::format("chessboard:{}x{}:{}", std::max(squares->width, squares->height),
                                     std::min(squares->width, squares->height),
                                     specified.IsMarkerGrid() ? specified.marker_mm : specified.square_mm))};
    other.what = "a chessboard; measure its squares";
    other.cure = GiveBoard(other.board);
    return other;
  }
  OtherBoard other{.board = specified};
  other.board.columns = squares->width;
  other.board.rows = squares->height;
  const bool counts_corners =
      squares->width == specified.columns + 1 && squares->height == specified.rows + 1;
  other.what = counts_corners ? fmt::format("{} x {} counts inner corners, the text counts squares",
                                            specified.columns, specified.rows)
                              : Differences(specified, other.board, false);
  other.cure = GiveBoard(other.board);
  return other;
}

}  // namespace

double PlaneMisfit(const std::vector<Eigen::Vector3d>& points, const BoardView& view) {
  std::vector<cv::Point2d> from, to, there;
  for (std::size_t i = 0; i < view.ids.size(); ++i) {
    const Eigen::Vector3d& point = points[static_cast<std::size_t>(view.ids[i])];
    from.emplace_back(point.x(), point.y());
    to.emplace_back(view.img[i].x(), view.img[i].y());
  }
  if (from.size() < 4) return 0;
  const cv::Mat plane = cv::findHomography(from, to);
  if (plane.empty()) return 1;
  cv::perspectiveTransform(from, there, plane);
  std::vector<double> misses;
  cv::Point2d low = to[0], high = to[0];
  for (std::size_t i = 0; i < to.size(); ++i) {
    misses.push_back(cv::norm(there[i] - to[i]));
    low = {std::min(low.x, to[i].x), std::min(low.y, to[i].y)};
    high = {std::max(high.x, to[i].x), std::max(high.y, to[i].y)};
  }
  return Median(misses) / std::max(1.0, cv::norm(high - low));
}

std::optional<OtherBoard> BoardInPictures(const Board& specified, const std::vector<cv::Mat>& pictures) {
  std::vector<Quads> quads = QuadsIn(pictures);
  std::optional<Sighting> best;
  double said_share = 0;
  if (specified.kind != BoardKind::kChessboard) {
    Sighting as_said = SightingAsSaid(specified, quads, pictures);
    const LayoutFit fit = LayoutFitOf(specified, NeighboursIn(as_said.pictures));
    said_share = fit.share;
    if (fit.share >= kLayoutFits) {
      double step = 0;
      const bool other_step = HasOtherStep(specified, fit.step, pictures, step);
      if (!other_step && fit.share > 1 - kClearlyBetter) return std::nullopt;
      if (other_step) said_share = 0;
    }
    if (as_said.Most() >= kLeastMarkers) best = std::move(as_said);
  }
  // Clearly more markers of another dictionary can be read.
  constexpr std::size_t kClearly = 2;
  for (const DictionaryFamily& family : DictionaryFamilies())
    for (const int border_cells : {1, 2}) {
      Sighting sighting = SightingIn(quads, pictures, family, family.largest, border_cells);
      const std::size_t needed = best ? kClearly * best->Most() : kLeastMarkers;
      if (sighting.Most() >= needed) best = std::move(sighting);
    }
  if (best) return LayoutOf(specified, *best, pictures, said_share);
  if (specified.kind == BoardKind::kChessboard) return OtherChessboard(specified, pictures);
  // Markers cannot be read in a mirror.
  std::vector<cv::Mat> mirrored(pictures.size());
  for (std::size_t i = 0; i < pictures.size(); ++i) cv::flip(pictures[i], mirrored[i], 1);
  const Sighting in_mirror = SightingAsSaid(specified, QuadsIn(mirrored), mirrored);
  if (in_mirror.Most() < kLeastMarkers ||
      LayoutFitOf(specified, NeighboursIn(in_mirror.pictures)).share < kLayoutFits)
    return OtherChessboard(specified, pictures);
  return OtherBoard{.board = specified,
                    .what = "mirrored",
                    .cure =
                        "the pictures are mirrored: turn that off in the camera, or in the program that "
                        "saved them, and take them again"};
}

bool MarkersContradict(const Board& specified, const std::vector<cv::Mat>& pictures) {
  if (specified.kind == BoardKind::kChessboard) return false;
  const Sighting sighting = SightingAsSaid(specified, QuadsIn(pictures), pictures);
  return sighting.Most() >= kLeastMarkers &&
         LayoutFitOf(specified, NeighboursIn(sighting.pictures)).share <= 1 - kClearlyBetter;
}

std::string DescribeOtherBoard(const Board& specified, const OtherBoard& other) {
  if (other.board == specified) return fmt::format("{} is not found; {}", specified.Text(), other.cure);
  return fmt::format("the corners do not lie as on {}; they lie as on {} ({}): {}", specified.Text(),
                     other.board.Text(), other.what, other.cure);
}

}  // namespace ulf::acquisition
