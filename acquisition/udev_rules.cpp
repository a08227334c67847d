#include "acquisition/udev_rules.h"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <set>

namespace ulf {
namespace {

namespace fs = std::filesystem;

// Rules are compared without spaces and in lower case; what stands behind a '#' at a line's start is no rule.
bool CoversUsb3Vision(const fs::path& file) {
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
    const bool by_list =
        joined.find(":ef0500:") != std::string::npos || joined.find(":ef05") != std::string::npos;
    const bool by_class = joined.find("binterfaceclass}==\"ef\"") != std::string::npos &&
                          joined.find("binterfacesubclass}==\"05\"") != std::string::npos;
    const bool grants = joined.find("uaccess") != std::string::npos ||
                        joined.find("mode") != std::string::npos || joined.find("group") != std::string::npos;
    if ((by_list || by_class) && grants) return true;
    joined.clear();
  }
  return false;
}

}  // namespace

std::vector<fs::path> UdevRuleFolders() {
  return {"/etc/udev/rules.d", "/run/udev/rules.d", "/usr/local/lib/udev/rules.d", "/usr/lib/udev/rules.d",
          "/lib/udev/rules.d"};
}

std::optional<fs::path> InstalledUsb3VisionRules(const std::vector<fs::path>& folders) {
  std::set<std::string> hidden;
  for (const fs::path& folder : folders) {
    std::error_code missing;
    std::set<fs::path> files;
    for (fs::directory_iterator entry(folder, missing), end; !missing && entry != end;
         entry.increment(missing))
      if (entry->path().extension() == ".rules") files.insert(entry->path());
    for (const fs::path& file : files)
      if (hidden.insert(file.filename().string()).second && CoversUsb3Vision(file)) return file;
  }
  return std::nullopt;
}

std::optional<std::string> MissingUdevRulesHint(const std::vector<fs::path>& folders, bool is_root) {
  if (is_root || InstalledUsb3VisionRules(folders)) return std::nullopt;
  return "No udev rule lets you open USB3 Vision cameras here: install udev/70-ulf-cameras.rules (sudo cp "
         "udev/70-ulf-cameras.rules /etc/udev/rules.d/ && sudo udevadm control --reload), then plug the "
         "camera "
         "out and in.";
}

std::optional<std::string> MissingUdevRulesHintForThisUser() {
  return MissingUdevRulesHint(UdevRuleFolders(), geteuid() == 0);
}

}  // namespace ulf
