// Calls Aravis and handles its GError. Only acquisition/aravis/ may include this header, because of arv.h.
#pragma once

#include <arv.h>

#include <string>
#include <type_traits>
#include <vector>

#include "core/base/error.h"

namespace ulf::acquisition {

// Returns the result of `call(GError**)`. Throws Error "WHO: WHAT: reason" if it fails; `who` is the URI.
template <typename Call>
auto CallOrThrow(const std::string& who, const std::string& what, Call&& call) {
  GError* error = nullptr;
  const auto check = [&] {
    if (!error) return;
    const std::string reason = error->message;
    g_clear_error(&error);
    throw Error("{}: {}: {}", who, what, reason);
  };
  if constexpr (std::is_void_v<decltype(call(&error))>) {
    call(&error);
    check();
  } else {
    auto result = call(&error);
    check();
    return result;
  }
}

// Returns the result of `call(GError**)`, or `otherwise` if it fails, because a camera may lack the feature.
template <typename Call, typename Value>
Value CallOr(Call&& call, Value otherwise) {
  GError* error = nullptr;
  const auto result = call(&error);
  if (!error) return static_cast<Value>(result);
  g_clear_error(&error);
  return otherwise;
}

template <typename Call>
void CallIgnoringErrors(Call&& call) {
  GError* error = nullptr;
  call(&error);
  g_clear_error(&error);
}

inline std::string Text(const char* text) { return text ? text : ""; }

// Returns copies of the names that `call(guint* count, GError**)` returns; empty if it fails. Frees the array
// of `call` but not its strings (GLib's "transfer container").
template <typename Call>
std::vector<std::string> CallForNames(Call&& call) {
  guint count = 0;
  const char** names =
      CallOr([&](GError** e) { return call(&count, e); }, static_cast<const char**>(nullptr));
  if (!names) return {};
  std::vector<std::string> copy(names, names + count);
  g_free(names);
  return copy;
}

}  // namespace ulf::acquisition
