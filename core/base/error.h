// Errors that a person reads. The text names the thing, what is wrong with it, and what to do.
// Outcomes that belong to normal work (tracking lost, view rejected, frame dropped) are values, never errors.
#pragma once

#include <fmt/core.h>

#include <stdexcept>
#include <string>
#include <utility>

namespace ulf {

// The work could not be done: a file, a device, the data. Exit status 1.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
  template <typename... Args>
  explicit Error(fmt::format_string<Args...> format, Args&&... args)
      : std::runtime_error(fmt::format(format, std::forward<Args>(args)...)) {}
};

// The command line or an option asks for something impossible. Exit status 2.
class UsageError : public Error {
 public:
  using Error::Error;
};

// The disk or the user's quota is full. What was being written has been removed; it can be written again when
// there is room.
class DiskFullError : public Error {
 public:
  using Error::Error;
};

}  // namespace ulf
