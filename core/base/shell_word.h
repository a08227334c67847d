// Commands in messages, as a reader can copy them into a shell.
#pragma once

#include <string>
#include <string_view>

namespace ulf {

// The word as it is, or in double quotes where a shell would take it apart: `ulf repair "my vase"`.
std::string ShellWord(std::string_view word);

}  // namespace ulf
