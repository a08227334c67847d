// Notices that the asked cap fills no more although the camera goes on moving round the subject: what is left
// may be out of reach (a wall, the floor, an arm's length), and whoever waits for the whole cap waits for
// ever. Says it once, with what is open and which smaller cap is there.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "coverage/bound/coverage_map.h"

namespace ulf::coverage {

class CapWatch {
 public:
  // `share` of the cap ends the capture.
  explicit CapWatch(double share) : share_(share) {}
  // After every frame with a pose. `would_record`: nothing but coverage decided whether it became a view (not
  // a pause, a full disk, blur): only then movement without a gain counts. Words for the operator, at most
  // once between two gains.
  std::optional<std::string> After(const CoverageMap& map, const Eigen::Vector3d& center_in_world,
                                   bool would_record);

 private:
  const double share_;
  double most_covered_ = 0;
  std::optional<Eigen::Vector3d> from_;  // where the present step began
  double way_ = 0;                       // moved since something was gained, radians
  bool said_ = false;
};

// The largest cap of the same shape and middle, in whole degrees, of which at least `share` is covered; none:
// not even one of a degree.
std::optional<Cap> LargestCovered(const CoverageMap& map, double share);

}  // namespace ulf::coverage
