// Whether this computer has rules that let a user open cameras: udev/70-ulf-cameras.rules or others that do
// the same, for each kind of camera that is opened through a device file. Said only where it could be the
// reason: when a camera is refused, or none is found.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace ulf::acquisition {

enum class UdevCameraKind {
  kUsb3Vision,  // by the interface class ef/05
  kVideo,       // webcams and frame grabbers: video4linux
  kStill,       // PTP (interface class 06/01), or what libgphoto2's own rules mark
};

// Where udev reads rules; a file hides those of the same name in the folders after it.
std::vector<std::filesystem::path> UdevRuleFolders();

// The first rule file that gives cameras of this kind to users, if there is one.
std::optional<std::filesystem::path> InstalledUdevRules(
    UdevCameraKind kind, const std::vector<std::filesystem::path>& folders = UdevRuleFolders());

// What to do about missing rules, naming the kinds; none when they are there or when this user needs none
// (root).
std::optional<std::string> MissingUdevRulesHint(
    const std::vector<std::filesystem::path>& folders = UdevRuleFolders(), bool is_root = false);
// The same for the user who runs this.
std::optional<std::string> MissingUdevRulesHintForThisUser();

}  // namespace ulf::acquisition
