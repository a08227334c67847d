// Finds the poses that agree best with measured relative poses (Strasdat, Montiel and Davison 2010), which
// spreads the error of a closed loop over the way that led to it.
//
// A node is a similarity cam_from_world, because scale drifts as position does while nothing metric is in
// sight. An edge is a measurement of to_from_from. Its error measured^-1 * to * from^-1 counts as rotation
// vector (radians), translation (over `unit`, so that it is an angle, too) and logarithm of the scale.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/geometry/similarity3.h"

namespace ulf::tracking {

struct PoseGraphEdge {
  int from = 0, to = 0;      // indices of nodes
  Similarity3 to_from_from;  // as measured
  double weight = 1;         // of the squared error
};

struct PoseGraph {
  std::vector<Similarity3> cam_from_world;
  std::vector<bool> fixed;  // by node; if none is, the first is fixed
  std::vector<PoseGraphEdge> edges;
};

struct PoseGraphOptions {
  bool rigid = false;  // all scales stay as they are
  double unit = 1;     // a typical depth, world units
};

struct PoseGraphSummary {
  bool usable = false;                      // if not, the graph is unchanged
  double initial_cost = 0, final_cost = 0;  // half the weighted sum of squared errors
};

PoseGraphSummary OptimizePoseGraph(PoseGraph& graph, const PoseGraphOptions& options = {});

// Returns the error of one edge: rotation, translation, scale. Sets `by_from` and `by_to`, unless null, to
// its derivatives by a small similarity (rotation, translation, log of the scale) on the left of a node.
Eigen::Matrix<double, 7, 1> PoseGraphError(const PoseGraphEdge& edge, const Similarity3& from,
                                           const Similarity3& to, double unit,
                                           Eigen::Matrix<double, 7, 7>* by_from = nullptr,
                                           Eigen::Matrix<double, 7, 7>* by_to = nullptr);

}  // namespace ulf::tracking
