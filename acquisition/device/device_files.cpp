#include "acquisition/device/device_files.h"

#include <fmt/format.h>
#include <unistd.h>
#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <set>
#include <utility>

namespace ulf::acquisition {
namespace {

namespace fs = std::filesystem;

// `rule`: a whole rule, without spaces and in lower case.
bool Covers(const std::string& rule, UdevCameraKind kind) {
  const auto has = [&](const char* text) { return rule.find(text) != std::string::npos; };
  if (!has("uaccess") && !has("mode=") && !has("mode:=") && !has("group=") && !has("group:=")) return false;
  switch (kind) {
    case UdevCameraKind::kUsb3Vision:
      return has(":ef0500:") || has(":ef05") ||
             (has("binterfaceclass}==\"ef\"") && has("binterfacesubclass}==\"05\""));
    case UdevCameraKind::kVideo:
      return has("subsystem==\"video4linux\"") || has("subsystems==\"video4linux\"");
    case UdevCameraKind::kStill:
      return has(":060101:") || has("id_gphoto2}=\"1\"") ||
             (has("binterfaceclass}==\"06\"") && has("binterfacesubclass}==\"01\""));
  }
  return false;
}

// Lines that start with '#' are comments. A line that ends with '\\' continues in the next one.
bool Covers(const fs::path& file, UdevCameraKind kind) {
  std::ifstream rules(file);
  std::string line, joined;
  while (std::getline(rules, line)) {
    std::erase_if(line, [](unsigned char letter) { return std::isspace(letter); });
    if (joined.empty() && line.starts_with('#')) continue;
    std::transform(line.begin(), line.end(), line.begin(),
                   [](unsigned char letter) { return static_cast<char>(std::tolower(letter)); });
    joined += line;
    if (joined.ends_with('\\')) {
      joined.pop_back();
      continue;
    }
    if (Covers(joined, kind)) return true;
    joined.clear();
  }
  return false;
}

}  // namespace

std::vector<fs::path> UdevRuleFolders() {
  return {"/etc/udev/rules.d", "/run/udev/rules.d", "/usr/local/lib/udev/rules.d", "/usr/lib/udev/rules.d",
          "/lib/udev/rules.d"};
}

std::optional<fs::path> InstalledUdevRules(UdevCameraKind kind, const std::vector<fs::path>& folders) {
  std::set<std::string> hidden;
  for (const fs::path& folder : folders) {
    std::error_code missing;
    std::set<fs::path> files;
    for (fs::directory_iterator entry(folder, missing), end; !missing && entry != end;
         entry.increment(missing))
      if (entry->path().extension() == ".rules") files.insert(entry->path());
    for (const fs::path& file : files)
      if (hidden.insert(file.filename().string()).second && Covers(file, kind)) return file;
  }
  return std::nullopt;
}

std::optional<std::string> MissingUdevRulesHint(const std::vector<fs::path>& folders, bool is_root) {
  if (is_root) return std::nullopt;
  std::string missing;
  for (const auto& [kind, name] : {std::pair(UdevCameraKind::kUsb3Vision, "USB3 Vision cameras"),
                                   std::pair(UdevCameraKind::kVideo, "webcams"),
                                   std::pair(UdevCameraKind::kStill, "DSLRs and other still cameras")})
    if (!InstalledUdevRules(kind, folders)) missing += (missing.empty() ? "" : ", ") + std::string(name);
  if (missing.empty()) return std::nullopt;
  return "No udev rule lets you open " + missing +
         ": install udev/70-ulf-cameras.rules (sudo cp udev/70-ulf-cameras.rules /etc/udev/rules.d/ && "
         "sudo udevadm control --reload), then unplug the camera and plug it in again.";
}

std::optional<std::string> MissingUdevRulesHintForThisUser() {
  return MissingUdevRulesHint(UdevRuleFolders(), geteuid() == 0);
}

std::vector<std::string> ProgramsHolding(const std::string& path, const std::string& proc) {
  std::vector<std::string> programs;
  std::error_code ignored;
  for (const auto& process : fs::directory_iterator(proc, ignored)) {
    const std::string id = process.path().filename().string();
    if (id.empty() || id.find_first_not_of("0123456789") != std::string::npos) continue;
    if (id == std::to_string(getpid())) continue;
    std::error_code denied;
    for (const auto& open : fs::directory_iterator(process.path() / "fd", denied)) {
      if (fs::read_symlink(open.path(), denied) != path) continue;
      std::string name;
      std::getline(std::ifstream(process.path() / "comm"), name);
      programs.push_back(fmt::format("{} (process {})", name, id));
      break;
    }
  }
  return programs;
}

}  // namespace ulf::acquisition
