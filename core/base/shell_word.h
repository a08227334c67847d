// Quotes words for shells: in commands that messages show for copying, and in completions of bash and zsh.
#pragma once

#include <string>
#include <string_view>

namespace ulf {

// Returns the word, in double quotes if a shell would split or interpret it: `ulf repair "my vase"`. A word
// with an exclamation mark gets single quotes, because interactive shells interpret that in double quotes.
inline std::string ShellWord(std::string_view word) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./:=,@%+-";
  // A shell gives no meaning to bytes beyond ASCII.
  const auto plain = [&](char c) { return (c & 0x80) != 0 || kPlain.find(c) != std::string_view::npos; };
  const bool in_single = word.find('!') != std::string_view::npos;
  bool all_plain = !word.empty();
  std::string quoted(1, in_single ? '\'' : '"');
  for (const char c : word) {
    all_plain = all_plain && plain(c);
    if (in_single)
      quoted += c == '\'' ? "'\\'" : "";
    else if (c == '"' || c == '\\' || c == '$' || c == '`')
      quoted += '\\';
    quoted += c;
  }
  return all_plain ? std::string(word) : quoted + quoted.front();
}

}  // namespace ulf
