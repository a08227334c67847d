// Finds which board pictures show when it is not the specified one: columns and rows exchanged, markers
// numbered in another way or from another number on, a white corner where a dark one is expected, other
// counts, another dictionary, another kind of board, another ratio of marker and gap; or that the pictures
// are mirrored.
//
// Markers are compared with their neighbours in the picture: the sides of a marker span a grid in which the
// next one lies whole steps away. That needs no lens and holds under any, in a single picture and in poor
// ones; a board that agrees with the specified one is therefore never taken for another. Markers of another
// sheet beside it, or in place of it in a few pictures, do not lie on its grid and change nothing.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/fiducials/board_detector.h"

namespace ulf::acquisition {

struct OtherBoard {
  Board board = {};       // as the markers lie; its lengths keep the size of what was said
  std::string what = {};  // how it differs, in words
  bool other_lengths_only = false;
  std::string cure = {};  // which board to give
};

// Returns none when they lie as specified, or it cannot be told. `pictures`: CV_8UC1, of which a few suffice.
std::optional<OtherBoard> BoardInPictures(const Board& specified, const std::vector<cv::Mat>& pictures);

// Returns whether more than a few of the visible markers contradict the board's layout or numbers:
// BoardInPictures() may then find another. It takes as long as detecting the markers. Returns false for a
// chessboard.
bool MarkersContradict(const Board& specified, const std::vector<cv::Mat>& pictures);

// Returns "the corners do not lie as on SAID; they lie as on OTHER (...): give board OTHER".
std::string DescribeOtherBoard(const Board& specified, const OtherBoard& other);

// Returns the median distance of a view's corners from their places under a homography, as a share of the
// view's size: lens distortion, or much more where they lie on another board. `points`: of the board.
double PlaneMisfit(const std::vector<Eigen::Vector3d>& points, const BoardView& view);

}  // namespace ulf::acquisition
