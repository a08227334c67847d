// What is opened by name, with options: cameras, and poses from outside.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace ulf {

// A device URI taken apart: `scheme:path?key=value&key=value`.
struct DeviceUri {
  std::string scheme;
  std::string path;
  std::vector<std::pair<std::string, std::string>> options;

  static DeviceUri Parse(const std::string& uri);  // throws UsageError
  std::optional<std::string> Option(const std::string& key) const;
  // The option as a finite number; throws UsageError naming it when it is something else.
  std::optional<double> Number(const std::string& key) const;
  // In place of what the URI says of it.
  void Set(const std::string& key, const std::string& value);
  // Throws UsageError naming the first option that is not in `known`.
  void AllowOnly(const std::vector<std::string>& known) const;
  std::string Text() const;
};

}  // namespace ulf
