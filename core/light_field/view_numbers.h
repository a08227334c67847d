// Names several views in a short text.
#pragma once

#include <map>
#include <set>
#include <string>

namespace ulf {

// "view 7", "views 3, 5 to 9 and 12"; of many runs the first ones and the number of the rest. Empty for no
// view.
std::string ViewNumbers(const std::set<int>& ids);

// The same for the keys of a map.
template <typename Value>
std::string ViewNumbers(const std::map<int, Value>& by_id) {
  std::set<int> ids;
  for (const auto& [id, value] : by_id) ids.insert(id);
  return ViewNumbers(ids);
}

}  // namespace ulf
