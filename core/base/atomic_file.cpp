#include "core/base/atomic_file.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <regex>
#include <string>
#include <utility>

#include "core/base/available_memory.h"
#include "core/base/error.h"
#include "core/base/mutex.h"

namespace ulf {
namespace fs = std::filesystem;

namespace {

constexpr std::size_t kBlock = 4096;          // unit of writes that bypass the page cache (O_DIRECT)
constexpr std::size_t kStaged = 4 << 20;      // copied and written at a time
constexpr std::size_t kDirectFrom = 1 << 18;  // smaller files gain nothing; guessed

// There is one per thread, reused: new memory costs more than the copy into it.
std::span<char> Staging() {
  struct Free {
    void operator()(char* memory) const { std::free(memory); }
  };
  thread_local const std::unique_ptr<char, Free> memory(
      static_cast<char*>(std::aligned_alloc(kBlock, kStaged)));
  if (!memory) throw std::bad_alloc();
  return {memory.get(), kStaged};
}

struct Temporary {
  fs::path path;
  FileDescriptor descriptor;  // not open: failed, see errno
};

// The name is unique, because other threads and programs may write the same file.
Temporary OpenTemporary(const fs::path& beside, bool direct) {
  Temporary temporary;
  do {
    temporary.path = TemporaryName(beside);
    temporary.descriptor =
        FileDescriptor(open(temporary.path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644));
  } while (!temporary.descriptor.IsOpen() && errno == EEXIST);
  if (const int number = temporary.descriptor.Number(); direct && number >= 0)
    fcntl(number, F_SETFL, fcntl(number, F_GETFL) | O_DIRECT);  // if the file system allows it
  return temporary;
}

FileDescriptor OpenFolder(const fs::path& folder) {
  FileDescriptor descriptor(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!descriptor.IsOpen())
    throw Error("{}: cannot open the folder: {}", folder.string(), std::strerror(errno));
  return descriptor;
}

// Returns false if the name is taken (EEXIST) or the disk refuses; see errno.
bool RenameToFree(const fs::path& from, const fs::path& to) {
  if (renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return true;
  if (errno != EINVAL && errno != ENOSYS) return false;
  // This file system does not support RENAME_NOREPLACE.
  std::error_code unknown;
  if (fs::exists(fs::symlink_status(to, unknown))) {
    errno = EEXIST;
    return false;
  }
  return rename(from.c_str(), to.c_str()) == 0;
}

// Copies a file, or a folder with its files, to a name that is free. Throws Error.
void CopyTo(const fs::path& from, const fs::path& to) {
  if (!fs::is_directory(from)) {
    const std::string bytes = ReadWholeFile(from);
    FileBatch batch(FileBatch::Existing::kKeep);
    batch.Write(to, ContentOf(bytes));
    batch.Commit();
    return;
  }
  MakeFolder(to);
  for (const fs::directory_entry& entry : fs::directory_iterator(from))
    CopyTo(entry.path(), to / entry.path().filename());
}

// Does the same as RenameToFree(), also across disks: then a kill leaves the original, or both.
bool MoveToFree(const fs::path& from, const fs::path& to) {
  if (RenameToFree(from, to)) return true;
  if (errno != EXDEV) return false;
  std::error_code unknown;
  if (fs::exists(fs::symlink_status(to, unknown))) {
    errno = EEXIST;
    return false;
  }
  CopyTo(from, to);
  SyncFolder(FolderOf(to));
  fs::remove_all(from, unknown);
  if (!unknown) return true;
  const std::error_code refused = unknown;
  fs::remove_all(to, unknown);  // otherwise every try leaves another copy
  errno = refused.value();
  return false;
}

// Containers have process numbers of their own: the file of their namespace has another inode.
std::string ThisComputer() {
  static const std::string computer = [] {
    std::array<char, 256> name{};
    gethostname(name.data(), name.size() - 1);
    struct stat numbers {};
    stat("/proc/self/ns/pid", &numbers);
    const auto hash = std::hash<std::string>{}(fmt::format("{} {}", name.data(), numbers.st_ino));
    return fmt::format("{:08x}", hash & 0xFFFFFFFF);
  }();
  return computer;
}

// Returns the mark of the process that wrote the temporary file, by its name; none if it has another name, or
// is no file. Names of older programs had no computer.
std::optional<std::string> MarkOf(const fs::directory_entry& entry) {
  static const std::regex kName(R"(.+\.((?:[0-9a-f]{8}-)?[0-9]{1,9})-[0-9]+\.part)");
  const std::string name = entry.path().filename().string();
  std::smatch parts;
  std::error_code unknown;
  if (!entry.is_regular_file(unknown) || !std::regex_match(name, parts, kName)) return std::nullopt;
  return parts[1].str();
}

bool IsOfDeadProcess(const fs::directory_entry& entry) {
  const std::optional<std::string> mark = MarkOf(entry);
  return mark && IsOfEndedProcess(*mark);
}

// Removes what killed processes left of this file. A folder is searched once: this process removes its own
// files itself.
void RemoveLeftOf(const fs::path& path) {
  static Mutex mutex;
  static std::map<fs::path, std::vector<fs::path>> left_in ULF_GUARDED_BY(mutex);
  const MutexLock lock(mutex);
  std::error_code unknown;
  const auto [found, is_new] = left_in.try_emplace(FolderOf(path));
  std::vector<fs::path>& left = found->second;
  if (is_new)
    for (const auto& entry : fs::directory_iterator(FolderOf(path), unknown))
      if (IsOfDeadProcess(entry)) left.push_back(entry.path());
  const std::string prefix = path.filename().string() + ".";
  std::erase_if(left, [&](const fs::path& each) {
    return each.filename().string().starts_with(prefix) && fs::remove(each, unknown);
  });
}

bool LeaveDirect(int descriptor) {
  const int flags = fcntl(descriptor, F_GETFL);
  return (flags & O_DIRECT) && fcntl(descriptor, F_SETFL, flags & ~O_DIRECT) == 0;
}

bool WriteContent(int descriptor, const FileContent& content, bool direct) {
  const std::span<char> staging = Staging();
  for (std::uint64_t done = 0; done < content.size; done += staging.size()) {
    const auto size = static_cast<std::size_t>(std::min<std::uint64_t>(staging.size(), content.size - done));
    content.copy(done, staging.first(size));
    const std::size_t whole_blocks = direct ? (size + kBlock - 1) / kBlock * kBlock : size;
    std::fill(staging.begin() + static_cast<std::ptrdiff_t>(size),
              staging.begin() + static_cast<std::ptrdiff_t>(whole_blocks), '\0');
    if (!WriteAll(descriptor, {staging.data(), whole_blocks})) return false;
  }
  return !direct || ftruncate(descriptor, static_cast<off_t>(content.size)) == 0;
}

const char* KindOf(const fs::file_status& status) {
  switch (status.type()) {
    case fs::file_type::directory:
      return "a folder";
    case fs::file_type::fifo:
      return "a pipe";
    case fs::file_type::socket:
      return "a socket";
    case fs::file_type::block:
    case fs::file_type::character:
      return "a device";
    default:
      return "something else";
  }
}

}  // namespace

fs::path FolderOf(const fs::path& path) {
  return path.parent_path().empty() ? fs::path(".") : path.parent_path();
}

void SyncFolder(const fs::path& folder) { fsync(OpenFolder(folder).Number()); }

bool IsSameFile(int descriptor, const fs::path& path) {
  struct stat of_descriptor {
  }, of_path{};
  return fstat(descriptor, &of_descriptor) == 0 && stat(path.c_str(), &of_path) == 0 &&
         of_descriptor.st_ino == of_path.st_ino && of_descriptor.st_dev == of_path.st_dev;
}

bool WriteAll(int descriptor, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    // Some file systems open files with O_DIRECT but cannot write them.
    if (written < 0 && errno == EINVAL && LeaveDirect(descriptor)) continue;
    if (written <= 0) return false;
    if (static_cast<std::size_t>(written) % kBlock != 0) LeaveDirect(descriptor);
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

fs::path MoveWithoutReplacing(const fs::path& from, const fs::path& to) {
  fs::path name = to;
  for (int number = 2; !MoveToFree(from, name); ++number) {
    if (errno != EEXIST)
      ThrowDiskError(errno, fmt::format("{}: cannot be moved to {}", from.string(), FolderOf(to).string()));
    name = FolderOf(to) / fmt::format("{}-{}{}", to.stem().string(), number, to.extension().string());
  }
  return name;
}

bool LinkOrCopy(const fs::path& from, const fs::path& to) {
  if (link(from.c_str(), to.c_str()) == 0) return true;
  if (errno == EEXIST) return false;
  CopyTo(from, to);
  return true;
}

FileContent ContentOf(std::string_view bytes) {
  return {bytes.size(), [bytes](std::uint64_t offset, std::span<char> out) {
            std::memcpy(out.data(), bytes.data() + offset, out.size());
          }};
}

FileBatch::~FileBatch() {
  if (!committed_) TakeBack();
}

void FileBatch::TakeBack(std::size_t first) {
  for (; files_.size() > first; files_.pop_back()) {
    File& file = files_.back();
    file.descriptor = {};
    if (!file.renamed) unlink(file.temporary.c_str());
    if (file.renamed && !file.replaced) unlink(file.path.c_str());
  }
}

void FileBatch::Write(std::span<const std::pair<fs::path, FileContent>> files) {
  BeginAfterCommit();
  const std::size_t before = files_.size();
  try {
    for (const auto& [path, content] : files) Write(path, content);
  } catch (...) {
    TakeBack(before);
    throw;
  }
}

void FileBatch::Write(const fs::path& path, const FileContent& content) {
  BeginAfterCommit();
  const bool direct = content.size >= kDirectFrom;
  auto [temporary, descriptor] = OpenTemporary(path, direct);
  if (!descriptor.IsOpen()) ThrowDiskError(errno, fmt::format("{}: cannot be written", path.string()));
  files_.push_back({path, temporary, std::move(descriptor)});
  try {
    if (!WriteContent(files_.back().descriptor.Number(), content, direct))
      ThrowDiskError(errno, fmt::format("{}: writing failed", path.string()));
  } catch (...) {
    TakeBack(files_.size() - 1);
    throw;
  }
}

void FileBatch::BeginAfterCommit() {
  if (std::exchange(committed_, false)) files_.clear();
}

void FileBatch::Commit() {
  BeginAfterCommit();
  const auto fail = [&](const File& file, const char* what) {
    const int reason = errno;
    const std::string path = file.path.string();
    TakeBack();
    ThrowDiskError(reason, fmt::format("{}: {}", path, what));
  };
  for (File& file : files_) {
    if (fsync(file.descriptor.Number()) != 0) fail(file, "syncing to disk failed");
    file.descriptor = {};
  }
  std::map<fs::path, FileDescriptor> folders;  // opened before any rename, so that no later step can fail
  try {
    for (const File& file : files_)
      if (const fs::path folder = FolderOf(file.path); !folders.contains(folder))
        folders[folder] = OpenFolder(folder);
  } catch (...) {
    TakeBack();
    throw;
  }
  for (File& file : files_) {
    std::error_code unknown;
    file.replaced = fs::exists(fs::symlink_status(file.path, unknown));
    const bool renamed = existing_ == Existing::kKeep
                             ? RenameToFree(file.temporary, file.path)
                             : rename(file.temporary.c_str(), file.path.c_str()) == 0;
    if (!renamed && existing_ == Existing::kKeep && errno == EEXIST)
      fail(file, "is there already and is kept");
    if (!renamed) fail(file, "cannot be renamed into place");
    file.renamed = true;
  }
  for (const auto& [path, descriptor] : folders) fsync(descriptor.Number());
  committed_ = true;
}

void FileBatch::Commit(const std::function<void()>& note) {
  Commit();
  try {
    note();
  } catch (...) {
    TakeBack();
    throw;
  }
}

void WriteFileAtomically(const fs::path& path, std::string_view bytes) {
  // A pipe or a device takes bytes; it must not be replaced by a file.
  std::error_code unknown;
  if (fs::exists(path, unknown) && !fs::is_regular_file(path, unknown) && !fs::is_directory(path, unknown)) {
    if (std::ofstream stream(path, std::ios::binary);
        !stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size())).flush())
      ThrowDiskError(errno, fmt::format("{}: writing failed", path.string()));
    return;
  }
  RemoveLeftOf(path);
  FileBatch batch;
  batch.Write(path, ContentOf(bytes));
  batch.Commit();
}

void ThrowDiskError(int reason, const std::string& what_failed) {
  if (reason == ENOSPC || reason == EDQUOT)
    throw DiskFullError("{}: {}; free some space", what_failed, std::strerror(reason));
  throw Error("{}: {}; check the folder's permissions and its disk, or choose another folder", what_failed,
              std::strerror(reason));
}

void MakeFolder(const fs::path& folder) {
  std::error_code reason;
  fs::create_directories(folder, reason);
  if (reason || !fs::is_directory(folder))
    ThrowDiskError(reason ? reason.value() : ENOTDIR,
                   fmt::format("{}: the folder cannot be made", folder.string()));
}

std::uint64_t FreeBytes(const fs::path& folder) {
  struct statvfs room {};
  if (statvfs(folder.c_str(), &room) != 0) return std::numeric_limits<std::uint64_t>::max();
  return static_cast<std::uint64_t>(room.f_bavail) * room.f_frsize;
}

std::string ProcessMark() { return fmt::format("{}-{}", ThisComputer(), getpid()); }

bool IsOfEndedProcess(const std::string& mark) {
  const std::string computer = ThisComputer() + "-";
  if (!mark.starts_with(computer)) return false;
  const std::string number = mark.substr(computer.size());
  if (number.empty() || number.size() > 9 || number.find_first_not_of("0123456789") != std::string::npos)
    return false;
  return kill(static_cast<pid_t>(std::atol(number.c_str())), 0) != 0 && errno == ESRCH;
}

fs::path TemporaryName(const fs::path& path) {
  static std::atomic<unsigned> next{1};
  return fmt::format("{}.{}-{}{}", path.string(), ProcessMark(), next++, kTemporaryEnding);
}

bool IsTemporary(const fs::directory_entry& entry) { return MarkOf(entry).has_value(); }

bool IsLeftTemporary(const fs::directory_entry& entry) {
  constexpr std::chrono::hours kLeastAge{1};  // Guessed.
  if (!IsTemporary(entry)) return false;
  if (IsOfDeadProcess(entry)) return true;
  std::error_code gone;
  return entry.last_write_time(gone) < fs::file_time_type::clock::now() - kLeastAge && !gone;
}

void RequireRegularFile(const fs::path& path) {
  std::error_code unknown;
  const fs::file_status status = fs::status(path, unknown);
  if (fs::is_regular_file(status)) return;
  if (!fs::exists(status))
    throw Error("{}: cannot be read: {}", path.string(),
                unknown ? unknown.message() : std::string(std::strerror(ENOENT)));
  throw Error("{}: is {} and no regular file; put a regular file in its place", path.string(),
              KindOf(status));
}

std::ifstream OpenRegularFile(const fs::path& path) {
  RequireRegularFile(path);
  std::ifstream file(path, std::ios::binary);
  if (!file) throw Error("{}: cannot be read: {}", path.string(), std::strerror(errno));
  return file;
}

std::string ReadWholeFile(const fs::path& path) {
  constexpr std::uint64_t kAlwaysFits = 64 << 20;
  const auto fail = [&] { throw Error("{}: cannot be read: {}", path.string(), std::strerror(errno)); };
  const FileDescriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  struct stat status {};
  if (!file.IsOpen() || fstat(file.Number(), &status) != 0) fail();
  if (!S_ISREG(status.st_mode)) RequireRegularFile(path);
  const auto size = static_cast<std::uint64_t>(status.st_size);
  if (size > kAlwaysFits && size > AvailableMemory())
    throw Error("{}: has {:.1f} GB, more than the memory that is left; move it away, or close other programs",
                path.string(), 1e-9 * static_cast<double>(size));
  constexpr std::size_t kOfUnknownSize = 1 << 16;  // files of /proc tell none
  std::string bytes(size > 0 ? size : kOfUnknownSize, '\0');
  std::size_t done = 0;
  while (true) {
    if (done == bytes.size() && size > 0) break;
    if (done == bytes.size()) bytes.resize(2 * done);
    const ssize_t read = ::read(file.Number(), bytes.data() + done, bytes.size() - done);
    if (read < 0 && errno == EINTR) continue;
    if (read < 0) fail();
    if (read == 0) break;  // The file has become shorter.
    done += static_cast<std::size_t>(read);
  }
  bytes.resize(done);
  return bytes;
}

}  // namespace ulf
