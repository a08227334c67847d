#include "core/base/device_uri.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "core/base/error.h"
#include "core/base/shell_word.h"

namespace ulf {

namespace {

// A path that exists is given more often than the scheme is forgotten for another reason.
std::string RemedyFor(const std::string& given) {
  namespace fs = std::filesystem;
  std::error_code unknown;
  if (fs::is_character_file(given, unknown)) return "write v4l2:" + given;
  if (fs::is_regular_file(given, unknown)) return "write " + ShellWord("replay:" + given);
  if (fs::is_directory(given, unknown))
    return fmt::format(
        "write {} for pictures that a moving camera took one after another ('ulf import {} {} -o DIR' "
        "poses photographs in any order)",
        ShellWord("replay:" + given), ShellWord(given), Parameter("pose"));
  return "use sim:studio, replay:PATH or aravis:ID (see 'ulf devices')";
}

}  // namespace

DeviceUri DeviceUri::Parse(const std::string& uri) {
  const std::size_t colon = uri.find(':');
  if (colon == std::string::npos || colon == 0)
    throw Refusal("", uri, fmt::format("'{}' is not a device URI", uri), RemedyFor(uri));
  DeviceUri parsed;
  parsed.scheme = uri.substr(0, colon);
  const std::size_t question = uri.find('?', colon);
  parsed.path = uri.substr(colon + 1, question == std::string::npos ? question : question - colon - 1);
  if (question == std::string::npos) return parsed;
  std::istringstream pairs(uri.substr(question + 1));
  for (std::string pair; std::getline(pairs, pair, '&');) {
    const std::size_t equals = pair.find('=');
    if (equals == std::string::npos || equals == 0)
      throw Refusal("", pair, fmt::format("'{}' in '{}' is not an option", pair, uri), "write key=value");
    parsed.options.emplace_back(pair.substr(0, equals), pair.substr(equals + 1));
  }
  return parsed;
}

std::optional<std::string> DeviceUri::Option(const std::string& key) const {
  for (const auto& [name, value] : options)
    if (name == key) return value;
  return std::nullopt;
}

std::optional<double> DeviceUri::Number(const std::string& key) const {
  const auto text = Option(key);
  if (!text) return std::nullopt;
  char* end = nullptr;
  const double number = std::strtod(text->c_str(), &end);
  if (text->empty() || *end != '\0' || !std::isfinite(number))
    throw Refusal("'" + Text() + "'", "", fmt::format("{} must be a number, not '{}'", key, *text), "");
  return number;
}

double DeviceUri::Number(const std::string& key, double otherwise, double least, double most) const {
  const double number = Number(key).value_or(otherwise);
  if (number < least || number > most)
    throw Refusal("'" + Text() + "'", "",
                  fmt::format("{} must be from {:g} to {:g}, not {:g}", key, least, most, number), "");
  return number;
}

std::optional<int> DeviceUri::Whole(const std::string& key, int least, int most) const {
  const auto number = Number(key);
  if (!number) return std::nullopt;
  if (*number < least || *number > most || *number != std::floor(*number))
    throw Refusal("'" + Text() + "'", "",
                  fmt::format("{} must be a whole number from {} to {}", key, least, most), "");
  return static_cast<int>(*number);
}

void DeviceUri::Set(const std::string& key, const std::string& value) {
  std::erase_if(options, [&](const auto& option) { return option.first == key; });
  options.emplace_back(key, value);
}

void DeviceUri::AllowOnly(const std::vector<std::string>& known) const {
  for (const auto& [name, value] : options)
    if (std::ranges::find(known, name) == known.end())
      throw Refusal("", name, fmt::format("'{}' has no option '{}'", Text(), name),
                    known.empty() ? "leave it out" : fmt::format("known are: {}", fmt::join(known, ", ")));
}

std::string DeviceUri::Text() const {
  std::string text = scheme + ":" + path;
  for (std::size_t i = 0; i < options.size(); ++i)
    text += (i == 0 ? "?" : "&") + options[i].first + "=" + options[i].second;
  return text;
}

}  // namespace ulf
