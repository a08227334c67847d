// Calls Aravis and handles its GError. Only acquisition/aravis/ may include this header, because of arv.h.
//
// `call` is a function of the library that takes `arguments` and then a GError**.
#pragma once

#include <arv.h>

#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "core/base/error.h"

namespace ulf::acquisition {

// Returns why the call failed; none if it succeeded.
template <typename Call, typename... Arguments>
std::optional<std::string> FailureOf(Call&& call, Arguments... arguments) {
  GError* error = nullptr;
  call(arguments..., &error);
  if (!error) return std::nullopt;
  const std::string reason = error->message;
  g_clear_error(&error);
  return reason;
}

// Returns the result of the call. Throws Error "WHO: WHAT: reason" if it fails; `who` is the URI.
template <typename Call, typename... Arguments>
auto CallOrThrow(const std::string& who, const std::string& what, Call&& call, Arguments... arguments) {
  using Result = std::invoke_result_t<Call, Arguments..., GError**>;
  std::conditional_t<std::is_void_v<Result>, std::nullptr_t, Result> result{};
  const auto failure = FailureOf([&](GError** error) {
    if constexpr (std::is_void_v<Result>)
      call(arguments..., error);
    else
      result = call(arguments..., error);
  });
  if (failure) throw Error("{}: {}: {}", who, what, *failure);
  if constexpr (!std::is_void_v<Result>) return result;
}

// Returns the result of the call; none if it fails, because a camera may lack the feature.
template <typename Call, typename... Arguments>
auto TryCall(Call&& call, Arguments... arguments) {
  std::optional<std::invoke_result_t<Call, Arguments..., GError**>> result;
  if (FailureOf([&](GError** error) { result = call(arguments..., error); })) result.reset();
  return result;
}

inline std::string Text(const char* text) { return text ? text : ""; }

// Returns copies of the names that `call(arguments..., guint* count, GError**)` returns; empty if it fails.
// Frees the array of `call` but not its strings (GLib's "transfer container").
template <typename Call, typename... Arguments>
std::vector<std::string> CallForNames(Call&& call, Arguments... arguments) {
  guint count = 0;
  const char** names = TryCall(call, arguments..., &count).value_or(nullptr);
  if (!names) return {};
  std::vector<std::string> copy(names, names + count);
  g_free(names);
  return copy;
}

}  // namespace ulf::acquisition
