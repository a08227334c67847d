#include "acquisition/calibration/calibration_guide.h"

#include <algorithm>
#include <array>

namespace ulf::acquisition {
namespace {

// All guessed. Shares are of the image's width.
constexpr int kMostViews = 60;           // so many are enough in any case
constexpr double kTilted = Radians(18);  // a board that leans more counts as tilted
constexpr double kStillShare = 0.004;    // a board that moved less since the last frame is still
constexpr double kNewShare = 0.08;       // a board that is farther from every taken view is new
constexpr double kMovedShare = 0.02;     // one that adds a part or a tilt must have moved this far
constexpr double kBlurFactor = 1.5;      // a view is sharp up to this multiple of the least blur so far
constexpr int kCornersInCell = 2;        // a part of the image is covered by so many corners

std::size_t Count(const std::vector<bool>& flags) {
  return static_cast<std::size_t>(std::count(flags.begin(), flags.end(), true));
}

bool AddsTo(const std::vector<bool>& known, const std::vector<bool>& shown) {
  for (std::size_t i = 0; i < known.size(); ++i)
    if (shown[i] && !known[i]) return true;
  return false;
}

}  // namespace

const char* Name(ViewVerdict verdict) {
  constexpr std::array kNames{"taken", "board not seen", "moving", "blurred", "nothing new"};
  return kNames[static_cast<std::size_t>(verdict)];
}

CalibrationGuide::CalibrationGuide(const Board& board, int width, int height, int least_views)
    : board_(board),
      points_(board.Points()),
      width_(width),
      height_(height),
      least_views_(least_views),
      rough_(CameraModel::Pinhole(width, height, width)),
      cells_(kColumns * kRows),
      tilts_(kTilts) {}

CalibrationGuide::Seen CalibrationGuide::SeenIn(const BoardView& view) const {
  Seen seen{std::vector<bool>(kColumns * kRows), std::vector<bool>(kTilts)};
  std::array<int, kColumns * kRows> corners{};
  for (const Eigen::Vector2d& img : view.img) {
    const int column = std::clamp(static_cast<int>(img.x() / width_ * kColumns), 0, kColumns - 1);
    const int row = std::clamp(static_cast<int>(img.y() / height_ * kRows), 0, kRows - 1);
    ++corners[static_cast<std::size_t>(row * kColumns + column)];
  }
  for (std::size_t i = 0; i < corners.size(); ++i) seen.cells[i] = corners[i] >= kCornersInCell;
  if (const auto pose = PoseOfBoard(points_, view, rough_)) {
    const BoardCoverage one = CoverageOf(width_, height_, {view}, {*pose});
    const double tilts[kTilts] = {one.left, one.right, one.upper, one.lower};
    for (std::size_t i = 0; i < kTilts; ++i) seen.tilts[i] = tilts[i] > kTilted;
  }
  return seen;
}

void CalibrationGuide::Take(BoardView view) {
  views_.push_back(std::move(view));
  // New rough intrinsics change what counts as a tilt, so all views are judged again.
  if (views_.size() >= 4 && views_.size() % 4 == 0)
    if (const auto rough = RoughIntrinsics(board_, views_, width_, height_)) rough_ = *rough;
  CountAgain();
}

void CalibrationGuide::RemoveLast() {
  if (!views_.empty()) views_.pop_back();
  CountAgain();
}

void CalibrationGuide::CountAgain() {
  std::fill(cells_.begin(), cells_.end(), false);
  std::fill(tilts_.begin(), tilts_.end(), false);
  for (const BoardView& taken : views_) {
    const Seen seen = SeenIn(taken);
    for (std::size_t i = 0; i < cells_.size(); ++i) cells_[i] = cells_[i] || seen.cells[i];
    for (std::size_t i = 0; i < tilts_.size(); ++i) tilts_[i] = tilts_[i] || seen.tilts[i];
  }
}

ViewVerdict CalibrationGuide::JudgeFrame(const cv::Mat& gray, const std::string& name) {
  BoardView view = DetectBoard(board_, gray);
  if (view.ids.empty()) {
    last_.reset();
    return ViewVerdict::kNotSeen;
  }
  view.name = name;
  const bool still = last_ && MeanShiftPx(view, *last_) < kStillShare * width_;
  last_ = view;
  if (!still) return ViewVerdict::kMoving;
  return Judge(std::move(view), gray);
}

ViewVerdict CalibrationGuide::JudgePhotograph(const cv::Mat& gray, const std::string& name) {
  BoardView view = DetectBoard(board_, gray);
  last_.reset();
  if (view.ids.empty()) return ViewVerdict::kNotSeen;
  view.name = name;
  last_ = view;
  return Judge(std::move(view), gray);
}

ViewVerdict CalibrationGuide::Judge(BoardView view, const cv::Mat& gray) {
  const double blur_px = EdgeBlurPx(view, gray);
  least_blur_px_ = std::min(least_blur_px_, blur_px);
  if (blur_px > kBlurFactor * least_blur_px_) return ViewVerdict::kBlurred;
  const Seen seen = SeenIn(view);
  const bool elsewhere = std::all_of(views_.begin(), views_.end(), [&](const BoardView& taken) {
    return MeanShiftPx(view, taken) > kNewShare * width_;
  });
  // A view of the same place adds nothing, even where it covers a missing part.
  const bool moved = std::all_of(views_.begin(), views_.end(), [&](const BoardView& taken) {
    return MeanShiftPx(view, taken) > kMovedShare * width_;
  });
  const bool adds = AddsTo(cells_, seen.cells) || AddsTo(tilts_, seen.tilts);
  if (!elsewhere && !(adds && moved)) return ViewVerdict::kNothingNew;
  Take(std::move(view));
  return ViewVerdict::kTaken;
}

bool CalibrationGuide::Enough() const {
  const auto views = static_cast<int>(views_.size());
  return views >= kMostViews || (views >= least_views_ && Share() >= 1);
}

double CalibrationGuide::Share() const {
  // All parts but one, because a corner of the image may lie outside a fisheye's circle.
  const double cells = std::min(1.0, static_cast<double>(Count(cells_)) / (kColumns * kRows - 1));
  const double tilts = static_cast<double>(Count(tilts_)) / kTilts;
  const double views = std::min(1.0, static_cast<double>(views_.size()) / least_views_);
  return (cells + tilts + views) / 3;
}

std::string CalibrationGuide::NextInstruction() const {
  if (views_.empty()) return "hold the board still in the middle of the image";
  constexpr std::array kEdges{"left", "right", "upper", "lower"};
  const auto missing_tilt = std::find(tilts_.begin(), tilts_.end(), false);
  const bool cells_missing = Count(cells_) < kColumns * kRows - 1;
  // Alternates between parts and tilts, so that tilts do not all come at the end.
  if (missing_tilt != tilts_.end() && (!cells_missing || views_.size() % 2 == 1))
    return std::string("tilt the board: its ") +
           kEdges[static_cast<std::size_t>(missing_tilt - tilts_.begin())] + " edge away from the camera";
  if (cells_missing) {
    const auto cell = static_cast<int>(std::find(cells_.begin(), cells_.end(), false) - cells_.begin());
    constexpr std::array kAcross{"left", "left", "middle", "right", "right"};
    constexpr std::array kDown{"upper", "middle", "middle", "lower"};
    return fmt::format("bring the board to the image's {} {} part",
                       kDown[static_cast<std::size_t>(cell / kColumns)],
                       kAcross[static_cast<std::size_t>(cell % kColumns)]);
  }
  return "other places and distances";
}

std::string CalibrationGuide::Map() const {
  std::string map;
  for (int row = 0; row < kRows; ++row) {
    if (row) map += '/';
    for (int column = 0; column < kColumns; ++column)
      map += cells_[static_cast<std::size_t>(row * kColumns + column)] ? '#' : '.';
  }
  return map;
}

}  // namespace ulf::acquisition
