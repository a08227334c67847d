// Words of shells: of commands in messages, so that a reader can copy the command, and of the completions of bash and zsh.
#pragma once

#include <string>
#include <string_view>

namespace ulf {

// The word itself, or in double quotes where a shell would split it: `ulf repair "my vase"`.
std::string ShellWord(std::string_view word);

}  // namespace ulf
