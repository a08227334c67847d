// Names the markers that poses come from: a board of known layout, or single markers of known size.
//
//   charuco:7x5:30:22:DICT_5X5_100      a board (core/fiducials/board.h)
//   aruco:4x5:37.5:5:DICT_6X6_1000      a board
//   aprilgrid:6x6:30:9                  a board
//   marker:80:DICT_APRILTAG_36h11:3     the marker with number 3, its black square 80 mm wide
//   marker:80:DICT_APRILTAG_36h11       several of that size, whose arrangement is learnt while tracking
//
// The frame of a board or marker is in metres, the origin is the board's upper left corner or the marker's
// middle; x points right, y down, z into the sheet. Of several markers the first one seen well is the world.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/fiducials/board.h"

namespace ulf::tracking {

struct MarkerSpec {
  enum class Kind { kBoard, kOne, kSeveral };
  Kind kind = Kind::kBoard;
  Board board;             // for kBoard
  double side_m = 0;       // of the black square, for kOne and kSeveral
  int id = 0;              // number in the dictionary, for kOne
  std::string dictionary;  // of OpenCV, as "DICT_5X5_100"

  static MarkerSpec Parse(const std::string& text);  // throws Refusal
  std::string Text() const;                          // as Parse() takes it
  // Returns the middle of the board, in its own frame; zero for single markers.
  Eigen::Vector3d Middle() const;
};

// Returns the corners of a single marker in its own frame, metres, clockwise from its upper left one.
std::vector<Eigen::Vector3d> MarkerCorners(double side_m);

}  // namespace ulf::tracking
