// How many squares a chessboard in sight has, whatever was said of it.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "core/fiducials/board.h"

namespace ulf::acquisition {

// The squares across and down, turned as those of `said` are, of a board that stands whole in the pictures (CV_8UC1) and is
// not the one that was said. None: it is, or no other is found. Less than the whole of the board that was said is seen
// where a hand covers a part, and a pattern of something else may have any size: only one row or column more is told by
// a single picture, all else by two.
std::optional<cv::Size> OtherChessboardIn(const Board& said, const std::vector<cv::Mat>& pictures);

}  // namespace ulf::acquisition
