// How well markers seen lie as a layout of a board has them, by their neighbours in the pictures: no lens,
// pose or size is needed.
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
  // The sides of both, and from one's middle to the other's; pixels.
  Eigen::Vector2d right, down, shift;
};

struct Neighbours {
  std::vector<MarkerPair> pairs;  // by number
  std::map<int, int> times;       // how often each number was seen beside another
};

// Each marker with its nearest ones, within its picture.
Neighbours NeighboursIn(const std::vector<SeenMarkers>& pictures);

struct LayoutFit {
  double share = 0;  // of the markers seen: the largest part of the board that lies as the layout has it
  double step = 0;   // from marker to marker (of a ChArUco board: the side of a square), in marker sides
};

// Neighbours are joined where they lie as the layout has them in most pictures. A layout that is wrong in its
// first number or its corner joins whole rows, but not all: the groups tell, though few pairs contradict.
// Zero where none are joined.
LayoutFit LayoutFitOf(const Board& layout, const Neighbours& neighbours);

// How many squares a chessboard in sight has, whatever was said of it: the squares across and down, turned as
// those of `said` are, of a board that stands whole in the pictures (CV_8UC1) and is not the one that was
// said. None: it is, or no other is found. Less than the whole of the board that was said is seen where a
// hand covers a part, and a pattern of something else may have any size: only one row or column more is told
// by a single picture, all else by two.
std::optional<cv::Size> OtherChessboardIn(const Board& said, const std::vector<cv::Mat>& pictures);

}  // namespace ulf::acquisition
