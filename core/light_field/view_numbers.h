// Several views named in a few words.
#pragma once

#include <set>
#include <string>

namespace ulf {

// "view 7", "views 3, 5 to 9 and 12"; of more than a few runs the first ones and how many more there are.
// Empty for no view.
std::string ViewNumbers(const std::set<int>& ids);

}  // namespace ulf
