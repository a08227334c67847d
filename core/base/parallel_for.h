// Runs a loop over all processors.
#pragma once

#include <atomic>
#include <cstddef>
#include <opencv2/core/utility.hpp>

namespace ulf {

// Calls each(0) to each(count - 1) in several threads, in any order, and returns when all calls have. Throws
// what a call threw. The loop is divided into `stripes` parts; 0 means one for each index.
template <typename Each>
void ParallelFor(std::size_t count, const Each& each, double stripes = 0) {
  // OpenCV starts and joins threads in a way that the thread sanitizer cannot see; it sees this counter.
  std::atomic<std::size_t> parts = 0;
  parts.store(1, std::memory_order_release);
  cv::parallel_for_(
      cv::Range(0, static_cast<int>(count)),
      [&](const cv::Range& range) {
        parts.load(std::memory_order_acquire);
        for (int i = range.start; i < range.end; ++i) each(static_cast<std::size_t>(i));
        parts.fetch_add(1, std::memory_order_release);
      },
      stripes > 0 ? stripes : static_cast<double>(count));
  parts.load(std::memory_order_acquire);
}

}  // namespace ulf
