// A line of text from a program that sends poses (pose_stream.h has the forms).
#pragma once

#include <optional>
#include <string>
#include <variant>

#include "core/geometry/rigid3.h"

namespace ulf::tracking {

struct SentPose {
  double time_s = 0;  // by the sender's clock
  Rigid3 world_from_tool;
};
struct SentSync {
  double sender_s = 0;
};
struct SentOffset {
  double offset_s = 0;  // our clock minus the sender's
};
struct SentComment {};  // or an empty line
using SentLine = std::variant<SentComment, SentPose, SentSync, SentOffset>;

// `line`: without its end. None: it is no such line, or a number in it is not finite.
std::optional<SentLine> ReadSentLine(const std::string& line);

}  // namespace ulf::tracking
