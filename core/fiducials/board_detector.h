// A board's corners in a photograph.
//
// Image points count from the image's corner, pixel centres at integer + 0.5 (OpenCV's are converted here).
// Detection needs no intrinsics. A chessboard must be seen whole; of a ChArUco board or ArUco grid any part
// will do that shows a few markers.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "core/fiducials/board.h"

namespace ulf {

struct BoardView {
  std::string name = {};                  // of the file, or of the frame
  std::vector<int> ids = {};              // index into Board::Points()
  std::vector<Eigen::Vector2d> img = {};  // where each is seen
};

// At least this many corners make a view; with fewer its pose tells nothing.
inline constexpr std::size_t kLeastCorners = 6;

// `gray`: CV_8UC1. Empty when the board is not seen or too little of it.
BoardView DetectBoard(const Board& board, const cv::Mat& gray);

// The spread of the blur at the board's edges in pixels (standard deviation), from the steepest edges within
// the board against its contrast: about 0.5 for a sharp image, larger when defocused or moved.
double EdgeBlurPx(const BoardView& view, const cv::Mat& gray);

}  // namespace ulf
