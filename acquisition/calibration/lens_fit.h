// One lens model fitted to views of a board (Zhang 2000), all parameters and poses at once, by least squares.
//
// Lengths: image points in pixels with centres at integer + 0.5, board points in millimetres. Standard
// deviations are those of the least-squares estimate: the residuals' own variance times the inverse of the
// normal matrix, poses eliminated. They hold for independent errors; what frames share (a bent board) shows
// in the spread over left-out frames instead (lens_choice.h).
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/fiducials/board_detector.h"
#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"

namespace ulf::acquisition {

// A lens model that may be all that a lens needs.
struct LensCandidate {
  const char* name = "";
  Distortion distortion = Distortion::kNone;
  bool one_focal = true;            // fx = fy
  std::array<bool, 5> estimated{};  // which coefficients; the others are 0
  // Focal lengths, principal point, coefficients.
  int Parameters() const;
};

// From the simplest to the richest.
const std::vector<LensCandidate>& LensCandidates();

struct LensFit {
  LensCandidate candidate = {};
  bool usable = false;
  CameraModel camera = {};
  std::vector<Rigid3> cam_from_board = {};  // per view
  double squared_px = 0;                    // sum over corners of squared distances
  std::size_t corners = 0;
  // Standard deviations of fx fy cx cy and the coefficients; 0 where not estimated, infinite where the views
  // do not determine them.
  std::array<double, 9> sigma{};

  double RmsPx() const;
};

struct LensFitOptions {
  double huber_px = 0;  // 0: plain squares
  int max_iterations = 60;
  bool with_sigma = true;
};

// From `start` and poses found with it. Not usable where it does not converge.
LensFit FitLens(const std::vector<Eigen::Vector3d>& board_points, const std::vector<BoardView>& views,
                const LensCandidate& candidate, const CameraModel& start, const LensFitOptions& options = {});

// The pose of one view under known intrinsics, by least squares; none where there is none.
std::optional<Rigid3> PoseOfBoard(const std::vector<Eigen::Vector3d>& board_points, const BoardView& view,
                                  const CameraModel& camera);

// The residuals of a view's corners, seen minus predicted, in pixels; a corner that the model cannot image
// gets a large one.
std::vector<Eigen::Vector2d> Residuals(const std::vector<Eigen::Vector3d>& board_points,
                                       const BoardView& view, const CameraModel& camera,
                                       const Rigid3& cam_from_board);

}  // namespace ulf::acquisition
