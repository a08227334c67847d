// Which views of the board a live calibration still wants, and which frames it takes by itself.
//
// Wanted: corners in every part of the image (a grid of 5 x 4), and each of the board's four edges once
// tilted away by at least 18 degrees. A frame is taken when the board is seen sharp (edges as steep as the
// best seen, to within half), still (it moved less than 0.4 % of the width since the last frame, and that was
// a detection) and new (it shows an uncovered part, a missing tilt, or stands 8 % of the width away from
// every taken view).
//
// Poses come from rough intrinsics that are estimated anew as views are taken. One thread; the caller owns
// the loop.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "acquisition/calibration/calibrate.h"

namespace ulf::acquisition {

enum class ViewVerdict { kTaken, kNotSeen, kMoving, kBlurred, kNothingNew };
const char* Name(ViewVerdict verdict);

struct GuideOptions {
  int least_views = 14;  // enough coverage before that goes on
  int most_views = 60;
};

class CalibrationGuide {
 public:
  CalibrationGuide(const Board& board, int width, int height, const GuideOptions& options = {});

  // Looks at the next frame of the stream; a taken view carries `name`.
  ViewVerdict Look(const cv::Mat& gray, const std::string& name);

  const std::vector<BoardView>& views() const { return views_; }
  bool Enough() const;
  double Share() const;  // of what is wanted, 0 to 1
  // What to do next, for people: "tilt the board's left edge away", "bring the board to the upper right".
  std::string NextMove() const;
  // The parts of the image as rows of text, '#' covered and '.' not, top row first, '/' between rows.
  std::string Map() const;

 private:
  static constexpr int kColumns = 5, kRows = 4;
  static constexpr int kTilts = 4;
  struct Seen {
    std::vector<bool> cells;
    std::vector<bool> tilts;
  };
  Seen Shows(const BoardView& view) const;
  void Take(BoardView view);

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
