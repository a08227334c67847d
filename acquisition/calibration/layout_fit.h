// Tests how well detected markers agree with the layout of a board, by their neighbours in the pictures: no
// lens, pose or size is needed.
#pragma once

#include <Eigen/Core>
#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "core/fiducials/board.h"
#include "core/fiducials/marker_detector.h"

namespace ulf::acquisition {

// The markers of a picture by number.
using SeenMarkers = std::map<int, MarkerImage>;

struct MarkerPair {
  int from = 0, to = 0;  // numbers, the smaller one first
  // The mean side vectors of both markers, and the vector between their middles; pixels.
  Eigen::Vector2d right, down, shift;
};

struct Neighbours {
  std::vector<MarkerPair> pairs;  // by number
  std::map<int, int> times;       // how often each number was seen beside another
};

// Pairs each marker with its nearest ones in its picture.
Neighbours NeighboursIn(const std::vector<SeenMarkers>& pictures);

struct LayoutFit {
  double share = 0;  // of the markers seen: the largest part of the board that lies as the layout has it
  double step = 0;   // from marker to marker (of a ChArUco board: the side of a square), in marker sides
};

// Neighbours are joined where they agree with the layout in most pictures. A layout that is wrong in its
// first number or its corner joins whole rows, but not all, so that groups remain although few pairs
// contradict. The share is zero where none are joined.
LayoutFit LayoutFitOf(const Board& layout, const Neighbours& neighbours);

// Returns how many squares a visible chessboard has that differs from the specified one, across and down, in
// the orientation of `specified`. The board must be whole in the pictures (CV_8UC1). Returns none when they
// show the specified board, or no other is found. A hand may cover a part of the specified board, and other
// patterns have any size: a single picture suffices for one row or column more, anything else needs two.
std::optional<cv::Size> OtherChessboardIn(const Board& specified, const std::vector<cv::Mat>& pictures);

}  // namespace ulf::acquisition
