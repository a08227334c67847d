// Defines what `ulf capture --resume` does with each option of the command by one rule an option. An option
// is used from now on, or must agree with the light field, or cannot be honoured for this light field; in
// both latter cases it is refused by name, with both values and the remedy, before anything is written.
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
  std::string_view option;  // without its dashes
  OnResume what;
  // Returns what follows the option's name in a refusal, its value and why not; empty if it is accepted. Null
  // if the option is always used.
  std::string (*refusal)(const CaptureArgs& args, const LightField& light_field) = nullptr;
};

std::span<const ResumeRule> ResumeRules();

// Returns the options on the command line, by the names of the rules.
std::set<std::string> GivenOptions(const CLI::App& command);

// Throws UsageError for the first of `given` that is refused, and Error for a light field that cannot be
// read. LightFieldWriter::Resume handles a folder without a journal.
void RequireResumable(const CaptureArgs& args, const std::set<std::string>& given);

}  // namespace ulf::commands
