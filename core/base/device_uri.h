// URIs that name cameras and pose sources with options, as the command line takes them:
// `scheme:path?key=value&key=value`.
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

  static DeviceUri Parse(const std::string& uri);  // throws Refusal
  std::optional<std::string> Option(const std::string& key) const;
  // The option as a finite number; throws Refusal naming it when it is something else.
  std::optional<double> Number(const std::string& key) const;
  // Does the same but returns `otherwise` if it is not given; throws Refusal if it is not within `least` to
  // `most`.
  double Number(const std::string& key, double otherwise, double least, double most) const;
  // The option as a whole number from `least` to `most`; none if it is not given. Throws Refusal.
  std::optional<int> Whole(const std::string& key, int least, int most) const;
  // Gives the option this value, replacing an earlier one.
  void Set(const std::string& key, const std::string& value);
  // Throws Refusal naming the first option that is not in `known`.
  void AllowOnly(const std::vector<std::string>& known) const;
  std::string Text() const;
};

}  // namespace ulf
