// The journal of a light field as its derived files know it: its name, its version and what identifies its
// content.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "core/base/error.h"

namespace ulf {

inline constexpr const char* kJournalFile = "journal.jsonl";
inline constexpr int kJournalVersion = 1;

// Identifies the journal that a derived file was made from: its length and the CRC-32 of that many bytes. It
// reveals a journal that has lost its end or was changed.
struct JournalStamp {
  std::uint64_t bytes = 0;
  std::uint32_t crc32 = 0;
  bool operator==(const JournalStamp&) const = default;
};

// The stamp of the first `bytes` of FILE; none: the file is shorter or unreadable.
std::optional<JournalStamp> StampOf(const std::filesystem::path& file, std::uint64_t bytes);
// The stamp of the whole file.
std::optional<JournalStamp> StampOf(const std::filesystem::path& file);

// A light field by a newer ulf. Nothing is wrong with it, and this program neither reads nor changes it.
class NewerFormatError : public Error {
 public:
  using Error::Error;
};

}  // namespace ulf
