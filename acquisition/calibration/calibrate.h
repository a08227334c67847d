// Estimates intrinsics from views of a board: from detected corners to a camera model with its uncertainties,
// or to the reason why the views do not determine one. Image quantities are pixels, board points millimetres.
//
// Steps: views that repeat another are dropped; a start is found among several focal lengths and both lens
// families; corners and views that the richest models cannot explain are removed; the lens model is chosen
// (lens_choice.h); the result is checked, and doubts become warnings.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "acquisition/calibration/lens_choice.h"
#include "core/fiducials/board_detector.h"
#include "core/geometry/angles.h"

namespace ulf::acquisition {

// Thresholds of a calibration. All are guessed unless a comment says otherwise.
struct CalibrationOptions {
  // Fewer different views give no calibration.
  std::size_t least_views = 4;
  // A view whose corners moved by less than this share of the image's width repeats another and is dropped.
  double same_place_share = 0.005;
  // Corners farther than so many robust standard deviations from the richest model are outliers; at least
  // `least_gate_px`. 4.5 leaves one of 150,000 good corners out.
  double gate_sigmas = 4.5, least_gate_px = 0.1;
  // A view whose median error exceeds so many times the median of all views, and this many pixels, is
  // dropped.
  double view_factor = 3, least_view_error_px = 0.3;
  // Removing outliers is repeated at most so often: each fit is better than the last.
  int outlier_rounds = 3;
  // Refused: orientations of the board closer together than this (radians), and standard deviations of focal
  // length and principal point above this share (of the focal length, of the image's width).
  double least_orientation_spread = Radians(6);
  double most_relative_sigma = 0.05;
  // Refused: focal lengths outside these multiples of the image's width; no lens is so wide or so long.
  double shortest_focal = 0.05, longest_focal = 50;
  // Warnings, below or above: principal point this share of the width off the middle; so few views; share of
  // the image's cells with a corner; reach of the corners (half diagonals); tilt of the board (radians);
  // standard deviation of focal length and principal point (shares as above); RMS error in pixels; share of
  // outliers.
  double warn_off_center = 0.1;
  std::size_t warn_views = 10;
  double warn_cells = 0.7, warn_reach = 0.75, warn_tilt = Radians(12), warn_relative_sigma = 0.005;
  double warn_rms_px = 1, warn_outliers = 0.1;
};

// How the views cover the image and the orientations of the board.
struct BoardCoverage {
  int columns = 8, rows = 6;
  std::vector<int> corners_in_cell = {};  // row by row
  double CellShare() const;               // of the cells that hold a corner
  double reach = 0;  // the farthest corner from the middle, as a share of half the diagonal
  // The largest tilts of the board against the image plane, in radians, with its left, right, upper and lower
  // edge away from the camera.
  double left = 0, right = 0, upper = 0, lower = 0;
  double orientation_spread = 0;  // the largest angle between two views' board normals, radians
};

BoardCoverage CoverageOf(int width, int height, const std::vector<BoardView>& views,
                         const std::vector<Rigid3>& cam_from_board);

struct ViewReport {
  std::string name = {};
  std::size_t corners = 0;   // used
  std::size_t outliers = 0;  // taken out
  double rms_px = 0;
  std::string left_out = {};  // why the whole view was not used; empty when it was
};

struct CalibrationResult {
  std::string refusal = {};  // why there is no calibration, and what to do; empty when there is one
  Board board = {};
  CameraModel camera = {};
  LensChoice choice = {};
  std::array<double, 9> sigma{};  // the larger of the estimate's own and the spread over left-out views
  double rms_px = 0;
  std::vector<BoardView> views = {};        // as used
  std::vector<Rigid3> cam_from_board = {};  // of those
  std::vector<ViewReport> reports = {};     // of all views, as they came
  std::size_t corners = 0, outliers = 0;
  BoardCoverage coverage = {};
  std::vector<std::string> warnings = {};

  bool ok() const { return refusal.empty(); }
};

// `width` and `height`: of the images. The reports are in the order of `views`.
CalibrationResult CalibrateFromViews(const Board& board, const std::vector<BoardView>& views, int width,
                                     int height, const CalibrationOptions& options = {});

// The mean distance, in pixels, between the corners that two views share; infinite when they share fewer than
// four.
double MeanShiftPx(const BoardView& a, const BoardView& b);

// A starting point: the focal length and lens family that explain the views best, by robust fits of few
// parameters; none where no fit succeeds.
std::optional<CameraModel> RoughIntrinsics(const Board& board, const std::vector<BoardView>& views, int width,
                                           int height);

}  // namespace ulf::acquisition
