#include "render/photographs/pyramid_file.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <string>
#include <string_view>

#include "core/base/atomic_file.h"
#include "core/base/file_descriptor.h"
#include "core/geometry/digest.h"

namespace ulf::render {
namespace {

constexpr std::array<char, 8> kMagic{'u', 'l', 'f', 'p', 'y', 'r', '0', '2'};

// The file begins with this, a checksum for each level, and a checksum of everything before it.
struct Head {
  std::array<char, 8> magic = kMagic;
  std::uint64_t key = 0;
  PixelCounts counts = {};
  std::int32_t width = 0, height = 0, type = 0, levels = 0;
};

template <typename T>
std::string_view BytesOf(const T* first, std::size_t count) {
  return {reinterpret_cast<const char*>(first), count * sizeof(T)};
}

std::string_view BytesOf(const cv::Mat& pixels) {
  return {reinterpret_cast<const char*>(pixels.data), pixels.total() * pixels.elemSize()};
}

bool ReadAt(int descriptor, std::uint64_t offset, char* out, std::size_t size) {
  while (size > 0) {
    const ssize_t read = pread(descriptor, out, size, static_cast<off_t>(offset));
    if (read < 0 && errno == EINTR) continue;
    if (read <= 0) return false;
    offset += static_cast<std::uint64_t>(read);
    out += read;
    size -= static_cast<std::size_t>(read);
  }
  return true;
}

bool Append(int descriptor, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

std::size_t HeadBytes(int levels) { return sizeof(Head) + (static_cast<std::size_t>(levels) + 1) * 8; }

}  // namespace

void WritePyramidFile(const std::filesystem::path& path, std::uint64_t key, const ViewPyramid& pyramid,
                      const PixelCounts& counts) {
  const Head head{.key = key,
                  .counts = counts,
                  .width = pyramid.front().cols,
                  .height = pyramid.front().rows,
                  .type = pyramid.front().type(),
                  .levels = static_cast<std::int32_t>(pyramid.size())};
  std::string begin(BytesOf(&head, 1));
  for (const cv::Mat& level : pyramid) {
    const std::uint64_t checksum = FastChecksumOf(BytesOf(level));
    begin += BytesOf(&checksum, 1);
  }
  const std::uint64_t of_begin = FastChecksumOf(begin);
  begin += BytesOf(&of_begin, 1);

  const std::string temporary = TemporaryName(path).string();
  const FileDescriptor file(open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644));
  if (!file.IsOpen()) ThrowDiskError(errno, fmt::format("{}: cannot be written", path.string()));
  bool written = Append(file.Number(), begin);
  for (auto level = pyramid.rbegin(); written && level != pyramid.rend(); ++level)
    written = Append(file.Number(), BytesOf(*level));
  if (!written || rename(temporary.c_str(), path.c_str()) != 0) {
    const int reason = errno;
    unlink(temporary.c_str());
    ThrowDiskError(reason, fmt::format("{}: writing failed", path.string()));
  }
}

std::optional<StoredLevel> ReadPyramidFile(const std::filesystem::path& path, std::uint64_t key,
                                           const Photograph& photograph, int level) {
  const FileDescriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (!file.IsOpen()) return std::nullopt;
  const int levels = photograph.LevelCount();
  std::string begin(HeadBytes(levels), '\0');
  if (!ReadAt(file.Number(), 0, begin.data(), begin.size())) return std::nullopt;
  Head head;
  std::memcpy(&head, begin.data(), sizeof head);
  const auto checksum_at = [&](int n) {
    std::uint64_t checksum = 0;
    std::memcpy(&checksum, begin.data() + sizeof(Head) + 8 * static_cast<std::size_t>(n), 8);
    return checksum;
  };
  if (head.magic != kMagic || head.key != key || head.width != photograph.size().width ||
      head.height != photograph.size().height || head.type != photograph.type() || head.levels != levels ||
      FastChecksumOf(std::string_view(begin).substr(0, begin.size() - 8)) != checksum_at(levels))
    return std::nullopt;
  std::uint64_t offset = begin.size();
  for (int coarser = levels - 1; coarser > level; --coarser) offset += photograph.LevelBytes(coarser);
  cv::Mat pixels(photograph.LevelSize(level), photograph.type());
  if (!ReadAt(file.Number(), offset, reinterpret_cast<char*>(pixels.data), photograph.LevelBytes(level)) ||
      FastChecksumOf(BytesOf(pixels)) != checksum_at(level))
    return std::nullopt;
  return StoredLevel{pixels, head.counts};
}

}  // namespace ulf::render
