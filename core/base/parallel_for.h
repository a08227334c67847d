// A loop over all processors.
#pragma once

#include <cstddef>
#include <opencv2/core/utility.hpp>

namespace ulf {

// Calls each(0) to each(count - 1) in several threads, in any order. `stripes`: into how many parts the loop
// is divided; 0: one for each index.
template <typename Each>
void ParallelFor(std::size_t count, const Each& each, double stripes = 0) {
  cv::parallel_for_(
      cv::Range(0, static_cast<int>(count)),
      [&](const cv::Range& range) {
        for (int i = range.start; i < range.end; ++i) each(static_cast<std::size_t>(i));
      },
      stripes > 0 ? stripes : static_cast<double>(count));
}

}  // namespace ulf
