// Checks of numbers, without photographs, which cost so little that every reader of a light field runs them.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/light_field/findings.h"
#include "core/light_field/light_field.h"

namespace ulf {

// Measures how the points of a light field fit its cameras, by a sample of both.
struct PointsFit {
  std::size_t observations = 0, misplaced = 0;  // farther than kMostTrackErrorPx from the points' projections
  double shown_share = 1;   // of the points: inside at least one view's picture, ignoring occlusion
  double views_share = 1;   // of the views: those that show any of the points
  double spread_share = 1;  // of a picture's diagonal: middle half of its points, median over views
  double baseline_share =
      1;  // of the median distance to the points: spread of the cameras around their middle
};

// Without points, or with fewer than two views, the result is that of a fit.
PointsFit FitOfPoints(const LightField& light_field);

// Says why the points do not belong to the poses, as a clause; empty if they may.
std::string DescribeMisfit(const PointsFit& fit);

std::vector<Finding> QuickFindings(const LightField& light_field);
// Returns these and the still valid findings of earlier runs: all that is known without reading photographs.
std::vector<Finding> KnownFindings(const std::vector<KeptFinding>& kept, const LightField& light_field);

// Sets LightField::findings to the known findings and warns of each.
void AddKnownFindings(const std::vector<KeptFinding>& kept, LightField& light_field);

}  // namespace ulf
