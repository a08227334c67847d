// The order of file names that compares numbers by value: frame_2 before frame_10.
#pragma once

#include <string>

namespace ulf {

bool NameOrder(const std::string& a, const std::string& b);

}  // namespace ulf
