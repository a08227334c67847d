#include "tests/fuzz/fuzz_targets.h"

#include <fmt/core.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <system_error>

namespace ulf::test {
namespace {

namespace fs = std::filesystem;

class MemoryFolder {
 public:
  explicit MemoryFolder(const char* name)
      : path_((fs::is_directory("/dev/shm") ? fs::path("/dev/shm") : fs::temp_directory_path()) /
              fmt::format("ulf_fuzz_{}_{}", name, getpid())) {
    Empty();
  }
  ~MemoryFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  MemoryFolder(const MemoryFolder&) = delete;
  MemoryFolder& operator=(const MemoryFolder&) = delete;
  void Empty() const {
    fs::remove_all(path_);
    fs::create_directories(path_);
  }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

const MemoryFolder& Folder() {
  static const MemoryFolder folder("files");
  return folder;
}

}  // namespace

fs::path FuzzFolder(std::string_view bytes, std::span<const char* const> names) {
  constexpr std::string_view kBorder = "\n=====\n";
  Folder().Empty();
  for (const char* const name : names) {
    const std::size_t end = bytes.find(kBorder);
    const fs::path file = Folder().path() / name;
    fs::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary) << bytes.substr(0, end);
    if (end == std::string_view::npos) break;
    bytes.remove_prefix(end + kBorder.size());
  }
  return Folder().path();
}

fs::path FuzzFile(std::string_view bytes, const char* name) {
  Folder().Empty();
  const fs::path file = Folder().path() / name;
  std::ofstream(file, std::ios::binary) << bytes;
  return file;
}

fs::path FuzzPhotographs() {
  static const MemoryFolder folder("photographs");
  static const bool made = [] {
    for (int i = 1; i <= 4; ++i)
      cv::imwrite(folder.path() / fmt::format("{:04}.png", i),
                  cv::Mat(48, 64, CV_8UC3, cv::Scalar(90, 120, 20 * i)));
    return true;
  }();
  return made ? folder.path() : fs::path();
}

void PutFuzzPhotographs(const fs::path& folder) {
  fs::create_directories(folder);
  for (const auto& entry : fs::directory_iterator(FuzzPhotographs()))
    fs::create_hard_link(entry.path(), folder / entry.path().filename());
}

void Broken(const char* what) {
  std::fprintf(stderr, "broken: %s\n", what);
  std::abort();
}

}  // namespace ulf::test
