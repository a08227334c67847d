// Finds out why a camera's device file cannot be opened: another program has it open, or no udev rule lets
// this user open it (udev/70-ulf-cameras.rules or equivalent ones, for each kind of camera). Messages mention
// the rules only when they may be the reason: a camera cannot be opened, or none is found.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace ulf::acquisition {

enum class UdevCameraKind {
  kUsb3Vision,  // USB interface class ef/05
  kVideo,       // webcams and frame grabbers: video4linux
  kStill,       // PTP (interface class 06/01), or what libgphoto2's own rules mark
};

// Returns the folders in which udev reads rules; a file overrides those of the same name in later folders.
std::vector<std::filesystem::path> UdevRuleFolders();

// Returns the first rule file that lets users open cameras of this kind; none if there is none.
std::optional<std::filesystem::path> InstalledUdevRules(
    UdevCameraKind kind, const std::vector<std::filesystem::path>& folders = UdevRuleFolders());

// Returns how to install missing rules, by kinds of camera; none if all are installed, or for root.
std::optional<std::string> MissingUdevRulesHint(
    const std::vector<std::filesystem::path>& folders = UdevRuleFolders(), bool is_root = false);
// Returns the hint for the user of this process.
std::optional<std::string> MissingUdevRulesHintForThisUser();

// Returns the other programs that have `path` open, such as "cheese (process 4711)", as far as this user may
// see them. `proc`: the folder in which the kernel lists processes.
std::vector<std::string> ProgramsHolding(const std::string& path, const std::string& proc = "/proc");

}  // namespace ulf::acquisition
