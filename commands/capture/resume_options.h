// What `ulf capture --resume` does with each option of the command: one rule an option, and none is passed
// over. An option is used from now on, or it must agree with what the light field has, or the light field as
// it is cannot honour it; in both these cases it is refused by name, with both values and the way out, before
// anything is written.
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
  kUsedWithCamera,  // the same; that the device is the light field's is checked once it is open
  kMustAgree,
  kCannotBeHonoured
};

struct ResumeRule {
  std::string_view option;  // without its dashes
  OnResume what;
  // What stands behind the option's name in a refusal: its value and why not; empty: nothing speaks against
  // it. Null where the option is used in any case.
  std::string (*refusal)(const CaptureArgs& args, const LightField& light_field) = nullptr;
};

std::span<const ResumeRule> ResumeRules();

// The options on the command line, by the names of the rules.
std::set<std::string> GivenOptions(const CLI::App& command);

// Throws UsageError for the first of `given` that is refused, and Error for a light field that cannot be
// read. A folder without a journal is left to LightFieldWriter::Resume.
void RequireResumable(const CaptureArgs& args, const std::set<std::string>& given);

}  // namespace ulf::commands
