#include "core/base/output_path.h"

#include <unistd.h>

#include <fmt/format.h>

#include <cerrno>
#include <filesystem>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/lowercase.h"

namespace ulf {
namespace fs = std::filesystem;

void RequireWritable(const std::string& path) {
  const fs::path folder = FolderOf(path);
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) throw Refusal(path, "", "is a folder", "give a file's name");
  if (!fs::is_directory(folder, ignored))
    throw Refusal(path, "", fmt::format("the folder {} does not exist", folder.string()), "make it first");
  if (access(folder.c_str(), W_OK) != 0)
    throw Refusal(path, "", fmt::format("the folder {} is not writable", folder.string()), "choose another");
}

void RequireUnused(const std::string& path, std::string_view bytes) {
  std::error_code unknown;
  if (!fs::is_regular_file(path, unknown)) return;
  if (fs::file_size(path, unknown) == bytes.size() && ReadWholeFile(path) == bytes) return;
  throw Refusal(path, "", "exists already and is not replaced", "choose another name, or remove it first");
}

void RequireWritablePicture(const std::string& path) {
  const std::string ending = Lowercase(fs::path(path).extension().string());
  if (ending != ".png" && ending != ".jpg" && ending != ".jpeg")
    throw Refusal(path, "", "give a picture's name, ending in .png or .jpg", "");
  RequireWritable(path);
}

void RequireFolderCanBeMade(const std::string& path) {
  std::error_code ignored;
  fs::path there = fs::absolute(path).lexically_normal();
  while (!fs::exists(there, ignored) && there.has_relative_path()) there = there.parent_path();
  if (!fs::is_directory(there, ignored))
    throw Refusal(path, "", fmt::format("{} is no folder", there.string()), "choose another");
  if (access(there.c_str(), W_OK) != 0)
    throw Refusal(path, "", fmt::format("the folder {} is not writable", there.string()), "choose another");
}

void RequireRoom(const fs::path& folder, std::uint64_t bytes) {
  std::error_code unknown;
  const fs::space_info space = fs::space(folder, unknown);
  if (unknown || space.capacity == 0 || space.available >= bytes) return;
  throw DiskFullError("{}: {:.3g} MB are needed and {:.3g} MB are free; make room, or choose another disk",
                      folder.string(), 1e-6 * static_cast<double>(bytes),
                      1e-6 * static_cast<double>(space.available));
}

void RequireWritableFolder(const std::string& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (!error && access(path.c_str(), W_OK) != 0) error = {errno, std::generic_category()};
  if (error)
    throw Refusal(path, "", fmt::format("no folder to write into ({})", error.message()), "choose another");
}

}  // namespace ulf
