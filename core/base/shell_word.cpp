#include "core/base/shell_word.h"

namespace ulf {

std::string ShellWord(std::string_view word) {
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
