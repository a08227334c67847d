// URIs that name cameras and pose sources with options, as the command line takes them:
// `scheme:path?key=value&key=value`. Nothing in them is percent-encoded.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace ulf {

struct DeviceUri {
  std::string scheme;
  std::string path;
  std::vector<std::pair<std::string, std::string>> options;

  // Throws Refusal if there is no scheme, or an option has no key or no "=".
  static DeviceUri Parse(const std::string& uri);
  // These return the value of an option; if it is not given, nullopt or `otherwise`. Number() and Whole()
  // throw Refusal if it is no finite number, or no whole one, or not from `least` to `most`.
  std::optional<std::string> Option(const std::string& key) const;
  std::optional<double> Number(const std::string& key) const;
  double Number(const std::string& key, double otherwise, double least, double most) const;
  std::optional<int> Whole(const std::string& key, int least, int most) const;
  // Gives the option this value, replacing an earlier one.
  void Set(const std::string& key, const std::string& value);
  // Throws Refusal naming the first option that is not in `known`.
  void AllowOnly(const std::vector<std::string>& known) const;
  // Returns the whole URI.
  std::string Text() const;
};

}  // namespace ulf
