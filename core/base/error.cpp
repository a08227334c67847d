#include "core/base/error.h"

#include <atomic>

namespace ulf {
namespace {

std::string AsInTheApi(std::string_view name) { return std::string(name); }

std::atomic<std::string (*)(std::string_view)> spelling{AsInTheApi};

std::string Joined(const std::string& what, const std::string& value, const std::string& why,
                   const std::string& remedy) {
  std::string text = what.empty() || value.empty() ? what : what + " " + value;
  if (!why.empty()) text += (text.empty() ? "" : ": ") + why;
  return remedy.empty() ? text : text + "; " + remedy;
}

}  // namespace

Refusal::Refusal(const std::string& what, const std::string& value, const std::string& why,
                 const std::string& remedy)
    : Error("{}", Joined(what, value, why, remedy)) {}

std::string Parameter(std::string_view name) { return spelling.load()(name); }

void SpellParameters(std::string (*spell)(std::string_view name)) { spelling = spell; }

}  // namespace ulf
