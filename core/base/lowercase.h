// Converts ASCII letters to lower case, for endings of file names and names of settings; other bytes stay.
#pragma once

#include <string>

namespace ulf {

inline std::string Lowercase(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

}  // namespace ulf
