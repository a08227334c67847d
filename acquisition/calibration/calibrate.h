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

// Describes which parts of the image and which orientations of the board the views cover.
struct BoardCoverage {
  int columns = 8, rows = 6;
  std::vector<int> corners_in_cell = {};  // number of corners in each cell of the image, row by row
  double CellShare() const;               // how many of the cells hold a corner, 0 to 1
  double reach = 0;  // distance of the farthest corner from the image's middle, in half diagonals
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
  // Standard deviations of fx fy cx cy and the coefficients: of LensFit or CandidateResult, the larger one.
  std::array<double, 9> sigma{};
  double rms_px = 0;
  std::vector<BoardView> views = {};        // those used, without outliers
  std::vector<Rigid3> cam_from_board = {};  // a pose for each of `views`
  std::vector<ViewReport> reports = {};     // one for each view that was given, in the same order
  std::size_t corners = 0, outliers = 0;
  BoardCoverage coverage = {};
  std::vector<std::string> warnings = {};

  bool ok() const { return refusal.empty(); }
};

// Calibrates the camera of images of `width` x `height` pixels.
CalibrationResult CalibrateFromViews(const Board& board, const std::vector<BoardView>& views, int width,
                                     int height);

// Returns the mean distance, in pixels, of the corners that two views share; infinite for fewer than four.
double MeanShiftPx(const BoardView& a, const BoardView& b);

// Returns a starting point: the focal length and lens family that explain the views best, by robust fits of
// few parameters; none where no fit succeeds.
std::optional<CameraModel> RoughIntrinsics(const Board& board, const std::vector<BoardView>& views, int width,
                                           int height);

}  // namespace ulf::acquisition
