// Errors that reach a person. The text names the thing, what is wrong with it, and the way out.
// Outcomes that belong to the work (tracking lost, view rejected, frame dropped) are values, never errors.
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

// The command was asked in a way it cannot serve. Exit status 2.
class UsageError : public Error {
 public:
  using Error::Error;
};

// No room on the disk, or none left of the user's share. What was being written has been taken back; it can
// be written again when there is room.
class DiskFullError : public Error {
 public:
  using Error::Error;
};

}  // namespace ulf
