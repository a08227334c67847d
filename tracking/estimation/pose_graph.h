// Finds the poses that agree best with measured relative poses (Strasdat, Montiel and Davison 2010). It
// spreads the error of a closed loop over the way that led to it.
//
// A node is a similarity cam_from_world, because scale drifts like position does while nothing metric is in
// sight; with `rigid` all scales stay what they are. An edge says what to_from_from should be. Its error
// E = measured^-1 * to * from^-1 counts as rotation vector (radians), translation (over `unit`, a typical
// depth, so that it is an angle too) and logarithm of the scale. Derivatives are analytic, by a motion on the
// left of each node: they fill seven of a block's eight columns, and the manifold passes them on (residuals.h
// does the same for rigid poses).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/geometry/similarity3.h"

namespace ulf::tracking {

struct PoseGraphEdge {
  int from = 0, to = 0;  // nodes
  Similarity3 to_from_from;
  double weight = 1;  // of the squared error
};

struct PoseGraph {
  std::vector<Similarity3> cam_from_world;
  std::vector<bool> fixed;  // by node; none fixed: the first is
  std::vector<PoseGraphEdge> edges;
};

struct PoseGraphOptions {
  bool rigid = false;
  double unit = 1;
};

struct PoseGraphSummary {
  bool usable = false;
  double initial_cost = 0, final_cost = 0;  // half the weighted sum of squares
};

PoseGraphSummary OptimizePoseGraph(PoseGraph& graph, const PoseGraphOptions& options = {});

// Returns the error of one edge; with `by_from` and `by_to` also its derivatives.
Eigen::Matrix<double, 7, 1> PoseGraphError(const PoseGraphEdge& edge, const Similarity3& from,
                                           const Similarity3& to, double unit,
                                           Eigen::Matrix<double, 7, 7>* by_from = nullptr,
                                           Eigen::Matrix<double, 7, 7>* by_to = nullptr);

}  // namespace ulf::tracking
