// Finds the corners of a board in an image.
//
// Image points are pixels from the image's corner, with pixel centres at integer + 0.5 (OpenCV's results are
// converted here). Detection needs no intrinsics. A chessboard must be visible as a whole; a ChArUco board or
// a grid of markers may be visible in part.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "core/fiducials/board.h"

namespace ulf {

struct BoardView {
  std::string name = {};                  // of the file or frame; the caller sets it
  std::vector<int> ids = {};              // indices into Board::Points()
  std::vector<Eigen::Vector2d> img = {};  // where each of these points is seen
};

// A usable view has at least this many corners: fewer do not determine a pose and check it. Guessed.
inline constexpr std::size_t kLeastCorners = 6;

// `gray` is CV_8UC1. The result is empty if fewer than kLeastCorners are found, or all nearly on a line.
BoardView DetectBoard(const Board& board, const cv::Mat& gray);

// Returns the blur of the board's edges as the standard deviation of a Gaussian, in pixels, from the steepest
// edges and the contrast within the board: about 0.5 for a sharp image, more when defocused or moving,
// infinite if there is hardly any contrast or the board is smaller than 8 pixels.
double EdgeBlurPx(const BoardView& view, const cv::Mat& gray);

}  // namespace ulf
