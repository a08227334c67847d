// Chooses the simplest lens model that explains a set of views.
//
// Every candidate (lens_fit.h) is fitted to all views and, for comparison, to the views without one fold at a
// time (one view in five, or of up to eight views a single one); the left-out views are then predicted with
// only their poses adjusted. The rule:
//
//   A candidate explains the data when no other is better by both measures: its BIC lower by more than 10
//   ("very strong" after Kass and Raftery 1995), and its squared error on left-out views lower by more
//   than two standard errors of the difference, view by view. Chosen is the candidate with the fewest
//   parameters that explains the data; of equals, a perspective lens before a fisheye, then the lower BIC.
//   A candidate that cannot be inverted somewhere in the image is no rival, and chosen only if no other
//   explains the data.
//
// BIC alone would attribute everything that frames share (a bent board) to the lens, because it treats
// corners as independent; left-out frames alone would miss small but certain distortions.
#pragma once

#include <array>
#include <vector>

#include "acquisition/calibration/lens_fit.h"

namespace ulf::acquisition {

struct CandidateResult {
  LensFit fit = {};
  double bic = 0;
  std::vector<double> left_out_px2 = {};  // mean squared distance of each view when it was left out
  double LeftOutRmsPx() const;
  // Standard deviations of fx fy cx cy and the coefficients from the fits without one fold (jackknife).
  std::array<double, 9> spread{};
  bool folds_inside_image = false;  // some point of the image's edge has no ray
  bool explains = false;            // the data, by the rule above
};

struct LensChoice {
  std::vector<CandidateResult> table = {};  // in the order of LensCandidates(), usable ones only
  std::size_t chosen = 0;                   // index in the table
  int folds = 0;                            // into how many the views were divided
};

// `start`: any camera near the truth. The views must be free of outliers. The table is empty if none fits.
LensChoice ChooseLens(const std::vector<Eigen::Vector3d>& board_points, const std::vector<BoardView>& views,
                      const CameraModel& start);

}  // namespace ulf::acquisition
