// Chooses frames during a live calibration and tells the operator which views of the board are still missing.
//
// Needed are corners in every part of the image (a grid of 5 x 4), and each of the board's four edges tilted
// away from the camera once. A frame is taken when the board is sharp, still (also against the frame before
// it) and new: it covers another part of the image, shows a missing tilt, or stands elsewhere than in every
// taken view.
//
// Poses come from rough intrinsics that are estimated again as views are taken. For one thread; the caller
// owns the loop.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "acquisition/calibration/calibrate.h"
#include "core/geometry/angles.h"

namespace ulf::acquisition {

enum class ViewVerdict { kTaken, kNotSeen, kMoving, kBlurred, kNothingNew };
const char* Name(ViewVerdict verdict);

// All thresholds are guessed. Shares are of the image's width.
struct GuideOptions {
  int least_views = 14;         // fewer are not enough, even when they cover everything
  int most_views = 60;          // so many are enough in any case
  double tilted = Radians(18);  // radians; a board that leans more counts as tilted
  double still_share = 0.004;   // a board that moved less since the last frame is still
  double new_share = 0.08;      // a board that is farther from every taken view is new
  double moved_share = 0.02;    // one that adds a part or a tilt must have moved this far
  double blur_factor = 1.5;     // a view is sharp up to this multiple of the least blur so far
  int corners_in_cell = 2;      // a part of the image is covered by so many corners
};

class CalibrationGuide {
 public:
  CalibrationGuide(const Board& board, int width, int height, const GuideOptions& options = {});

  // Judges the next frame of the stream (CV_8UC1); a taken view gets `name`.
  ViewVerdict Look(const cv::Mat& gray, const std::string& name);
  // The same for a photograph, which stands for itself: never kMoving.
  ViewVerdict LookAtPhotograph(const cv::Mat& gray, const std::string& name);
  // The last view that was taken counts no more.
  void ForgetLast();

  const std::vector<BoardView>& views() const { return views_; }
  const std::optional<BoardView>& last() const { return last_; }  // of the last picture; none: not seen
  bool Enough() const;
  double Share() const;  // of what is needed, 0 to 1
  // The next instruction to the operator: "bring the board to the image's upper right part".
  std::string NextMove() const;
  // The parts of the image as text, '#' for covered and '.' for not, top row first, '/' between rows.
  std::string Map() const;
  static constexpr int kColumns = 5, kRows = 4;  // parts of the image, row by row
  const std::vector<bool>& cells() const { return cells_; }
  static constexpr int kTilts = 4;  // left, right, upper, lower edge away
  const std::vector<bool>& tilts() const { return tilts_; }

 private:
  struct Seen {
    std::vector<bool> cells;
    std::vector<bool> tilts;
  };
  Seen SeenIn(const BoardView& view) const;
  ViewVerdict Judge(BoardView view, const cv::Mat& gray);
  void Take(BoardView view);
  void CountAgain();

  Board board_;
  std::vector<Eigen::Vector3d> points_;
  int width_, height_;
  GuideOptions options_;
  CameraModel rough_;
  std::vector<BoardView> views_;
  std::vector<bool> cells_, tilts_;
  std::optional<BoardView> last_;
  double least_blur_px_ = 1e9;
};

}  // namespace ulf::acquisition
