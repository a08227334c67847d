// Chooses frames during a live calibration and tells the operator which views of the board are still missing.
//
// Needed are corners in all parts of the image but one (a grid of 5 x 4), and each of the board's four edges
// tilted away from the camera once. The guide takes a frame when the board is sharp, has not moved since the
// frame before, and is new: it covers another part of the image, shows a missing tilt, or stands elsewhere
// than in every taken view.
//
// Poses come from rough intrinsics that are estimated again as views are taken. For one thread.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "acquisition/calibration/calibrate.h"
#include "core/geometry/angles.h"

namespace ulf::acquisition {

enum class ViewVerdict { kTaken, kNotSeen, kMoving, kBlurred, kNothingNew };
const char* Name(ViewVerdict verdict);

class CalibrationGuide {
 public:
  static constexpr int kLeastViews = 14;  // guessed
  // `width`, `height`: of the frames. `least_views`: fewer are not enough, even when they cover everything.
  CalibrationGuide(const Board& board, int width, int height, int least_views = kLeastViews);

  // Judges the next frame of the stream (CV_8UC1); a taken view gets `name`.
  ViewVerdict JudgeFrame(const cv::Mat& gray, const std::string& name);
  // Judges a photograph, which stands for itself: never kMoving.
  ViewVerdict JudgePhotograph(const cv::Mat& gray, const std::string& name);
  // Removes the view that was taken last.
  void RemoveLast();

  const std::vector<BoardView>& views() const { return views_; }
  const std::optional<BoardView>& last() const { return last_; }  // of the last picture; none: not seen
  bool Enough() const;   // whether the views show all that is needed, or are 60
  double Share() const;  // of what is needed, 0 to 1
  // Returns the next instruction to the operator: "bring the board to the image's upper right part".
  std::string NextInstruction() const;
  // Returns the parts of the image as text, '#' for covered and '.' for not, top row first, '/' between rows.
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
  int least_views_;
  CameraModel rough_;
  std::vector<BoardView> views_;
  std::vector<bool> cells_, tilts_;
  std::optional<BoardView> last_;
  double least_blur_px_ = 1e9;
};

}  // namespace ulf::acquisition
