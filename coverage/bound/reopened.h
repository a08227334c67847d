// What was covered and is not any more, because poses were corrected or views taken back, until it is covered
// again.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "coverage/bound/coverage_map.h"

namespace ulf::coverage {

class Reopened {
 public:
  // Takes what `before` covers and `now` does not; tells how much that is, as a share of the cap (without
  // one, of what was covered).
  double Note(const CoverageMap& before, const CoverageMap& now);
  void Forget() { directions_.clear(); }
  // A view more: what it covers is closed again.
  void DropCovered(const CoverageMap& now);
  const std::vector<Eigen::Vector3d>& directions() const { return directions_; }

 private:
  std::vector<Eigen::Vector3d> directions_;
};

}  // namespace ulf::coverage
