// Errors that a person reads. The text names the thing, what is wrong with it, and what to do.
// Outcomes that belong to normal work (tracking lost, view rejected, frame dropped) are values, never errors.
#pragma once

#include <fmt/core.h>

#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace ulf {

// The work could not be done because of a file, a device or the data. The exit status is 1.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
  template <typename... Args>
  explicit Error(fmt::format_string<Args...> format, Args&&... args)
      : std::runtime_error(fmt::format(format, std::forward<Args>(args)...)) {}
};

// A caller's request cannot be met: a parameter has an impossible value, or two contradict each other. The
// text is "WHAT VALUE: WHY; REMEDY", without the parts that are empty. The exit status is 2.
class Refusal : public Error {
 public:
  // `what` is the parameter, as Parameter() spells it, or the thing that was named (a device URI, a file);
  // `value` what was given for it, or empty; `why` what is wrong; `remedy` what to do, or empty if `why` says
  // it. Without `what` the text is "WHY; REMEDY", where `why` quotes the value.
  Refusal(const std::string& what, const std::string& value, const std::string& why,
          const std::string& remedy);
};

// Returns the name of a parameter for texts of errors, warnings and hints: "no_subject", its name in the
// API, unless a program has set its own spelling (the command line writes "--no-subject").
std::string Parameter(std::string_view name);

// Sets how Parameter() spells names in this process. Call it once, before other threads begin.
void SpellParameters(std::string (*spell)(std::string_view name));

// The disk or the user's quota is full. What was being written is removed; the caller may try again later.
class DiskFullError : public Error {
 public:
  using Error::Error;
};

}  // namespace ulf
