// Maps the keys of one mode of the display to actions.
#pragma once

#include <functional>
#include <initializer_list>
#include <utility>

namespace ulf::coverage {

template <typename Key>
using KeyActions = std::initializer_list<std::pair<Key, std::function<void()>>>;

// Runs the action of `key`; returns false when it has none.
template <typename Key>
bool RunAction(const Key& key, const std::type_identity_t<KeyActions<Key>>& actions) {
  for (const auto& [each, act] : actions) {
    if (each != key) continue;
    act();
    return true;
  }
  return false;
}

}  // namespace ulf::coverage
