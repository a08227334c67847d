// What --help, the man pages and the completion tell of options and keys beside CLI11's own.
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <span>
#include <string>

#include "render/display/plain_panels.h"

namespace ulf::commands {

// The values that an option knows by name, as "auto,plane,plane:SHARE,FILE": completion offers those in small letters
// alone, and files where FILE stands last. Nothing is checked: other values are free text.
inline CLI::Option* Knows(CLI::Option* option, const std::string& values) {
  return option->type_name("TEXT:{" + values + "}");
}

// For a footer: a line for each key.
inline std::string KeyLines(std::span<const render::KeyHelp> keys) {
  constexpr int kColumn = 26;
  std::string lines;
  for (const render::KeyHelp& help : keys)
    lines += fmt::format("\n  {:<{}}{}", help.keys, kColumn, help.what);
  return lines;
}

inline constexpr char kKnownFields[] = "auto,subdivision,linear,lumigraph,lumigraph-per-pixel,soft,nearest";
inline constexpr char kKnownProxies[] = "auto,plane,plane:SHARE,plane:fitted,planes,points,mesh,soft,FILE";

}  // namespace ulf::commands
