// Writing files so that each is whole or absent, even when the process is killed at any moment.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/file_descriptor.h"

namespace ulf {

// Writes a temporary file beside `path`, syncs it, renames it and syncs the folder; a pipe or a device gets
// the bytes directly. Throws DiskFullError, or Error if writing fails otherwise; an existing file at `path`
// is then unchanged, because nothing throws after the rename.
void WriteFileAtomically(const std::filesystem::path& path, std::string_view bytes);

// The bytes of a file to be written. `copy` may make them while they are written, so that a large picture
// does not have to be in memory twice.
struct FileContent {
  std::uint64_t size = 0;
  // Fills `out` with the bytes from `offset` on; FileBatch never asks for bytes past the end.
  std::function<void(std::uint64_t offset, std::span<char> out)> copy;
};
// Returns content that refers to `bytes`, which must outlive it.
FileContent ContentOf(std::string_view bytes);

// Writes several files together: one wait for the disk serves all of them. Large files bypass the page cache
// where the file system allows it, which is twice as fast and leaves the cache to other programs.
class FileBatch {
 public:
  // What Commit() does if a file of that name exists: kReplace replaces it, kKeep throws Error.
  enum class Existing { kReplace, kKeep };
  explicit FileBatch(Existing existing = Existing::kReplace) : existing_(existing) {}
  FileBatch(const FileBatch&) = delete;
  FileBatch& operator=(const FileBatch&) = delete;
  ~FileBatch();  // removes the files that were not committed

  // Writes the file under a temporary name of this batch's own. Throws DiskFullError or Error; then nothing
  // of this file is left on the disk.
  void Write(const std::filesystem::path& path, const FileContent& content);
  // Does the same for several files; if one cannot be written, none of them is left.
  void Write(std::span<const std::pair<std::filesystem::path, FileContent>> files);
  // Syncs all files, renames them and syncs their folders; the next Write() begins a new batch. Throws as
  // Write() does; then nothing of the batch is left, except files that have already replaced older ones.
  void Commit();
  // Does the same, then calls `note`, which writes the files' names to an index; if `note` throws, removes
  // the files as TakeBack() does and throws that again.
  void Commit(const std::function<void()>& note);
  // Removes the batch's files, committed or not, for a caller that could not write the index that names them.
  // Files that have replaced older ones stay, because removing them would lose both.
  void TakeBack() { TakeBack(0); }

 private:
  struct File {
    std::filesystem::path path, temporary;
    FileDescriptor descriptor;
    bool replaced = false, renamed = false;
  };
  void TakeBack(std::size_t first);
  // The files of a committed batch are the caller's: TakeBack() no longer removes them.
  void BeginAfterCommit();
  Existing existing_;
  std::vector<File> files_;
  bool committed_ = false;
};

// Returns the folder that holds `path`, or "." if `path` names none.
std::filesystem::path FolderOf(const std::filesystem::path& path);

// Syncs the names of the folder's files. Throws Error if it cannot be opened.
void SyncFolder(const std::filesystem::path& folder);

// Returns whether the path leads to the opened file or folder.
bool IsSameFile(int descriptor, const std::filesystem::path& path);

// Returns false if the disk refused; see errno.
bool WriteAll(int descriptor, std::string_view bytes);

// Moves a file or folder to `to` or, where that name is taken, to the first free name beside it (a-2.png for
// a.png); never replaces anything. Returns the new path. Throws Error if it cannot be moved.
std::filesystem::path MoveWithoutReplacing(const std::filesystem::path& from,
                                           const std::filesystem::path& to);

// Gives a file the second name `to`, or makes a copy where the file system has no hard links. Returns false
// if the name `to` is taken. Throws Error if neither works.
bool LinkOrCopy(const std::filesystem::path& from, const std::filesystem::path& to);

// Makes the folder and all folders above it. Throws Error naming what stands in the way.
void MakeFolder(const std::filesystem::path& folder);

// Returns the bytes that this user may still write there, or the largest number if the system does not tell.
std::uint64_t FreeBytes(const std::filesystem::path& folder);

// Throws DiskFullError if `reason`, an errno, says that there is no room, otherwise Error.
[[noreturn]] void ThrowDiskError(int reason, const std::string& what_failed);

// Throws Error unless `path` leads to a regular file: reading a pipe or a device might never end.
void RequireRegularFile(const std::filesystem::path& path);

// Opens a regular file. Throws Error if it is missing, is not regular, or cannot be read.
std::ifstream OpenRegularFile(const std::filesystem::path& path);

// Returns the bytes of a regular file. Throws Error if it is missing, is not regular, cannot be read, or is
// larger than the memory that is left.
std::string ReadWholeFile(const std::filesystem::path& path);

// The ending of all temporary names. Files with it that a killed process left are safe to remove.
inline constexpr std::string_view kTemporaryEnding = ".part";

// Returns a mark for temporary names that tells this process from those of other computers that write to the
// same disk: a hash of the computer's name, and the process number, "1f3a9c02-4711".
std::string ProcessMark();
// Returns whether `mark` is of a process of this computer that no longer runs.
bool IsOfEndedProcess(const std::string& mark);
// Returns a name beside `path` that nobody else uses: PATH.MARK-NUMBER.part.
std::filesystem::path TemporaryName(const std::filesystem::path& path);

// Returns whether the entry is a regular file with such a name.
bool IsTemporary(const std::filesystem::directory_entry& entry);
// Returns whether the entry is a temporary file that a killed process left: its process was one of this
// computer and no longer runs, or the file is older than an hour.
bool IsLeftTemporary(const std::filesystem::directory_entry& entry);

}  // namespace ulf
