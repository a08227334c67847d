#include "acquisition/device/file_holders.h"

#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace ulf::acquisition {

namespace fs = std::filesystem;

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
