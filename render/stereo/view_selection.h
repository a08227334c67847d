// Which views get a depth map, and which others each of them is compared with.
#pragma once

#include <vector>

#include "core/light_field/light_field.h"
#include "render/stereo/stereo_view.h"

namespace ulf::render {

struct NeighbourOptions {
  int count = 8;
  // Between lines of sight to the subject: less gives no depth, more looks different.
  double wanted_parallax = 8 * M_PI / 180;
  double most_parallax = 45 * M_PI / 180;
};

// Up to options.count others, best first: with a good parallax, that see what this one sees, spread around
// it. Views at this one's place are no neighbours. May be empty.
std::vector<int> NeighboursOf(int view, const std::vector<StereoView>& views, const Subject& subject,
                              const NeighbourOptions& options);

// Up to `count` views, spread as evenly as they can be; all when there are no more. In ascending order.
std::vector<int> SpreadViews(const std::vector<StereoView>& views, const Subject& subject, int count);

}  // namespace ulf::render
