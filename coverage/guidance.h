// Where to move next. The coverage map knows what is missing; guidance turns that into one place to go to,
// how far away to stay, and how long it will take. (Beyond the thesis, which shows the map and leaves the
// rest to the operator; its section 2.2 says what is hard: the offset from the previous scan line, and the
// distance.)
//
// Directions are unit vectors from the subject's centre in world coordinates; angles are radians.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace ulf {

struct Guidance {
  // The viewpoint to fill next lies in this direction; none: nothing is missing, or nothing is known yet.
  std::optional<Eigen::Vector3d> toward;
  double distance = 0;     // to keep from the subject's centre, world units; 0: not known yet
  double disc_radius = 0;  // what one view covers around it at that distance
  // How far the present movement keeps from the row beside it that was scanned before, and how far it may;
  // none without such a row.
  struct RowOffset {
    double now = 0, wanted = 0;
  };
  std::optional<RowOffset> row;
  // What the present movement, kept up, passes by and leaves uncovered between itself and what is covered.
  std::vector<Eigen::Vector3d> left_open;
  std::optional<double> views_left,
      seconds_left;  // expected; none without a cap or before any speed is known
};

}  // namespace ulf
