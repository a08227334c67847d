#include "acquisition/device/features.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <numeric>

#include "core/base/error.h"
#include "core/base/lowercase.h"

namespace ulf::acquisition {
namespace {

// A number may exceed a limit by this share: rounding of limits that the camera computes.
constexpr double kRangeRounding = 1e-9;
// Whole numbers below this are exact in a double.
constexpr double kLargestExactInteger = 9e15;
// Two floats closer than this share are the same value: cameras keep floats in 32 bits.
constexpr double kSingleRounding = 1e-5;
// A name that contains the wrong word, or is contained in it, ranks as one with so many spelling mistakes.
// Guessed.
constexpr std::size_t kContainedRank = 2;

// Levenshtein's distance.
std::size_t EditDistance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row[b.size()];
}

std::optional<double> ParseDouble(const std::string& text) {
  char* end = nullptr;
  const double number = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0' || !std::isfinite(number)) return std::nullopt;
  return number;
}

std::optional<long long> ParseInteger(const std::string& text) {
  const bool hexadecimal = text.starts_with("0x") || text.starts_with("0X");
  char* end = nullptr;
  const long long number = std::strtoll(text.c_str(), &end, hexadecimal ? 16 : 10);
  if (!text.empty() && *end == '\0') return number;
  // 1e4 and 100.0 are whole numbers too.
  const auto real = ParseDouble(text);
  if (!real || *real != std::floor(*real) || std::abs(*real) > kLargestExactInteger) return std::nullopt;
  return static_cast<long long>(*real);
}

std::optional<bool> ParseBoolean(const std::string& text) {
  const std::string lower = Lowercase(text);
  for (const char* yes : {"true", "1", "on", "yes"})
    if (lower == yes) return true;
  for (const char* no : {"false", "0", "off", "no"})
    if (lower == no) return false;
  return std::nullopt;
}

void CheckRange(const std::string& who, const CameraFeature& feature, double number,
                const std::string& value) {
  const double slack = kRangeRounding * std::abs(number);
  if ((feature.min && number < *feature.min - slack) || (feature.max && number > *feature.max + slack))
    throw Refused(who, fmt::format("{}={} is out of range", feature.name, value),
                  fmt::format("it takes {}", RangeText(feature)));
}

}  // namespace

const char* Name(FeatureType type) {
  constexpr std::array kNames{"integer", "float", "boolean", "enumeration", "string", "command"};
  return kNames[static_cast<std::size_t>(type)];
}

const char* Name(FeatureVisibility visibility) {
  constexpr std::array kNames{"beginner", "expert", "guru", "invisible"};
  return kNames[static_cast<std::size_t>(visibility)];
}

std::string RangeText(const CameraFeature& feature) {
  switch (feature.type) {
    case FeatureType::kBoolean:
      return "true, false";
    case FeatureType::kEnumeration:
      return fmt::format("{}", fmt::join(feature.choices, ", "));
    case FeatureType::kString:
      return "text";
    case FeatureType::kCommand:
      return "execute";
    default:
      break;
  }
  std::string text = feature.min && feature.max ? fmt::format("{} to {}", *feature.min, *feature.max)
                     : feature.min              ? fmt::format("{} or more", *feature.min)
                     : feature.max              ? fmt::format("at most {}", *feature.max)
                     : feature.type == FeatureType::kInteger ? "a whole number"
                                                             : "a number";
  if (feature.step && !(feature.type == FeatureType::kInteger && *feature.step == 1))
    text += fmt::format(" step {}", *feature.step);
  return text + (feature.unit.empty() ? "" : " " + feature.unit);
}

std::vector<std::string> NearestNames(const std::string& wrong, const std::vector<std::string>& names,
                                      std::size_t count) {
  const std::string sought = Lowercase(wrong);
  const auto rank = [&](const std::string& name) {
    const std::string lower = Lowercase(name);
    const std::size_t distance = EditDistance(sought, lower);
    const bool contained =
        sought.size() > 2 && (lower.find(sought) != std::string::npos ||
                              (lower.size() > 2 && sought.find(lower) != std::string::npos));
    return std::pair(contained ? std::min(kContainedRank, distance) : distance, distance);
  };
  std::vector<std::pair<std::pair<std::size_t, std::size_t>, std::string>> ranked;
  for (const std::string& name : names) ranked.emplace_back(rank(name), name);
  std::stable_sort(ranked.begin(), ranked.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::string> nearest;
  for (std::size_t i = 0; i < std::min(count, ranked.size()); ++i) nearest.push_back(ranked[i].second);
  return nearest;
}

std::string CheckedValue(const std::string& who, const CameraFeature& feature, const std::string& value) {
  const auto refuse = [&] {
    throw Refused(who,
                  fmt::format("{}={} is not {} {}", feature.name, value,
                              feature.type == FeatureType::kEnumeration ? "a choice of this" : "of type",
                              Name(feature.type)),
                  fmt::format("it takes {}", RangeText(feature)));
  };
  switch (feature.type) {
    case FeatureType::kInteger: {
      const auto number = ParseInteger(value);
      if (!number) refuse();
      CheckRange(who, feature, static_cast<double>(*number), value);
      const auto step = static_cast<long long>(feature.step.value_or(1));
      const auto from = static_cast<long long>(feature.min.value_or(0));
      if (step > 1 && (*number - from) % step != 0)
        throw Refused(who, fmt::format("{}={} is between two steps", feature.name, value),
                      fmt::format("it takes {}, such as {}", RangeText(feature),
                                  from + (*number - from) / step * step));
      return fmt::format("{}", *number);
    }
    case FeatureType::kFloat: {
      const auto number = ParseDouble(value);
      if (!number) refuse();
      CheckRange(who, feature, *number, value);
      return fmt::format("{}", *number);
    }
    case FeatureType::kBoolean: {
      const auto yes = ParseBoolean(value);
      if (!yes) refuse();
      return *yes ? "true" : "false";
    }
    case FeatureType::kEnumeration:
      if (std::find(feature.choices.begin(), feature.choices.end(), value) == feature.choices.end()) refuse();
      return value;
    case FeatureType::kCommand:
      if (!value.empty() && value != "execute") refuse();
      return "";
    case FeatureType::kString:
      break;
  }
  return value;
}

bool SameValue(const CameraFeature& feature, const std::string& a, const std::string& b) {
  if (a == b) return true;
  if (feature.type == FeatureType::kBoolean) {
    const auto first = ParseBoolean(a), second = ParseBoolean(b);
    return first && second && *first == *second;
  }
  if (feature.type != FeatureType::kInteger && feature.type != FeatureType::kFloat) return false;
  const auto first = ParseDouble(a), second = ParseDouble(b);
  if (!first || !second) return false;
  if (feature.type == FeatureType::kInteger) return ParseInteger(a) == ParseInteger(b);
  const double tolerance = std::max(kSingleRounding * std::max(std::abs(*first), std::abs(*second)),
                                    feature.step ? 0.5 * *feature.step : 0.0);
  return std::abs(*first - *second) <= tolerance;
}

}  // namespace ulf::acquisition
