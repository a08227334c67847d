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
  // The mean of both markers' side vectors, and the vector from middle to middle; pixels.
  Eigen::Vector2d right, down, shift;
};

struct Neighbours {
  std::vector<MarkerPair> pairs;  // of all pictures, in the order of their numbers
  std::map<int, int> times;       // how often each number was seen beside another
};

// Pairs each marker with up to four nearest ones in its picture.
Neighbours NeighboursIn(const std::vector<SeenMarkers>& pictures);

struct LayoutFit {
  double share = 0;  // of the markers seen, those in the largest part that lies as the layout says
  double step = 0;   // distance of neighbouring places (of a ChArUco board: a square's side), in marker sides
};

// Joins neighbours that agree with the layout in most pictures; the largest group gives the share, 0 if none
// are joined. A layout with a wrong first number or corner joins whole rows but not all of them, so that
// several groups remain although few pairs contradict.
LayoutFit LayoutFitOf(const Board& layout, const Neighbours& neighbours);

// Returns how many squares a visible chessboard has that differs from the specified one, across and down, in
// the orientation of `specified`; none if the pictures (CV_8UC1) show the specified board, or no other one as
// a whole. A single picture suffices for one row or column more. Anything else needs two, because a hand may
// cover a part of the specified board, and other patterns have any size.
std::optional<cv::Size> OtherChessboardIn(const Board& specified, const std::vector<cv::Mat>& pictures);

}  // namespace ulf::acquisition
