// Words of shells: of commands in messages, so that a reader can copy the command, and of the completions of
// bash and zsh.
#pragma once

#include <string>
#include <string_view>

namespace ulf {

// The word itself, or in double quotes where a shell would split it: `ulf repair "my vase"`.
inline std::string ShellWord(std::string_view word) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./:=,@%+-";
  // Bytes of other scripts mean nothing to a shell.
  const auto plain = [&](char c) { return (c & 0x80) != 0 || kPlain.find(c) != std::string_view::npos; };
  bool all_plain = !word.empty();
  std::string quoted = "\"";
  for (const char c : word) {
    all_plain = all_plain && plain(c);
    if (c == '"' || c == '\\' || c == '$' || c == '`') quoted += '\\';
    quoted += c;
  }
  return all_plain ? std::string(word) : quoted + '"';
}

}  // namespace ulf
