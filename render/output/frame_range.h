// Which pictures of a path are rendered: a number of them, or a part of all, so that several machines can
// share the work.
#pragma once

#include <optional>
#include <string>

namespace ulf::render {

struct FrameRange {
  int count = 0;  // pictures of the whole path; 0: the path's own number
  int first = 0;
  std::optional<int> end = {};  // one past the last; none: all
  bool operator==(const FrameRange&) const = default;
};

// "N": a path of N pictures; "A:B": the pictures A to B - 1, counted from 0, where A or B may be left out;
// "A:B/N": both. Throws Refusal.
FrameRange ParseFrames(const std::string& text);

}  // namespace ulf::render
