#include "core/light_field/findings.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cctype>
#include <set>

#include "core/base/mutex.h"
#include "core/light_field/view_numbers.h"

namespace ulf {
namespace {

// Numbers may change while a light field is recorded; what is said stays the same.
std::string WithoutDigits(std::string text) {
  std::erase_if(text, [](unsigned char each) { return std::isdigit(each) != 0; });
  return text;
}

}  // namespace

const char* Name(Check check) {
  switch (check) {
    case Check::kFiles:
      return "files";
    case Check::kPoints:
      return "points";
    case Check::kSubject:
      return "subject";
    case Check::kPoses:
      return "poses";
    case Check::kLight:
      return "light";
  }
  return "";
}

std::string Finding::Words() const {
  constexpr std::string_view kMark = "{views}";
  constexpr std::size_t kNamed = 3;
  const std::size_t at = text.find(kMark);
  if (at == std::string::npos) return text;
  std::string names;
  std::size_t named = 0;
  for (const auto& [id, image] : views) {
    if (named++ == kNamed) {
      names += ", ...";
      break;
    }
    names += (names.empty() ? "" : ", ") + image;
  }
  return text.substr(0, at) + fmt::format("{} ({})", ViewNumbers(views), names) +
         text.substr(at + kMark.size());
}

void Replace(Check check, const std::vector<Finding>& found, std::vector<Finding>& findings) {
  std::erase_if(findings, [&](const Finding& each) { return each.check == Name(check); });
  findings.insert(findings.end(), found.begin(), found.end());
}

void WarnOnce(const std::filesystem::path& light_field, const std::vector<Finding>& findings) {
  static Mutex mutex;
  static std::set<std::string> said ULF_GUARDED_BY(mutex);
  const MutexLock lock(mutex);
  for (const Finding& each : findings)
    if (said.insert(light_field.string() + '\n' + WithoutDigits(each.text)).second)
      spdlog::warn("{}: {}", light_field.string(), each.Words());
}

}  // namespace ulf
