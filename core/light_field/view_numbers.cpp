#include "core/light_field/view_numbers.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

namespace ulf {

std::string ViewNumbers(const std::set<int>& ids) {
  constexpr std::size_t kMostRuns = 6;  // more are summed up as "and N more"
  std::vector<std::pair<int, int>> runs;
  for (auto id = ids.begin(); id != ids.end();) {
    const int first = *id;
    int last = first;
    for (++id; id != ids.end() && *id == last + 1; ++id) last = *id;
    const bool is_pair = last == first + 1;  // "3, 4" rather than "3 to 4"
    runs.emplace_back(first, is_pair ? first : last);
    if (is_pair) runs.emplace_back(last, last);
  }
  if (runs.empty()) return "";
  std::string words;
  std::size_t named = 0;
  const std::size_t shown = runs.size() <= kMostRuns ? runs.size() : kMostRuns - 1;
  for (std::size_t i = 0; i < shown; ++i) {
    const auto [first, last] = runs[i];
    if (i > 0) words += i + 1 == runs.size() ? " and " : ", ";
    words += first == last ? fmt::format("{}", first) : fmt::format("{} to {}", first, last);
    named += static_cast<std::size_t>(last - first) + 1;
  }
  if (shown < runs.size()) words += fmt::format(" and {} more", ids.size() - named);
  return fmt::format("{} {}", ids.size() == 1 ? "view" : "views", words);
}

}  // namespace ulf
