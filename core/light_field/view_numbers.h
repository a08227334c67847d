// Names several views in a short text.
#pragma once

#include <set>
#include <string>

namespace ulf {

// "view 7", "views 3, 5 to 9 and 12"; of many runs the first ones and the number of the rest. Empty for no
// view.
std::string ViewNumbers(const std::set<int>& ids);

}  // namespace ulf
