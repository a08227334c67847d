#include "render/output/frame_range.h"

#include <fmt/format.h>
#include <charconv>

#include "core/base/error.h"

namespace ulf::render {
namespace {

int Number(std::string_view digits, const std::string& text, int least) {
  int number = -1;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (error != std::errc() || end != digits.data() + digits.size() || number < least)
    throw Refusal(Parameter("frames"), text,
                  "give N pictures, or A:B for pictures A to B - 1 of the path, or A:B/N", "");
  return number;
}

}  // namespace

FrameRange ParseFrames(const std::string& text) {
  FrameRange range;
  if (text.empty()) return range;
  std::string_view rest = text;
  const auto colon = rest.find(':'), slash = rest.find('/');
  if (colon == std::string_view::npos) {
    range.count = Number(rest, text, 1);
    return range;
  }
  if (slash != std::string_view::npos) {
    range.count = Number(rest.substr(slash + 1), text, 1);
    rest = rest.substr(0, slash);
  }
  const std::string_view first = rest.substr(0, colon),
                         end = colon < rest.size() ? rest.substr(colon + 1) : std::string_view();
  if (!first.empty()) range.first = Number(first, text, 0);
  if (!end.empty()) range.end = Number(end, text, 0);
  if (range.end && *range.end <= range.first)
    throw Refusal(Parameter("frames"), text,
                  fmt::format("picture {} does not come before {}", range.first, *range.end),
                  "A:B are pictures A to B - 1");
  return range;
}

}  // namespace ulf::render
