// Whether this computer has a rule that lets a user open USB3 Vision cameras: udev/70-ulf-cameras.rules or
// another one for the same interface class (ef/05). Said only where it could be the reason: when a camera is
// refused, or none is found.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace ulf {

// Where udev reads rules; a file hides those of the same name in the folders after it.
std::vector<std::filesystem::path> UdevRuleFolders();

// The rule file that covers USB3 Vision cameras, if there is one.
std::optional<std::filesystem::path> InstalledUsb3VisionRules(
    const std::vector<std::filesystem::path>& folders = UdevRuleFolders());

// What to do about missing rules; none when they are there or when this user needs none (root).
std::optional<std::string> MissingUdevRulesHint(
    const std::vector<std::filesystem::path>& folders = UdevRuleFolders(), bool is_root = false);
// The same for the user who runs this.
std::optional<std::string> MissingUdevRulesHintForThisUser();

}  // namespace ulf
