// Fits one lens model to views of a board by least squares over all parameters and poses (Zhang 2000).
//
// Image points are in pixels with centres at integer + 0.5, board points in millimetres. Standard deviations
// are those of the least-squares estimate: the variance of the residuals times the inverse of the normal
// matrix with poses eliminated. They assume independent errors; errors common to all frames (a bent board)
// appear in the spread over left-out frames (lens_choice.h).
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "core/fiducials/board_detector.h"
#include "core/geometry/camera_model.h"
#include "core/geometry/rigid3.h"

namespace ulf::acquisition {

// A lens model with its free parameters.
struct LensCandidate {
  const char* name = "";
  Distortion distortion = Distortion::kNone;
  bool one_focal = true;            // fx = fy
  std::array<bool, 5> estimated{};  // which coefficients; the others are 0
  // Returns the number of free parameters: focal lengths, principal point, coefficients.
  int Parameters() const;
};

// Returns the candidates from the simplest to the richest.
const std::vector<LensCandidate>& LensCandidates();

struct LensFit {
  LensCandidate candidate = {};
  bool usable = false;
  CameraModel camera = {};
  std::vector<Rigid3> cam_from_board = {};  // of each view
  double squared_px = 0;                    // sum over the corners of their squared errors
  std::size_t corners = 0;
  // Standard deviations of fx fy cx cy and the coefficients; 0: not estimated, infinite: not determined.
  std::array<double, 9> sigma{};

  double RmsPx() const;
};

struct LensFitOptions {
  double huber_px = 0;  // 0: plain squares
  int max_iterations = 60;
  bool with_sigma = true;
};

// Starts from `start` and the poses that it gives. Not `usable` if a view has none, or the solver fails.
LensFit FitLens(const std::vector<Eigen::Vector3d>& board_points, const std::vector<BoardView>& views,
                const LensCandidate& candidate, const CameraModel& start, const LensFitOptions& options = {});

// Returns cam_from_board of one view for known intrinsics by least squares; none if no pose was found.
std::optional<Rigid3> PoseOfBoard(const std::vector<Eigen::Vector3d>& board_points, const BoardView& view,
                                  const CameraModel& camera);

// Returns the residuals of a view's corners, observed minus predicted, pixels; large if none is predicted.
std::vector<Eigen::Vector2d> Residuals(const std::vector<Eigen::Vector3d>& board_points,
                                       const BoardView& view, const CameraModel& camera,
                                       const Rigid3& cam_from_board);

}  // namespace ulf::acquisition
