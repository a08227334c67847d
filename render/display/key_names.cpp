#include "render/display/key_names.h"

#include <fmt/format.h>
#include <map>
#include <sstream>

#include "core/base/error.h"

namespace ulf::render {
namespace {

InputEvent KeyFromName(const std::string& name) {
  static const std::map<std::string, Key> kKeys{{"Left", Key::kLeft},
                                                {"Right", Key::kRight},
                                                {"Up", Key::kUp},
                                                {"Down", Key::kDown},
                                                {"PageUp", Key::kPageUp},
                                                {"PageDown", Key::kPageDown},
                                                {"PgUp", Key::kPageUp},
                                                {"PgDn", Key::kPageDown},
                                                {"Home", Key::kHome},
                                                {"Enter", Key::kEnter},
                                                {"Escape", Key::kEscape},
                                                {"Esc", Key::kEscape},
                                                {"Backspace", Key::kBackspace},
                                                {"Delete", Key::kDelete},
                                                {"F1", Key::kF1},
                                                {"F11", Key::kF11}};
  constexpr char kShift[] = "Shift+";
  if (name.size() == 1) return Typed{static_cast<unsigned char>(name.front())};
  if (name == "comma") return Typed{U','};
  if (name == "Space") return Typed{U' '};
  const bool shift = name.starts_with(kShift);
  const auto key = kKeys.find(shift ? name.substr(sizeof kShift - 1) : name);
  if (key == kKeys.end())
    throw Refusal("there is no key", fmt::format("'{}'", name), "",
                  "there are single characters, comma, Space, and Left, Right, Up, Down, PageUp, PageDown, "
                  "Home, Enter, "
                  "Escape, Backspace, Delete, F1, F11, also with Shift+");
  return KeyPressed{key->second, shift};
}

}  // namespace

std::vector<InputEvent> KeysFromNames(const std::string& names) {
  std::vector<InputEvent> keys;
  std::istringstream stream(names);
  for (std::string name; std::getline(stream, name, ',');) keys.push_back(KeyFromName(name));
  return keys;
}

}  // namespace ulf::render
