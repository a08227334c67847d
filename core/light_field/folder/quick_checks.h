// Checks of numbers, without photographs, which cost so little that every reader of a light field runs them.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/light_field/findings.h"
#include "core/light_field/light_field.h"

namespace ulf {

// How the points of a light field fit its cameras, by a sample of both.
struct PointsFit {
  std::size_t observations = 0, misplaced = 0;  // farther than kMostTrackErrorPx from the points' projections
  double shown_share = 1;   // share of the points inside at least one view's picture, ignoring occlusion
  double views_share = 1;   // share of the views that show any of the points
  double spread_share = 1;  // share of a picture's diagonal that the middle half of its points takes, median
  double baseline_share = 1;  // spread of the cameras as a share of the median distance to the points
};

// Without points, or with fewer than two views, returns the defaults, which are those of a good fit.
PointsFit FitOfPoints(const LightField& light_field);

// Says why the points do not belong to the poses, as a clause; empty if they may.
std::string DescribeMisfit(const PointsFit& fit);

// Checks points and subject (Check::kPoints, Check::kSubject).
std::vector<Finding> QuickFindings(const LightField& light_field);
// Returns these and what still holds of earlier runs of costly checks.
std::vector<Finding> KnownFindings(const std::vector<KeptFinding>& kept, const LightField& light_field);

// Sets LightField::findings to the known findings and warns of each.
void AddKnownFindings(const std::vector<KeptFinding>& kept, LightField& light_field);

}  // namespace ulf
