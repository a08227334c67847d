// Calls Aravis and handles its GError. Only the aravis_* files include this header.
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

// Returns the reason why the call failed; none: it did not.
template <typename Call, typename... Arguments>
std::optional<std::string> FailureOf(Call&& call, Arguments... arguments) {
  GError* error = nullptr;
  call(arguments..., &error);
  if (!error) return std::nullopt;
  const std::string reason = error->message;
  g_clear_error(&error);
  return reason;
}

// Turns a failure into an Error: "aravis:ID: WHAT: reason".
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

// Returns none on failure: for features that a camera may lack.
template <typename Call, typename... Arguments>
auto TryCall(Call&& call, Arguments... arguments) {
  std::optional<std::invoke_result_t<Call, Arguments..., GError**>> result;
  if (FailureOf([&](GError** error) { result = call(arguments..., error); })) result.reset();
  return result;
}

inline std::string Text(const char* text) { return text ? text : ""; }

// Returns the names that `call` returns as an array of its own, with their number; empty on failure.
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
