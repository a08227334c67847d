#include "core/light_field/findings.h"

#include <spdlog/spdlog.h>

#include <array>
#include <cctype>
#include <set>
#include <utility>
#include <vector>

#include "core/base/mutex.h"

namespace ulf {
namespace {

// Numbers may change while a light field is recorded; the finding is the same.
std::string WithoutDigits(std::string text) {
  std::erase_if(text, [](unsigned char each) { return std::isdigit(each) != 0; });
  return text;
}

}  // namespace

const char* Name(Check check) {
  constexpr std::array kNames{"files", "points", "subject", "poses", "light"};
  return kNames[static_cast<std::size_t>(check)];
}

std::string Finding::Words() const {
  constexpr std::string_view kMark = "{views}";
  constexpr std::size_t kNamed = 3;
  const std::size_t at = text.find(kMark);
  if (at == std::string::npos) return text;
  std::vector<std::string> names;
  for (auto view = views.begin(); view != views.end() && names.size() < kNamed; ++view)
    names.push_back(view->second);
  if (views.size() > kNamed) names.push_back("...");
  return text.substr(0, at) + fmt::format("{} ({})", ViewNumbers(views), fmt::join(names, ", ")) +
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

void WarnOnce(const std::vector<std::string>& words) {
  static Mutex mutex;
  static std::set<std::string> logged ULF_GUARDED_BY(mutex);
  const MutexLock lock(mutex);
  for (const std::string& each : words)
    if (logged.insert(each).second) spdlog::warn("{}", each);
}

std::string ViewNumbers(const std::set<int>& ids) {
  constexpr std::size_t kMostRuns = 6;  // more are summed up as "and N more"
  std::vector<std::pair<int, int>> runs;
  for (auto id = ids.begin(); id != ids.end();) {
    const int first = *id;
    int last = first;
    for (++id; id != ids.end() && *id == last + 1; ++id) last = *id;
    const bool is_pair = last == first + 1;  // "3, 4" rather than "3 to 4"
    runs.emplace_back(first, is_pair ? first : last);
    if (is_pair) runs.emplace_back(last, last);
  }
  if (runs.empty()) return "";
  std::string words;
  std::size_t named = 0;
  const std::size_t shown = runs.size() <= kMostRuns ? runs.size() : kMostRuns - 1;
  for (std::size_t i = 0; i < shown; ++i) {
    const auto [first, last] = runs[i];
    if (i > 0) words += i + 1 == runs.size() ? " and " : ", ";
    words += first == last ? fmt::format("{}", first) : fmt::format("{} to {}", first, last);
    named += static_cast<std::size_t>(last - first) + 1;
  }
  if (shown < runs.size()) words += fmt::format(" and {} more", ids.size() - named);
  return fmt::format("{} {}", ids.size() == 1 ? "view" : "views", words);
}

}  // namespace ulf
