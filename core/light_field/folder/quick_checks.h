// Checks that cost so little that every reader of a light field runs them: they look at numbers, at no
// photograph.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/light_field/findings.h"
#include "core/light_field/light_field.h"

namespace ulf {

// How the points of a light field lie before its cameras, told from a sample of both.
struct PointsFit {
  std::size_t observations = 0, misplaced = 0;  // farther than kMostTrackErrorPx from the points' projections
  double shown_share = 1;  // of the points: in the picture of at least one view, not hidden considered
  double views_share = 1;  // of the views: those that show any of the points
  double spread_share =
      1;  // of a picture's diagonal that the middle half of the points in it takes, in most views
  double baseline_share =
      1;  // of the distance to the points (median): how far most cameras stand from their middle
};

// Without points, or with fewer than two views: as if they fit.
PointsFit FitOfPoints(const LightField& light_field);

// Why the points do not belong to the poses, as a clause; empty: they may.
std::string MisfitInWords(const PointsFit& fit);

std::vector<Finding> QuickFindings(const LightField& light_field);
// These, and what of the findings of earlier runs still holds: all that is known without reading photographs.
std::vector<Finding> KnownFindings(const std::vector<KeptFinding>& kept, const LightField& light_field);

// Sets LightField::findings to them and warns of each.
void AddKnownFindings(const std::vector<KeptFinding>& kept, LightField& light_field);

}  // namespace ulf
