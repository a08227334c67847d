// Files that are either whole or absent, whatever kills the process.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace ulf {

// Writes to a temporary name beside `path`, syncs it, renames it, syncs the folder. Throws DiskFullError or
// Error (no permission); then what was at `path` is there as it was.
void WriteFileAtomically(const std::filesystem::path& path, std::string_view bytes);

// What a file is to hold: bytes that are there, or that are made while they are written, so that a large
// picture need not be in memory twice.
struct FileContent {
  std::uint64_t size = 0;
  // Copies what stands from `offset` on; `out` never reaches past the end.
  std::function<void(std::uint64_t offset, std::span<char> out)> copy;
};
// The bytes are not copied: they must stay where they are.
FileContent ContentOf(std::string_view bytes);

// Files that come to the disk together: a disk takes one wait for many files in the time of one wait for one.
// Large ones go past the page cache where the file system allows it (twice as fast, and a day of capture
// does not push everything else out of memory).
class FileBatch {
 public:
  // What Commit() does where a file of that name is there already: kKeep throws Error.
  enum class Existing { kReplace, kKeep };
  explicit FileBatch(Existing existing = Existing::kReplace) : existing_(existing) {}
  FileBatch(const FileBatch&) = delete;
  FileBatch& operator=(const FileBatch&) = delete;
  ~FileBatch();  // removes what was not committed

  // Under a temporary name of this batch's own. Throws DiskFullError or Error; then nothing of this file
  // stays.
  void Write(const std::filesystem::path& path, const FileContent& content);
  // The same for files that belong together: all, or none of them stays.
  void Write(std::span<const std::pair<std::filesystem::path, FileContent>> files);
  // Syncs all files, gives them their names, syncs their folders; the next Write() begins a new batch. Throws
  // as Write() does; then nothing of the whole batch stays, except what took an older file's place already.
  void Commit();
  // Removes the files, committed or not: for when what was to name them could not be written. Never what has
  // replaced an older file: both would be lost.
  void TakeBack();

 private:
  struct File {
    std::filesystem::path path, temporary;
    int descriptor = -1;
    bool replaced = false, renamed = false;
  };
  void TakeBackFrom(std::size_t first);
  Existing existing_;
  std::vector<File> files_;
  bool committed_ = false;
};

void SyncFolder(const std::filesystem::path& folder);

// Moves a file or folder to `to` or, where something is there already, to the first free name beside it
// (a-2.png for a.png); never over what is there. Returns the name. Throws Error.
std::filesystem::path MoveWithoutReplacing(const std::filesystem::path& from,
                                           const std::filesystem::path& to);

// With all folders above it. Throws Error naming what stands in the way.
void MakeFolder(const std::filesystem::path& folder);

// What this user may still write there; the largest number where the system does not say.
std::uint64_t FreeBytes(const std::filesystem::path& folder);

// Throws what fits an errno: DiskFullError when there is no room, else Error.
[[noreturn]] void ThrowDiskError(int reason, const std::string& what_failed);

std::string ReadWholeFile(const std::filesystem::path& path);

// The ending of all temporary names here: leftovers of a kill, safe to remove when nobody writes.
inline constexpr std::string_view kTemporaryEnding = ".part";

}  // namespace ulf
