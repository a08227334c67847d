#include "coverage/bound/reopened.h"

namespace ulf::coverage {

double Reopened::Note(const CoverageMap& before, const CoverageMap& now) {
  DropCovered(now);
  double open_sr = 0, covered_sr = 0;
  before.ForEachCell([&](const CoverageMap::CellView& cell) {
    if (cell.covering.index < 0) return;
    covered_sr += cell.solid_angle_sr;
    // Where the cap itself moved with its first view, what it leaves behind is not missing.
    const auto at = now.views().empty() ? CoveringView{} : now.At(cell.direction);
    if (!at || at->index >= 0) return;
    open_sr += cell.solid_angle_sr;
    directions_.push_back(cell.direction);
  });
  const double whole_sr = before.options().cap ? before.extent().SolidAngle() : covered_sr;
  return whole_sr > 0 ? open_sr / whole_sr : 0;
}

void Reopened::DropCovered(const CoverageMap& now) {
  std::erase_if(directions_, [&](const Eigen::Vector3d& direction) {
    if (now.views().empty()) return false;
    const auto at = now.At(direction);
    return !at || at->index >= 0;
  });
}

}  // namespace ulf::coverage
