// Defines what `ulf capture --resume` does with each option, by one rule per option. An option is used from
// now on, or must agree with the light field, or cannot be honoured for some light fields. If it disagrees or
// cannot be honoured, it is refused before anything is written, in a message with both values and the remedy.
#pragma once

#include <set>
#include <span>
#include <string>
#include <string_view>

#include "commands/capture/capture_start.h"
#include "core/light_field/light_field.h"

namespace CLI {
class App;
}

namespace ulf::commands {

enum class OnResume {
  kUsed,
  kUsedWithCamera,  // used, if the opened device is the light field's
  kMustAgree,
  kCannotBeHonoured
};

struct ResumeRule {
  std::string_view option;  // long name without dashes
  OnResume what;
  // Returns the text that follows the option's name in a refusal; empty if the option is accepted. Null if
  // the option is never refused.
  std::string (*refusal)(const CaptureArgs& args, const LightField& light_field) = nullptr;
};

// Returns the rules of all options, in the order in which they are checked.
std::span<const ResumeRule> ResumeRules();

// Returns the options that stand on the parsed command line, named as in the rules.
std::set<std::string> GivenOptions(const CLI::App& command);

// Throws UsageError for the first of the rules that refuses one of `given`, and Error for a journal that
// cannot be read. Does nothing without --resume or journal (LightFieldWriter::Resume() refuses later).
void RequireResumable(const CaptureArgs& args, const std::set<std::string>& given);

}  // namespace ulf::commands
