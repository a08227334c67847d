// Finds which board pictures show if it is not the specified one: with columns and rows exchanged, markers
// numbered in another way or from another number on, a white corner instead of a dark one, other counts,
// another dictionary, another kind of board, another ratio of marker and gap; or the pictures are mirrored.
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
  // The board that the markers lie on, as large as the specified one, because pictures tell no size; the
  // specified one if the pictures are mirrored.
  Board board = {};
  std::string what = {};            // how it differs, for people
  bool other_lengths_only = false;  // it differs in its lengths alone
  std::string cure = {};            // what to do, for people: which board to name
};

// Returns none if the pictures show the specified board, or no known one. `pictures`: CV_8UC1; a few suffice.
std::optional<OtherBoard> BoardInPictures(const Board& specified, const std::vector<cv::Mat>& pictures);

// Returns whether more than a few of the visible markers contradict the board's layout or numbers, so that
// BoardInPictures() may find another; false for a chessboard. It takes as long as detecting the markers.
bool MarkersContradict(const Board& specified, const std::vector<cv::Mat>& pictures);

// Returns "the corners do not lie as on SAID; they lie as on OTHER (...): give board OTHER".
std::string DescribeOtherBoard(const Board& specified, const OtherBoard& other);

// Returns the median distance of a view's corners from where a homography puts `points`, the board's corners,
// as a share of the view's size. It is a measure of lens distortion; much more means another board.
double PlaneMisfit(const std::vector<Eigen::Vector3d>& points, const BoardView& view);

}  // namespace ulf::acquisition
