#include "coverage/measured/cover_by.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

#include "core/base/error.h"

namespace ulf::coverage {
namespace {

constexpr std::array<std::pair<const char*, CoverBy>, 3> kNames{
    {{"bound", CoverBy::kBound}, {"measured", CoverBy::kMeasured}, {"both", CoverBy::kBoth}}};

}  // namespace

const char* Name(CoverBy by) {
  return std::ranges::find(kNames, by, &std::pair<const char*, CoverBy>::second)->first;
}

CoverBy CoverByNamed(const std::string& name) {
  const auto known = std::ranges::find_if(kNames, [&](const auto& each) { return name == each.first; });
  return known == kNames.end() ? CoverBy::kBound : known->second;
}

CoverGoal CoverGoal::Parse(const std::string& text) {
  const std::size_t colon = text.find(':');
  const std::string name = text.substr(0, colon);
  const auto known = std::ranges::find_if(kNames, [&](const auto& each) { return name == each.first; });
  if (known == kNames.end())
    throw Refusal(Parameter("cover"), text,
                  "it must be bound, measured or both, the last two with a quality such as measured:35 (dB)",
                  "");
  CoverGoal goal;
  goal.by = known->second;
  if (colon == std::string::npos) return goal;
  if (goal.by == CoverBy::kBound)
    throw Refusal(Parameter("cover"), text,
                  fmt::format("the bound's quality is {} or {}, not a number of dB",
                              Parameter("threshold_px"), Parameter("quality")),
                  "");
  const char *begin = text.data() + colon + 1, *end = text.data() + text.size();
  constexpr double kLeast_db = 10, kMost_db = 50;
  const auto [rest, error] = std::from_chars(begin, end, goal.db);
  if (error != std::errc() || rest != end || !(goal.db >= kLeast_db && goal.db <= kMost_db))
    throw Refusal(Parameter("cover"), text,
                  fmt::format("the quality must be {:g} to {:g} dB", kLeast_db, kMost_db), "");
  return goal;
}

}  // namespace ulf::coverage
