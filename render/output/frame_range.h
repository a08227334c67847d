// Which pictures of a path are to be rendered: a number of them, or a part of all, so that several machines
// can share the work.
#pragma once

#include <optional>
#include <string>

namespace ulf::render {

struct FrameRange {
  int count = 0;  // of the whole path, where the path does not say; 0: as is usual
  int first = 0;
  std::optional<int> end = {};  // one past the last; none: all
  bool operator==(const FrameRange&) const = default;
};

// "N": a path of N pictures; "A:B": of all pictures A to B - 1, counted from 0, either may be left out;
// "A:B/N": both. Throws UsageError.
FrameRange ParseFrames(const std::string& text);

}  // namespace ulf::render
