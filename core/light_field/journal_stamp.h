// Identifies the journal of a light field for its derived files, by its name, its version and its content.
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

// Returns the stamp of the file's first `bytes`; none if the file is shorter or unreadable.
std::optional<JournalStamp> StampOf(const std::filesystem::path& file, std::uint64_t bytes);
// Returns the stamp of the whole file.
std::optional<JournalStamp> StampOf(const std::filesystem::path& file);

// Thrown for a light field by a newer ulf: it is intact, but this program neither reads nor changes it.
class NewerFormatError : public Error {
 public:
  using Error::Error;
};

}  // namespace ulf
